//! Tells the commands what they run on.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=LONGSPAN_HOST={}", std::env::var("TARGET").unwrap_or_default());
}

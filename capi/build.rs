//! Gives the shared library its SONAME, whose number changes with every incompatible change of the ABI, and says whether there are
//! streams.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(streams)");
    let system = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    let is_asked_for = std::env::var_os("CARGO_FEATURE_STREAM").is_some();
    match system.as_str() {
        "linux" | "android" => println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,liblongspan.so.0"),
        "macos" => println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/liblongspan.0.dylib"),
        _ => {}
    }
    if is_asked_for && system == "linux" {
        println!("cargo::rustc-cfg=streams");
    } else if is_asked_for {
        println!("cargo::warning=streams need Linux: the functions are there, and return LS_ERROR_UNSUPPORTED");
    }
}

//! The C example of README.md, compiled and run by the very lines that stand there.

use std::path::Path;
use std::process::Command;

use crate::compiler::{Language, compile};
use crate::library::{Library, output_folder};
use crate::{Outcome, printed, repository, succeed};

/// What README.md calls the example.
const NAME: &str = "fall";

pub fn run() -> Outcome<()> {
    let readme = std::fs::read_to_string(repository().join("README.md"))?;
    let example = blocks(&readme, "c").next().ok_or("README.md has no example in C")?;
    let lines = compiler_lines(&readme);
    if lines.is_empty() {
        return Err(format!("README.md has no line that begins with `cc {NAME}.c`").into());
    }
    let library = Library::build()?;
    let folder = output_folder("readme")?;
    let (source, program) = (folder.join(format!("{NAME}.c")), folder.join(NAME));
    std::fs::write(&source, example)?;

    compile(&source, &program, Language::C99, &library)?;
    print!("the example, compiled strictly:\n{}", printed(&mut Command::new(&program))?);
    for line in lines {
        let mut command = Language::C99.compiler()?;
        command.args(arguments(line, &source, &program, &library.folder)).current_dir(repository());
        succeed(&mut command)?;
        print!("{line}\n{}", printed(&mut Command::new(&program))?);
    }
    Ok(())
}

/// What stands between the fences of this language.
fn blocks<'a>(text: &'a str, language: &str) -> impl Iterator<Item = &'a str> {
    let fence = format!("```{language}\n");
    let starts: Vec<usize> = text.match_indices(&fence).map(|(start, _)| start + fence.len()).collect();
    starts.into_iter().map(|start| text[start..].split("```").next().unwrap_or_default())
}

/// Every line that compiles the example.
fn compiler_lines(readme: &str) -> Vec<&str> {
    let start = format!("cc {NAME}.c ");
    readme.lines().filter(|line| line.starts_with(&start)).collect()
}

/// The arguments of a compiler line, with the files of this run in place of those of the text.
fn arguments(line: &str, source: &Path, program: &Path, library: &Path) -> Vec<String> {
    let command = line.split(" #").next().unwrap_or_default();
    let place = |path: &Path| path.to_string_lossy().into_owned();
    let words = command.split_whitespace().skip(1).map(|word| match word {
        _ if word.strip_suffix(".c") == Some(NAME) => place(source),
        NAME => place(program),
        _ => word.replace("$PWD/target/release", &place(library)).replace("target/release", &place(library)),
    });
    words.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_and_its_compiler_lines_are_found() {
        let readme = "text\n```c\nint main(void)\n```\nmore\n```sh\ncc fall.c -Ltarget/release -o fall   # static\n```\n";
        assert_eq!(blocks(readme, "c").collect::<Vec<_>>(), ["int main(void)\n"]);
        let lines = compiler_lines(readme);
        assert_eq!(lines.len(), 1);
        let words = arguments(lines[0], Path::new("/s/fall.c"), Path::new("/p/fall"), Path::new("/lib"));
        assert_eq!(words, ["/s/fall.c", "-L/lib", "-o", "/p/fall"]);
    }
}

//! The committed header is the one that the library's source says, and keeps what hosts have been compiled against.

mod gate;
#[allow(dead_code, reason = "each test program uses a part of this")]
mod interface;

use std::fs;
use std::path::Path;

/// Where a new part of the header begins: its first function, and its name.
const PARTS: [(&str, &str); 11] = [
    ("ls_result_name_get", "The library"),
    ("ls_shape_def_init", "Definitions"),
    ("ls_world_create", "Worlds"),
    ("ls_world_ray_cast", "Queries"),
    ("ls_draw_init", "Drawing"),
    ("ls_world_save", "Snapshots"),
    ("ls_world_recording_start", "Recordings"),
    ("ls_body_create", "Bodies"),
    ("ls_shape_attach", "Shapes"),
    ("ls_joint_create", "Joints"),
    ("ls_stream_def_init", "Streams"),
];

fn generate() -> String {
    let capi = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(capi.join("cbindgen.toml")).expect("the configuration is valid");
    let bindings = cbindgen::Builder::new().with_crate(capi).with_config(config).generate().expect("the source can be parsed");
    let mut header = Vec::new();
    bindings.write(&mut header);
    arrange(&String::from_utf8(header).expect("a header is text"))
}

/// Comments of one line on one line, functions in parts with titles, and no `struct` where the typedef does.
fn arrange(header: &str) -> String {
    let lines: Vec<&str> = header.lines().collect();
    let (mut arranged, mut i, mut in_functions) = (String::new(), 0, false);
    while i < lines.len() {
        let text = |line: &str| line.trim_start().trim_start_matches("* ").to_owned();
        let mut line = lines[i].to_owned();
        if line.trim() == "/**" {
            let end = i + lines[i..].iter().position(|line| line.trim() == "*/").expect("comments end");
            if let Some((_, title)) = PARTS.iter().find(|(function, _)| lines[end + 1].contains(&format!("{function}("))) {
                in_functions = true;
                arranged.push_str(&format!("/* {title} {} */\n\n", "-".repeat(112 - title.len())));
            }
            if end == i + 2 {
                line.push_str(&format!(" {} */", text(lines[i + 1])));
                i = end;
            }
        } else if in_functions {
            line = line.replace("struct Ls", "Ls");
        }
        arranged.push_str(&line);
        arranged.push('\n');
        i += 1;
    }
    arranged
}

/// The comment above line `i`, if there is one.
fn comment<'a>(lines: &'a [&'a str], i: usize) -> Option<&'a [&'a str]> {
    let end = i.checked_sub(1).filter(|&end| lines[end].ends_with("*/"))?;
    let start = (0..=end).rev().find(|&start| lines[start].trim_start().starts_with("/**"))?;
    Some(&lines[start..=end])
}

#[test]
fn the_committed_header_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../include/longspan/longspan.h");
    let generated = generate();
    if std::env::var_os("LONGSPAN_BLESS").is_some() {
        fs::create_dir_all(path.parent().expect("the header lies in a folder")).expect("the folder can be made");
        fs::write(&path, &generated).expect("the header can be written");
    }
    let committed = fs::read_to_string(&path).unwrap_or_default();
    let line = committed.lines().zip(generated.lines()).take_while(|(a, b)| a == b).count() + 1;
    assert!(
        committed == generated,
        "longspan.h is stale from line {line}; LONGSPAN_BLESS=1 cargo test -p longspan-capi --test header"
    );
}

#[test]
fn every_symbol_of_the_header_has_a_comment() {
    let header = generate();
    let lines: Vec<&str> = header.lines().collect();
    let field = |line: &str| line.starts_with("    ") && !line[4..].starts_with([' ', '*', '/']) && line.ends_with(';');
    let symbol = |line: &str| line.starts_with("#define LS_") || line.starts_with("typedef ") || function(line) || field(line);
    let symbols: Vec<usize> = (0..lines.len()).filter(|&i| symbol(lines[i])).collect();
    let bare: Vec<&str> = symbols.iter().filter(|&&i| comment(&lines, i).is_none()).map(|&i| lines[i]).collect();
    assert!(symbols.len() > 300, "only {} symbols were recognised", symbols.len());
    assert!(bare.is_empty(), "without a comment: {bare:#?}");
}

#[test]
fn every_function_says_what_it_returns_and_where_it_may_be_called() {
    let header = generate();
    let lines: Vec<&str> = header.lines().collect();
    let functions: Vec<usize> = (0..lines.len()).filter(|&i| function(lines[i])).collect();
    let silent: Vec<String> = functions
        .iter()
        .filter_map(|&i| {
            let text = comment(&lines, i)?.concat();
            let missing: Vec<&str> =
                ["@return", "Threads:", "Callbacks:"].into_iter().filter(|part| !text.contains(part)).collect();
            (!missing.is_empty()).then(|| format!("{}: {missing:?}", lines[i]))
        })
        .collect();
    assert!(functions.len() > 70, "only {} functions were recognised", functions.len());
    assert!(silent.is_empty(), "{silent:#?}");
}

#[test]
fn every_float_has_a_unit_or_says_that_it_is_a_plain_number() {
    /// What a comment may say instead of a unit in brackets.
    const PLAIN: [&str; 5] = ["unit", "coefficient", "factor", "fraction", "speed over approach speed"];
    let header = generate();
    let lines: Vec<&str> = header.lines().collect();
    let has_float = |line: &str| line.contains("float ") || line.contains("double ");
    let units = ["(m", "(s", "(kg", "(N", "(rad", "(1/"];
    let says = |text: &str| units.iter().chain(&PLAIN).any(|word| text.contains(word));
    let field = |line: &str| line.starts_with("    ") && line.ends_with(';');
    let (mut floats, mut bare) = (0, Vec::new());
    for (i, line) in lines.iter().enumerate() {
        if !(field(line) || function(line)) || !has_float(&statement(&lines, i)) {
            continue;
        }
        floats += 1;
        if !comment(&lines, i).is_some_and(|text| says(&text.concat().to_lowercase().replace("(n", "(N"))) {
            bare.push(*line);
        }
    }
    assert!(floats > 80, "only {floats} fields and functions with floats were recognised");
    assert!(bare.is_empty(), "without a unit: {bare:#?}");
}

#[test]
fn every_function_names_the_errors_that_its_arguments_can_have() {
    let header = generate();
    let lines: Vec<&str> = header.lines().collect();
    let mut silent = Vec::new();
    for (i, line) in lines.iter().enumerate().filter(|(_, line)| line.starts_with("LsResult ls_")) {
        let (text, arguments) = (comment(&lines, i).unwrap_or_default().concat(), statement(&lines, i));
        let arguments = arguments.split_once('(').map_or("", |(_, rest)| rest).to_owned();
        let mut expect = |present: bool, error: &str| {
            if present && !text.contains(error) {
                silent.push(format!("{line}: {error}"));
            }
        };
        // A callback's own user pointer may be anything.
        expect(arguments.contains('*') && !arguments.contains("void *user"), "LS_ERROR_NULL_ARGUMENT");
        let ends_a_world = line.contains("ls_world_destroy");
        expect(arguments.contains("LsWorld world") && !ends_a_world, "a world error");
        for object in ["LsBody body", "LsShape shape", "LsJoint joint"] {
            expect(arguments.contains(object), "a handle error");
        }
        expect(arguments.contains("size_t size"), "LS_ERROR_STRUCT_SIZE");
    }
    assert!(silent.is_empty(), "{silent:#?}");
}

/// The statement that begins at line `i`, on one line.
fn statement(lines: &[&str], i: usize) -> String {
    let end = lines[i..].iter().position(|line| line.contains(';')).map_or(i, |length| i + length);
    lines[i..=end].iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ")
}

fn function(line: &str) -> bool {
    line.starts_with("LsResult ls_") || line.starts_with("const char *ls_")
}

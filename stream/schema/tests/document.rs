//! The tables of docs/reference/stream-bytes.md are what the structs are. `LONGSPAN_BLESS=1` writes them.

use std::fmt::Write as _;
use std::path::Path;

use longspan_stream_schema::{LAYOUT_HASH, RECORDS, Record};

const BEGIN: &str = "<!-- tables begin -->\n";
const END: &str = "<!-- tables end -->\n";

fn tables() -> String {
    let mut text = format!("Layout hash: `{LAYOUT_HASH:#018x}`\n");
    for Record { name, size, fields, .. } in RECORDS {
        let _ = write!(text, "\n### {name}, {size} bytes\n\n| offset | bytes | field |\n|---|---|---|\n");
        for (index, field) in fields.iter().enumerate() {
            let end = fields.get(index + 1).map_or(*size, |next| next.offset);
            let _ = writeln!(text, "| {} | {} | `{}` |", field.offset, end - field.offset, field.name);
        }
    }
    text
}

#[test]
fn the_document_of_the_bytes_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/stream-bytes.md");
    let document = std::fs::read_to_string(&path).expect("the document is there");
    let (before, rest) = document.split_once(BEGIN).expect("the document says where the tables begin");
    let (found, after) = rest.split_once(END).expect("and where they end");
    if std::env::var_os("LONGSPAN_BLESS").is_some() {
        std::fs::write(&path, format!("{before}{BEGIN}{}{END}{after}", tables())).expect("the document can be written");
        return;
    }
    assert_eq!(found, tables(), "LONGSPAN_BLESS=1 cargo test -p longspan-stream-schema --test document writes the tables");
}

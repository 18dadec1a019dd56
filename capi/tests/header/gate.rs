//! The gate of the binary interface: what hosts have been compiled against stays, and may only grow.

use std::fs;
use std::path::Path;

use crate::interface::Interface;

const INTRODUCTION: &str = "# What hosts have been compiled against: see docs/reference/abi.md. LONGSPAN_BLESS=1 cargo test -p longspan-capi \
                            --test header adds what is new.\n\n";

#[test]
fn nothing_that_a_host_was_compiled_against_has_changed() {
    let (path, now) = (Path::new(env!("CARGO_MANIFEST_DIR")).join("abi/baseline.txt"), Interface::of_header(&crate::generate()));
    let blessed = std::env::var_os("LONGSPAN_BLESS").is_some();
    let text = fs::read_to_string(&path).unwrap_or_default();
    if text.is_empty() && blessed {
        fs::write(&path, format!("{INTRODUCTION}{now}")).expect("the baseline can be written");
    }
    let text = fs::read_to_string(&path).expect("the baseline is there");
    let before = Interface::parse(&text);
    let broken = before.broken_by(&now);
    let renumbered = now.number() > before.number();
    assert!(broken.is_empty() || renumbered, "these need a new LS_ABI_VERSION (docs/reference/abi.md): {broken:#?}");
    if blessed {
        fs::write(&path, format!("{INTRODUCTION}{now}")).expect("the baseline can be written");
    }
    let listed = Interface::parse(&fs::read_to_string(&path).expect("the baseline is there"));
    let (functions, structs) = (now.functions.len(), now.structs.len());
    println!("{functions} functions, {} constants, {structs} structs", now.constants.len());
    assert!(functions > 80 && now.constants.len() > 60 && structs > 20, "{functions} functions, {structs} structs");
    assert!(listed == now, "the baseline lacks what is new; LONGSPAN_BLESS=1 cargo test -p longspan-capi --test header");
}

/// Changes a text that must be in the header.
fn changed(header: &str, old: &str, new: &str) -> Vec<String> {
    assert!(header.contains(old), "the header has no `{old}`");
    Interface::of_header(header).broken_by(&Interface::of_header(&header.replacen(old, new, 1)))
}

#[test]
fn the_gate_notices_every_kind_of_incompatible_change() {
    let header = crate::generate();
    let one = |old: &str, new: &str, about: &str| {
        let broken = changed(&header, old, new);
        assert!(broken.len() == 1 && broken[0].contains(about), "`{old}` → `{new}`: {broken:?}");
    };
    one("LsResult ls_body_wake(LsWorld world, LsBody body);", "", "function ls_body_wake is gone");
    one("LsResult ls_body_wake(LsWorld world, LsBody body);", "LsResult ls_body_wake(LsWorld world);", "ls_body_wake was");
    one(
        "LsResult ls_body_wake(LsWorld world, LsBody body);",
        "LsResult ls_body_wake(LsWorld world, LsShape body);",
        "ls_body_wake",
    );
    one("#define LS_JOINT_HINGE 1", "#define LS_JOINT_HINGE 2", "constant LS_JOINT_HINGE was `1` and is `2`");
    one("#define LS_JOINT_HINGE 1", "", "constant LS_JOINT_HINGE is gone");
    one("    float compliance;", "    double compliance;", "struct LsSoftness");
    one("    uint32_t substeps;", "", "struct LsWorldDef");
    one("typedef int32_t LsResult;", "typedef int64_t LsResult;", "type LsResult");
    let order =
        |text: &str| text.replacen("    float min;", "    float swapped;", 1).replacen("    float max;", "    float min;", 1);
    let swapped = order(&header).replacen("    float swapped;", "    float max;", 1);
    let broken = Interface::of_header(&header).broken_by(&Interface::of_header(&swapped));
    assert!(broken.len() == 1 && broken[0].contains("struct LsLimits"), "two fields in another order: {broken:?}");
    let grown = changed(&header, "} LsRay;", "    float width;\n} LsRay;");
    assert!(grown.len() == 1 && grown[0].contains("LsRay never grows"), "{grown:?}");
}

#[test]
fn the_gate_lets_additions_pass() {
    let header = crate::generate();
    for (old, new) in [
        ("} LsBodyDef;", "    uint32_t buoyant;\n} LsBodyDef;"),
        ("} LsStepReport;", "    float heat;\n} LsStepReport;"),
        ("LsResult ls_body_wake(", "LsResult ls_body_wake_gently(LsWorld world);\n\nLsResult ls_body_wake("),
        ("#define LS_JOINT_HINGE 1", "#define LS_JOINT_HINGE 1\n#define LS_JOINT_GEAR 99"),
        ("LsResult ls_body_wake(LsWorld world, LsBody body);", "LsResult ls_body_wake(LsWorld globe, LsBody corpse);"),
    ] {
        let broken = changed(&header, old, new);
        assert!(broken.is_empty(), "`{old}` → `{new}`: {broken:?}");
    }
}

//! Whatever a host in Rust can do with a world, one in C can do too.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Methods whose function in C is named by another rule than the usual one.
const OTHERWISE: &[(&str, &str)] = &[
    ("new", "ls_world_create"),
    ("poses_into", "ls_world_poses_get"),
    ("mass_properties", "ls_body_mass_get"),
    ("contacts_of", "ls_body_contacts_get"),
    ("chain", "ls_chain_state_get"),
    ("bodies", "ls_world_bodies_get"),
    ("joints", "ls_world_joints_get"),
    ("joint_shares_into", "ls_joint_shares_get"),
    ("create_cells", "ls_world_cells_create"),
    ("contacts", "ls_world_contacts_get"),
    ("set_support", "ls_support_enabled_set"),
    ("support", "ls_support_get"),
    ("support_into", "ls_support_get"),
    ("supported_count", "ls_support_count_get"),
    ("support_changes", "ls_support_changes_get"),
    ("support_hull", "ls_support_hull_get"),
    ("supporters", "ls_support_carriers_get"),
    ("supported_by", "ls_support_carried_get"),
    ("load_on", "ls_support_load_get"),
    ("load_between", "ls_support_load_between_get"),
    ("path_to_ground", "ls_support_path_get"),
    ("would_lose_support", "ls_support_loss_predict"),
    ("union_of", "ls_body_union_get"),
    ("apply_fractures", "ls_world_fractures_apply"),
    ("broken", "ls_world_joint_breaks_get"),
    ("contact_began", "ls_world_contacts_begun_get"),
    ("contact_ended", "ls_world_contacts_ended_get"),
    ("moved", "ls_world_moved_bodies_get"),
    ("overlap_box", "ls_world_box_overlaps_get"),
    ("overlap_shape", "ls_world_shape_overlaps_get"),
    ("overloaded", "ls_world_overloaded_joints_get"),
    ("put_to_sleep", "ls_body_sleep"),
    ("quarantined", "ls_world_quarantined_bodies_get"),
    ("sensed", "ls_world_sensor_overlaps_get"),
    ("sensor_began", "ls_world_sensor_overlaps_begun_get"),
    ("sensor_ended", "ls_world_sensor_overlaps_ended_get"),
];

/// What a function does, at the end of its name.
const VERBS: &[&str] = &[
    "add",
    "add_at",
    "apply",
    "attach",
    "cast",
    "cast_all",
    "close",
    "create",
    "destroy",
    "draw",
    "get",
    "init",
    "move_to",
    "next",
    "open",
    "poll",
    "predict",
    "record",
    "remove",
    "replay",
    "restore",
    "save",
    "seek",
    "serve",
    "set",
    "sleep",
    "start",
    "start_to_file",
    "step",
    "stop",
    "wake",
];

/// Methods that only streams need.
const FOR_STREAMS: &[&str] = &["structure_version", "state_version"];

/// Methods that take what only Rust has: a host in C gives its threads by `ls_world_parallel_for_set`.
const FOR_RUST: &[&str] = &["set_thread_pool"];

const NOUNS: [&str; 4] = ["world", "body", "shape", "joint"];

/// Every public method of `World`, from the files that hold its `impl` blocks.
fn methods() -> BTreeSet<String> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../src");
    let mut methods = BTreeSet::new();
    let mut folders = vec![source];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("the source is there") {
            let path = entry.expect("the source can be listed").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let text = fs::read_to_string(&path).expect("the source is text");
                for block in text.split("\nimpl World {").skip(1) {
                    let block = block.split("\n}\n").next().unwrap_or_default();
                    let names = block.split("\n    pub fn ").skip(1).filter_map(|rest| rest.split(['(', '<']).next());
                    methods.extend(names.map(str::to_owned));
                }
            }
        }
    }
    methods
}

fn functions() -> BTreeSet<String> {
    let header = Path::new(env!("CARGO_MANIFEST_DIR")).join("../include/longspan/longspan.h");
    let header = fs::read_to_string(header).expect("the header is there");
    let names = header.lines().filter(|line| line.starts_with("LsResult ls_")).filter_map(|line| line.split([' ', '(']).nth(1));
    names.map(str::to_owned).collect()
}

/// The names that a method may have in C: `ls_<noun>_<what>`, with `_get` or `_set` where it is a value; `add_force_at` is
/// `ls_body_force_add_at`.
fn candidates(method: &str) -> Vec<String> {
    let (what, verb) = match method.strip_prefix("set_") {
        Some(what) => (what, "_set"),
        None => (method.strip_prefix("is_").unwrap_or(method), "_get"),
    };
    let mut names = Vec::new();
    for noun in NOUNS {
        let bare = what.strip_prefix(noun).and_then(|rest| rest.strip_prefix('_')).or(what.strip_suffix(noun));
        for what in [Some(what), bare].into_iter().flatten() {
            let what = what.trim_end_matches('_');
            names.extend([format!("ls_{noun}_{what}"), format!("ls_{noun}_{what}{verb}")]);
            if let Some((first, rest)) = what.split_once('_').filter(|(first, _)| ["add", "cast"].contains(first)) {
                let (object, how) =
                    ["_at", "_all"].into_iter().find_map(|how| Some((rest.strip_suffix(how)?, how))).unwrap_or((rest, ""));
                names.push(format!("ls_{noun}_{object}_{first}{how}"));
            }
        }
    }
    names
}

#[test]
fn every_public_method_of_a_world_has_a_function_in_c() {
    let (methods, functions) = (methods(), functions());
    let known = |method: &str| {
        let otherwise = OTHERWISE.iter().find(|(name, _)| *name == method);
        otherwise.map_or_else(
            || candidates(method).iter().any(|name| functions.contains(name)),
            |(_, function)| functions.contains(*function),
        )
    };
    let exempt = [FOR_STREAMS, FOR_RUST].concat();
    let missing: Vec<&String> = methods.iter().filter(|method| !known(method) && !exempt.contains(&method.as_str())).collect();
    println!("{} methods, {} functions", methods.len(), functions.len());
    assert!(methods.len() > 80, "only {} methods were found", methods.len());
    assert!(missing.is_empty(), "without a function in C, or one that this test does not find: {missing:?}");
}

#[test]
fn names_of_functions_end_with_what_they_do() {
    let functions = functions();
    let odd: Vec<&String> =
        functions.iter().filter(|name| !VERBS.iter().any(|verb| name.ends_with(&format!("_{verb}")))).collect();
    assert!(functions.len() > 150, "only {} functions were found", functions.len());
    assert!(odd.is_empty(), "no verb at the end, or one that this test does not know: {odd:?}");
}

//! Scenes keep their promises at other rates and sizes: at 30, 120 and 240 steps a second, and a tenth and ten times as large on the same
//! earth. All bounds are in the scene's own units, so that one holds for all of them. `longspan-bench holdout-table` tries other numbers
//! of links, stones and loads as well.

use longspan_scenes::promises::{AT, CONTACTS, JOINTS, Promise, has_key, judge};

fn keep(promises: &[Promise]) {
    let mut broken = Vec::new();
    for &promise in promises {
        let name = promise.0;
        let has_rate = has_key(name, "rate").expect("a scene of the catalogue");
        for (at, keys) in AT.into_iter().filter(|(_, keys)| has_rate || keys.iter().all(|(key, _)| *key != "rate")) {
            let kept = judge(promise, keys).unwrap_or_else(|error| panic!("{name} at {at}: {error}"));
            if kept.share > 1.0 {
                broken.push(format!("{name} at {at}: {} is {:.4e}, {:.3} of its bound", kept.error, kept.found, kept.share));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

// In two tests, which run side by side.
#[test]
fn what_hangs_and_spans_keeps_its_promise_at_other_rates_and_sizes() {
    keep(&JOINTS[..JOINTS.len() / 2]);
}

#[test]
fn ropes_on_drums_loops_and_motors_keep_their_promise_at_other_rates_and_sizes() {
    keep(&JOINTS[JOINTS.len() / 2..]);
}

#[test]
fn what_stands_slides_and_flies_keeps_its_promise_at_other_rates_and_sizes() {
    keep(CONTACTS);
}

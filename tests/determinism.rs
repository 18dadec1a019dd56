//! The same calls give the same bits.

mod common;

use common::{Run, scene};
use longspan::Pose;
use longspan::glam::Vec3;

fn hash_on(threads: usize, name: &str, keys: &[(&str, &str)]) -> u64 {
    Run::on_threads(scene(name, keys), threads).world().state_hash()
}

#[track_caller]
fn same_on_any_number_of_threads(name: &str, keys: &[(&str, &str)]) {
    let one = hash_on(1, name, keys);
    for threads in [2, 4] {
        assert_eq!(hash_on(threads, name, keys), one, "{name}: state hashes on {threads} threads and on one");
    }
}

#[test]
fn a_pile_has_the_same_bits_on_any_number_of_threads() {
    same_on_any_number_of_threads("pile", &[("n", "1000"), ("seconds", "10")]);
}

#[test]
fn a_tower_has_the_same_bits_on_any_number_of_threads_while_it_stands_and_falls() {
    same_on_any_number_of_threads("tower", &[("seconds", "11")]);
}

#[test]
fn jointed_bodies_have_the_same_bits_on_any_number_of_threads() {
    same_on_any_number_of_threads("violent", &[("what", "joints"), ("n", "200"), ("seconds", "2")]);
}

#[test]
fn two_runs_have_the_same_bits() {
    let keys = [("n", "300"), ("seconds", "5")];
    assert_eq!(hash_on(1, "pile", &keys), hash_on(1, "pile", &keys), "state hashes of two runs");
}

/// Poses and velocities of the last `count` bodies after each step of a scene, with some of another scene's bodies created first.
fn states_beside(strangers: usize) -> Vec<Vec<(Pose, Vec3, Vec3)>> {
    let mut scene = scene("column", &[("n", "8"), ("scatter_mm", "100"), ("gap_mm", "20"), ("seconds", "3")]);
    let mut others = common::scene("pile", &[("n", "100")]).bodies;
    others.truncate(strangers);
    for def in &mut others {
        def.pose.position.x += 200.0;
    }
    let own = scene.bodies.len();
    scene.bodies.splice(0..0, others);
    scene.metrics.clear();
    let mut states = Vec::new();
    Run::watched(scene, |view| {
        let state = |body| (view.engine.pose(body), view.engine.linear_velocity(body), view.engine.angular_velocity(body));
        states.push((strangers..strangers + own).map(state).collect());
    });
    states
}

#[test]
fn unrelated_bodies_change_no_bit_of_an_island() {
    let alone = states_beside(0);
    let beside = states_beside(90);
    let differs = alone.iter().zip(&beside).position(|(alone, beside)| alone != beside);
    assert_eq!(differs, None, "first step after which a falling column differs beside 90 bodies 200 m away");
}

//! What is built loosely, or loses a stone, comes to rest; what must fall falls in its time.

use crate::common::Run;
use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Pose, Shape, ShapeDef, SleepSettings, World, WorldDef};

/// A tower of a thousand blocks with gaps, scattered by ±1 mm and ±0.2°.
const LOOSE: [(&str, &str); 4] = [("loose", "on"), ("scatter_mm", "1"), ("scatter_deg", "0.2"), ("ball", "off")];

#[test]
fn a_loosely_built_tower_settles_and_is_held_within_two_seconds() {
    // Of these, momentum across gravity that is left to the sweeps had the first and the last sway for ten seconds and more.
    for seed in ["2", "3", "20"] {
        let run = Run::of("tower", &[&LOOSE[..], &[("seed", seed), ("stand", "3"), ("seconds", "3")]].concat());
        run.keeps("settled_s", 2.0, "s");
        run.keeps("late_drift_m", 2e-3, "m");
        let held = run.world().report().counts.bodies_held;
        assert_eq!(held, 1000, "blocks of seed {seed} that are held after three seconds");
    }
}

#[test]
fn a_tower_that_stands_neither_drifts_nor_sinks() {
    let run = Run::of("tower", &[("seconds", "10"), ("ball", "off")]);
    run.keeps("drift_m", 1e-3, "m");
    run.keeps("sink_m", 1e-3, "m");
}

#[test]
fn a_tower_loses_five_bottom_blocks_and_little_more() {
    for choice in ["1", "17"] {
        let keys = [("remove", "5"), ("choice", choice), ("ball", "off"), ("stand", "1"), ("seconds", "4")];
        // Converged, about ten move; twice that is allowed.
        Run::of("tower", &keys).keeps("blocks_moved", 20.0, "blocks");
    }
}

#[test]
fn light_boxes_carry_one_ten_thousand_times_heavier_over_any_gap() {
    for gap in ["0", "0.1", "1"] {
        let run = Run::of("heavy_on_light", &[("gap_mm", gap)]);
        run.is("stood", 1.0);
        run.keeps("pen_end_m", 1e-3, "m");
    }
}

#[test]
fn a_box_beyond_the_edge_of_a_stack_falls_as_from_a_rigid_one() {
    // The stack has to take the push of the box that rolls off it; it fell 7.9 % early while that was left to the sweeps.
    Run::of("heavy_on_light", &[("ratio", "1"), ("offset", "0.6")]).keeps("fall_time_err_pct", 5.0, "%");
}

#[test]
fn a_box_beyond_the_edge_of_a_stack_a_thousandth_as_heavy_falls_as_from_a_strut() {
    // Sweeps leave the light boxes unbalanced: it fell 22 and 23 % early.
    for (offset, ratio) in [("0.6", "1000"), ("0.6", "10000"), ("0.8", "10000")] {
        let run = Run::of("heavy_on_light", &[("ratio", ratio), ("offset", offset), ("seconds", "0.5")]);
        run.keeps("fall_time_err_pct", 2.0, "%");
    }
}

#[test]
fn columns_keep_their_height() {
    let run = Run::of("column", &[("n", "100")]);
    run.is("stood", 1.0);
    // A ten-thousandth of a millimetre for each box, where none is measured.
    run.keeps("sink_m", 1e-5, "m");
    Run::of("column", &[("n", "1000"), ("seconds", "10")]).is("stood", 1.0);
}

/// A ring of forty blocks a course, 25 courses high: solved in each step, never held. Its kinetic energy after so many seconds (J).
fn energy_of_a_solved_tower(rate: f32, substeps: u32, seconds: f32) -> f64 {
    let def = WorldDef {
        substeps,
        hold: false,
        sleep: SleepSettings { enabled: false, ..SleepSettings::default() },
        ..WorldDef::default()
    };
    let mut world = World::new(&def).unwrap();
    let stone = |half: Vec3| ShapeDef { density: 2000.0, ..ShapeDef::new(Shape::cuboid(half).unwrap()) };
    world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(stone(Vec3::new(60.0, 0.5, 60.0)))).unwrap();
    let radius = 3.0;
    let blocks: Vec<_> = (0..1000)
        .map(|i| {
            let (course, place) = (i / 40, i % 40);
            let angle = std::f64::consts::TAU * (f64::from(place) + 0.5 * f64::from(course % 2)) / 40.0;
            let at = DVec3::new(radius * angle.cos(), 0.125 * f64::from(2 * course + 1), radius * angle.sin());
            let pose = Pose { position: at, rotation: Quat::from_rotation_y(-angle as f32) };
            world.create_body(&BodyDef::dynamic(pose).with_shape(stone(Vec3::new(0.15, 0.125, 0.22)))).unwrap()
        })
        .collect();
    for _ in 0..(seconds * rate) as usize {
        world.step(1.0 / rate).unwrap();
    }
    let energy = |&block: &BodyId| {
        let mass = 8.0 * 0.15 * 0.125 * 0.22 * 2000.0;
        0.5 * mass * f64::from(world.linear_velocity(block).unwrap().length_squared())
    };
    blocks.iter().map(energy).sum()
}

#[test]
fn a_tower_that_is_solved_stands_as_one_that_is_held() {
    for (rate, substeps, seconds) in [(60.0, 4, 10.0), (60.0, 8, 6.0), (120.0, 4, 6.0)] {
        let energy = energy_of_a_solved_tower(rate, substeps, seconds);
        // A tenth of a microjoule is 1.7 µm/s of each block. It grew by a factor of 60 in 2.5 s, to 3e-4 J after ten and 600 J after twenty,
        // while loaded points closed their gaps by multipliers and both ways of a sweep went through friction first.
        assert!(energy < 1.0e-7, "{rate} Hz, {substeps} substeps, {seconds} s: {energy:e} J");
    }
}

#[test]
fn a_stack_at_rest_keeps_its_manifolds() {
    // Solved, not held. A margin that was remembered smaller than it was asked for had every manifold made anew in every step.
    let run = Run::of("column", &[("n", "10"), ("seconds", "2"), ("support", "off")]);
    let counts = run.world().report().counts;
    assert_eq!((counts.bodies_held, counts.pairs_updated), (0, 0), "bodies held, and pairs made anew of {}", counts.pairs);
}

//! What stands, stands; what sleeps, wakes when it must; nothing passes through anything, and no scene gains energy.

use crate::common::{Run, scene};
use longspan::glam::{DVec3, Vec3};
use longspan::{BoundKind, BoundState};
use longspan_scenes::{Action, Effort, LongspanEngine, run};

#[test]
fn twenty_boxes_stand_a_minute_awake() {
    let run = Run::of("column", &[("sleep", "off")]);
    run.is("stood", 1.0);
    run.keeps("drift_m", 1e-3, "m");
    run.keeps("sink_m", 1e-3, "m");
}

#[test]
fn twenty_boxes_stand_a_minute_and_fall_asleep() {
    let run = Run::of("column", &[("sleep", "on")]);
    run.is("stood", 1.0);
    run.keeps("drift_m", 1e-3, "m");
    run.keeps("sink_m", 1e-3, "m");
    run.is("awake_end", 0.0);
}

#[test]
fn a_column_at_rest_does_not_creep() {
    let run = Run::of("column", &[("seconds", "10")]);
    run.keeps("pose_speed_max", 1e-3, "m/s");
    run.keeps("speed_max", 1e-3, "m/s");
}

#[test]
fn ten_equal_boxes_do_not_sink_into_one_another() {
    let run = Run::of("heavy_on_light", &[("ratio", "1")]);
    run.is("stood", 1.0);
    run.keeps("pen_end_m", 2e-4, "m");
}

#[test]
fn ten_equal_boxes_at_rest_do_not_creep() {
    let run = Run::of("heavy_on_light", &[("ratio", "1")]);
    run.keeps("pose_speed_max", 1e-3, "m/s");
    run.keeps("speed_max", 1e-3, "m/s");
}

#[test]
fn a_box_a_hundred_times_heavier_is_carried() {
    let run = Run::of("heavy_on_light", &[("ratio", "100")]);
    run.is("stood", 1.0);
    run.keeps("pen_end_m", 8e-3, "m");
}

#[test]
fn a_tower_of_a_thousand_blocks_stands_ten_seconds() {
    let run = Run::of("tower", &[("seconds", "10"), ("ball", "off")]);
    run.keeps("drift_m", 0.04, "m");
}

#[test]
fn a_box_born_half_inside_the_floor_leaves_it_gently() {
    let run = Run::of("half_sunk", &[]);
    run.keeps("pose_speed_max", 1.0, "m/s");
    run.keeps("speed_max", 1.0, "m/s");
    // It does leave: a box of 1 m at rest on a floor overlaps by less than a millimetre.
    run.keeps("pen_end_m", 1e-3, "m");
}

#[test]
fn a_pile_of_a_thousand_comes_to_rest() {
    let run = Run::of("pile", &[]);
    run.is("escaped", 0.0);
    run.keeps("mean_speed_end", 0.01, "m/s");
}

#[test]
fn an_arch_stands_by_friction() {
    Run::of("arch", &[]).is("stood", 1.0);
}

#[test]
fn an_arch_falls_when_friction_is_too_low() {
    // The thrust of a semicircle of eleven wedges leaves the springing by more than atan 0.2.
    Run::of("arch", &[("friction", "0.2")]).is("stood", 0.0);
}

#[test]
fn a_house_of_cards_stands_by_friction() {
    Run::of("card_house", &[]).is("stood", 1.0);
}

#[test]
fn a_house_of_cards_falls_when_friction_is_too_low() {
    // Cards lean by 20° and push their feet apart: below half of tan 20° = 0.36 nothing holds them.
    Run::of("card_house", &[("friction", "0.1")]).is("stood", 0.0);
}

#[test]
fn a_fast_ball_does_not_pass_a_thin_wall() {
    for wall in ["1", "10", "100"] {
        Run::of("bullet", &[("speed", "500"), ("wall_mm", wall)]).is("escaped", 0.0);
    }
}

/// Steps after which a column of five boxes has long been asleep.
const ASLEEP: u32 = 180;

/// How many boxes of a column of five are awake when it is left alone, and ten steps after an action on the sleeping column.
fn awake_before_and_after(action: Action) -> (usize, usize) {
    let mut scene = scene("column", &[("n", "5"), ("sleep", "on"), ("seconds", "4")]);
    scene.at(ASLEEP, action);
    let (mut before, mut after) = (0, 0);
    Run::watched(scene, |view| {
        let awake = view.dynamic().filter(|&body| body <= 5 && view.engine.is_awake(body)).count();
        if view.step == ASLEEP {
            before = awake;
        } else if view.step == ASLEEP + 10 {
            after = awake;
        }
    });
    (before, after)
}

#[test]
fn a_sleeping_stack_wakes_when_its_base_is_destroyed() {
    assert_eq!(awake_before_and_after(Action::Remove(1)), (0, 4), "boxes awake before and after");
}

#[test]
fn a_sleeping_stack_falls_when_its_base_is_destroyed() {
    let mut scene = scene("column", &[("n", "5"), ("sleep", "on"), ("seconds", "5")]);
    scene.at(ASLEEP, Action::Remove(1));
    let run = Run::on_threads(scene, 1);
    let height = run.world().pose(run.engine.body_id(5)).expect("the top box exists").position.y;
    assert!((height - 3.5).abs() < 0.01, "the top box lies at {height} m, expected 3.5 m: four boxes on the floor");
}

#[test]
fn a_sleeping_stack_wakes_when_it_is_hit() {
    let mut thrown = scene("bounce", &[]).bodies[1].clone();
    thrown.pose.position = longspan::glam::DVec3::new(-1.0, 2.5, 0.0);
    thrown.linear_velocity = Vec3::X * 10.0;
    assert_eq!(awake_before_and_after(Action::Add(thrown)), (0, 5), "boxes awake before and after");
}

#[test]
fn a_sleeping_stack_wakes_when_gravity_changes() {
    assert_eq!(awake_before_and_after(Action::SetGravity(Vec3::X * 9.81)), (0, 5), "boxes awake before and after");
}

#[test]
fn two_worlds_do_not_affect_each_other() {
    let keys = [("n", "60"), ("seconds", "3")];
    let alone = Run::of("pile", &keys).world().state_hash();
    // A second world takes a step after each of the first one's.
    let other_scene = scene("tower", &[("bodies", "80"), ("seconds", "0.1"), ("ball", "off")]);
    let mut other = LongspanEngine::new(&other_scene.world, Effort::Default, 1).expect("the scene's world is valid");
    run(other_scene, &mut other, Effort::Default, 1).expect("the tower runs");
    let beside = Run::watched(scene("pile", &keys), |_| {
        other.world_mut().step(1.0 / 90.0).expect("the other world steps");
    });
    assert_eq!(beside.world().state_hash(), alone, "state hashes beside another world and alone");
}

#[test]
fn a_sheet_left_to_sweeps_hangs_together() {
    // Let go under seven of its 2500 balls. Two sweeps a substep tore it open by 0.7 m, and further with every second.
    let run = Run::of("joint_grid", &[("n", "50"), ("solver", "gs"), ("seconds", "2")]);
    run.keeps("joint_gap_m", 0.03, "m");
}

/// Greatest rise of all energy above what there was at the start, as a share of m g L: kinetic, potential, and stored in soft
/// bounds; L is the greatest distance of two bodies at the start.
fn energy_rise(name: &str, keys: &[(&str, &str)]) -> f64 {
    let keys = [&[("solver", "gs")], keys].concat();
    let scene = scene(name, &keys);
    let softness: Vec<f64> = scene.soft_bounds.iter().map(|asked| f64::from(asked.bound.softness.compliance)).collect();
    let (mut start, mut scale, mut rise) = (0.0, 0.0, f64::NEG_INFINITY);
    Run::watched(scene, |view| {
        let moving: f64 = view.dynamic().map(|body| longspan_scenes::metrics::energy_of(view, body)).sum();
        let stored = |bound: BoundState| {
            let short = f64::from(bound.lower - bound.distance).max(0.0);
            0.5 * short * short / softness[0]
        };
        let held = view.engine.bounds().into_iter().filter(|bound| bound.kind == BoundKind::Soft).map(stored).sum::<f64>();
        if view.step == 1 {
            let centers: Vec<DVec3> = view.dynamic().map(|body| view.center(body)).collect();
            let length = centers.iter().flat_map(|a| centers.iter().map(|b| a.distance(*b))).fold(0.0, f64::max);
            let mass: f64 = view.dynamic().filter_map(|body| view.mass(body)).map(|mass| f64::from(mass.mass)).sum();
            (start, scale) = (moving + held, mass * 9.81 * length);
        } else if view.step > 1 {
            rise = rise.max((moving + held - start) / scale);
        }
    });
    rise
}

#[test]
fn no_scene_gains_energy() {
    let three: &[(&str, &str)] = &[("cars", "3")];
    for (name, keys) in [
        ("hanging_chain", &[] as &[(&str, &str)]),
        ("hanging_chain", &[("ratio", "1")]),
        ("rope_bridge", &[]),
        ("cable_car", &[]),
        ("cable_car", three),
        ("crossbow", &[]),
        ("branched_tree", &[]),
        ("loop_graph", &[]),
        ("swinging_weight", &[]),
        ("swinging_weight", &[("ratio", "1")]),
        ("swinging_weight", &[("ratio", "10")]),
        ("cantilever", &[]),
        ("mobile", &[]),
        ("mobile", &[("ratio", "100")]),
        ("mobile", &[("ratio", "1")]),
    ] {
        let rise = energy_rise(name, keys);
        assert!(rise <= 1e-3, "{name} {keys:?}: energy rises by {rise:.2e} of m g L, bound 1e-3");
    }
    Run::of("pendulum", &[("solver", "gs")]).keeps("energy_rise_pct", 0.1, "%");
}

#[test]
fn what_drives_a_scene_explains_its_energy() {
    for (name, keys) in [
        ("lifted_chain", &[] as &[(&str, &str)]),
        ("crane", &[]),
        ("excavator", &[]),
        ("track", &[("seconds", "5")]),
        ("crossbow", &[("hinges", "sprung")]),
    ] {
        for solver in ["gs", "auto"] {
            let bound = if solver == "gs" { 0.15 } else { 0.1 };
            Run::of(name, &[&[("solver", solver)], keys].concat()).keeps("unexplained_rise_pct", bound, "% of m g L");
        }
    }
    Run::of("arm", &[]).keeps("unexplained_rise_pct", 0.1, "% of m g L");
}

#[test]
fn what_drives_a_crane_explains_its_energy_and_its_rope_keeps_its_length() {
    // Load (kg), links, rate (1/s), and by how much sweeps may leave the rope longer (%): they carry a load of ten times the jib's mass worst.
    for (load, links, rate, swept) in [
        ("100", "20", "60", 0.01),
        ("1000", "5", "60", 0.1),
        ("1000", "60", "60", 0.01),
        ("5000", "20", "30", 0.25),
        ("5000", "20", "60", 0.1),
        ("5000", "20", "240", 0.006),
        ("20000", "5", "60", 1.0_f64),
        ("20000", "60", "60", 0.15),
        ("20000", "20", "30", 1.0),
    ] {
        for (solver, stretch) in [("auto", swept.min(0.03)), ("gs", swept)] {
            let run = Run::of("crane", &[("load", load), ("links", links), ("rate", rate), ("solver", solver)]);
            run.keeps("unexplained_rise_pct", 0.1, "% of m g L");
            run.keeps("stretch_pct", stretch, "%");
        }
    }
}

#[test]
fn servos_that_sweeps_do_not_hold_give_no_more_than_they_do() {
    // In one substep links of the arm turn by more than sweeps can follow, and it gains four times its m g L: see the limits.
    for substeps in ["2", "4", "8", "16"] {
        let run = Run::of("arm", &[("solver", "gs"), ("substeps", substeps)]);
        run.keeps("unexplained_rise_pct", 0.1, "% of m g L");
    }
}

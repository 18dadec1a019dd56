//! Long-range constraints: chains keep their length at default effort, and the loads reported are true.

mod common;

use common::Run;
use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, JointDef, JointKind, LongRangeDef, Mass, Pose, Shape, ShapeDef, SoftBound, Softness, Solver, World, WorldDef,
};
use longspan_scenes::DT;

fn hanging(keys: &[(&str, &str)]) -> Run {
    Run::of("hanging_chain", &[&[("solver", "gs")], keys].concat())
}

#[test]
fn a_chain_under_ten_tonnes_keeps_its_length() {
    for n in ["10", "30", "100"] {
        let run = hanging(&[("n", n)]);
        run.keeps("stretch_pct", 0.01, "%");
        run.keeps("joint_gap_m", 1e-4, "m");
    }
}

#[test]
fn a_chain_keeps_its_length_at_any_ratio() {
    for ratio in ["10", "100", "1000000"] {
        hanging(&[("ratio", ratio)]).keeps("stretch_pct", 0.01, "%");
    }
    // A chain without a weight swings bent, so no line through it is taut.
    hanging(&[("ratio", "1")]).keeps("stretch_pct", 0.02, "%");
}

#[test]
fn the_top_joint_reads_the_weight_at_any_effort() {
    for substeps in ["1", "4", "16"] {
        hanging(&[("substeps", substeps)]).keeps("load_err_pct", 2.0, "%");
    }
}

#[test]
fn a_thrown_chain_gains_no_energy() {
    for ratio in ["100", "10000", "1000000"] {
        for seed in ["1", "2", "3", "4"] {
            let run = Run::of("violent", &[("solver", "gs"), ("ratio", ratio), ("seed", seed)]);
            run.is("non_finite", 0.0);
            run.keeps("energy_growth_pct", 1.0, "%");
        }
    }
}

#[test]
fn a_rope_bridge_keeps_its_shape() {
    let run = Run::of("rope_bridge", &[("solver", "gs")]);
    run.keeps("stretch_pct", 0.5, "%");
    let sag = run.error("mid_sag_m");
    assert!((sag - 2.0).abs() <= 0.12, "the middle sags by {sag} m, converged 2.00 m, bound 6 %");
}

fn arrow_speed(stiffness: &str) -> f64 {
    Run::of("crossbow", &[("solver", "gs"), ("stiffness", stiffness)]).error("arrow_speed")
}

#[test]
fn a_softer_bow_shoots_slower_and_every_shot_is_the_same_to_the_bit() {
    let speeds = ["500", "2000", "8000"].map(arrow_speed);
    assert!(0.5 < speeds[0] && speeds[0] < speeds[1] && speeds[1] < speeds[2], "arrow speeds {speeds:?} m/s");
    assert_eq!(arrow_speed("2000").to_bits(), speeds[1].to_bits());
}

/// A beam of boxes on free hinges, level, its first joint fixed; soft bounds over every two links.
fn deflection(stiffness: f32, substeps: u32) -> f64 {
    let mut world = World::new(&WorldDef { solver: Solver::GaussSeidel, substeps, ..WorldDef::default() }).expect("valid");
    let about_z = Quat::from_rotation_arc(Vec3::X, Vec3::Z);
    let mut above = BodyId::NULL;
    let mut joints = Vec::new();
    for body in 0..8 {
        let mut shape = ShapeDef::new(Shape::cuboid(Vec3::new(0.1, 0.02, 0.02)).expect("valid"));
        shape.filter.collides_with = 0;
        let pose = Pose::at_xyz(0.2 * f64::from(body) + 0.1, 0.0, 0.0);
        let def = BodyDef { angular_damping: 2.0, linear_damping: 2.0, ..BodyDef::dynamic(pose) };
        let link = world.create_body(&def.with_shape(shape).with_mass(Mass::Total(0.1))).expect("valid");
        let kind = if body == 0 { JointKind::Fixed } else { JointKind::HINGE };
        let on_a = if body == 0 { Vec3::ZERO } else { Vec3::new(0.1, 0.0, 0.0) };
        let mut joint = JointDef::new(kind, above, link).at(on_a, Vec3::new(-0.1, 0.0, 0.0));
        (joint.frame_a.rotation, joint.frame_b.rotation) = (about_z, about_z);
        joints.push(world.create_joint(&joint).expect("valid"));
        above = link;
    }
    let bound = SoftBound { share: 1.0, softness: Softness { compliance: 1.0 / stiffness, damping: 0.0 } };
    for pair in joints.windows(3) {
        world.set_soft_bound(pair[0], pair[2], Some(bound)).expect("valid");
    }
    for _ in 0..600 {
        world.step(DT).expect("valid");
    }
    -world.pose(above).expect("valid").position.y
}

#[test]
fn a_cantilever_bends_less_the_stiffer_its_bounds_are() {
    // A link of 0.1 kg on 1e5 N/m swings once in 6 ms: default substeps of 4 ms do not resolve it, a sixteenth of a step does.
    for (substeps, stiffness) in [(4, vec![1e3, 3e3, 1e4]), (16, vec![1e3, 1e4, 1e5])] {
        let falls: Vec<f64> = stiffness.iter().map(|&stiffness| deflection(stiffness, substeps)).collect();
        assert!(falls.is_sorted_by(|softer, stiffer| softer > stiffer) && falls[2] > 0.0, "the tip falls by {falls:?} m");
        assert!(falls[0] < 1.3, "the tip falls by {} m, as if there were no bounds", falls[0]);
    }
}

/// A chain of 12 links thrown up from where it hangs; positions of its last link after every step while nothing is taut.
fn slack_fall(long_range: bool) -> (Vec<DVec3>, u32) {
    let mut def = WorldDef { solver: Solver::GaussSeidel, ..WorldDef::default() };
    def.long_range.enabled = long_range;
    let mut world = World::new(&def).expect("valid");
    let anchor = world.create_body(&BodyDef::fixed(Pose::IDENTITY)).expect("valid");
    let mut above = (anchor, Vec3::ZERO);
    for body in 0..12 {
        // Folded up like a zigzag, so that no path is near its length.
        let down = body % 2 == 0;
        let pose = Pose::at_xyz(0.05 * f64::from(body), -0.1, 0.0);
        let mut shape = ShapeDef::new(Shape::cuboid(Vec3::new(0.02, 0.1, 0.02)).expect("valid"));
        shape.filter.collides_with = 0;
        let link = world.create_body(&BodyDef::dynamic(pose).with_shape(shape).with_mass(Mass::Total(1.0))).expect("valid");
        let up = if down { 0.1 } else { -0.1 };
        let on_link = Vec3::new(0.0, up, 0.0);
        let on_above = if body == 0 { Vec3::ZERO } else { Vec3::new(0.05, up, 0.0) };
        world.create_joint(&JointDef::new(JointKind::SPHERICAL, above.0, link).at(on_above, on_link)).expect("valid");
        above = (link, on_link);
    }
    let mut active = 0;
    let path = (0..15).map(|_| {
        active += world.step(DT).expect("valid").counts.bounds_active;
        world.center_of_mass(above.0).expect("valid")
    });
    (path.collect(), active)
}

#[test]
fn a_slack_chain_falls_as_without_bounds() {
    let ((with, active), (without, _)) = (slack_fall(true), slack_fall(false));
    // The bound over one link alone has that link's length: it is taut in every step.
    assert_eq!(active, 15, "bounds acted on a folded chain");
    let fallen = without[0].distance(without[14]);
    assert!(fallen > 0.05, "the chain fell by {fallen} m only");
    for (step, (a, b)) in with.iter().zip(&without).enumerate() {
        assert!(a.distance(*b) <= 1e-6, "step {step}: {} m apart, bound 1e-6 m", a.distance(*b));
    }
}

#[test]
fn bounds_follow_the_joints() {
    let mut run = hanging(&[("seconds", "0.1")]);
    let count = run.world().bounds().count();
    assert_eq!(count, 30, "one bound for each joint but the first");
    assert_eq!(run.world().report().counts.bounds_derived, 0, "nothing has changed, so nothing is derived");
    let joints: Vec<_> = run.world().joints().collect();
    let world = run.engine.world_mut();
    world.destroy_joint(joints[10]).expect("valid");
    world.step(DT).expect("valid");
    // Below the cut nothing hangs on an attachment any more, and one heavy body is no pair.
    assert_eq!(world.report().counts.bounds_derived, 9);
    assert_eq!(world.bounds().count(), 9);
    let off = LongRangeDef { enabled: false, ..LongRangeDef::default() };
    world.set_long_range(&off).expect("valid");
    world.step(DT).expect("valid");
    assert_eq!(world.bounds().count(), 0);
}

/// Bounds derived for a net of n × n balls, hung from its first.
fn bounds_of_net(n: u32) -> u32 {
    let mut world = World::new(&WorldDef { solver: Solver::GaussSeidel, ..WorldDef::default() }).expect("valid");
    let mut balls: Vec<BodyId> = Vec::new();
    for number in 0..n * n {
        let (row, column) = (number / n, number % n);
        let pose = Pose::at_xyz(f64::from(column), -f64::from(row), 0.0);
        let mut shape = ShapeDef::new(Shape::ball(0.3).expect("valid"));
        shape.filter.collides_with = 0;
        let def = if number == 0 { BodyDef::fixed(pose) } else { BodyDef::dynamic(pose) };
        let ball = world.create_body(&def.with_shape(shape)).expect("valid");
        let above = (row > 0).then(|| (balls[(number - n) as usize], Vec3::NEG_Y));
        let beside = (column > 0).then(|| (balls[number as usize - 1], Vec3::X));
        for (other, way) in [above, beside].into_iter().flatten() {
            let joint = JointDef::new(JointKind::SPHERICAL, other, ball).at(way * 0.5, way * -0.5);
            world.create_joint(&joint).expect("valid");
        }
        balls.push(ball);
    }
    world.step(DT).expect("valid").counts.bounds_derived
}

#[test]
fn large_nets_get_no_bounds_and_small_ones_do() {
    let (small, large) = (bounds_of_net(4), bounds_of_net(12));
    assert!(small > 0 && large == 0, "{small} bounds for a net of 16 balls, {large} for one of 144");
}

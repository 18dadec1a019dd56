//! Long-range constraints: chains keep their length at default effort, and the loads reported are true.

use crate::common::{self, Run};
use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, BodyKind, BoundKind, BoundState, JointDef, JointId, JointKind, LongRangeDef, Mass, Pose, Shape, ShapeDef,
    SoftBound, Softness, Solver, World, WorldDef,
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
    for n in ["10", "30", "100"] {
        hanging(&[("n", n), ("ratio", "1")]).keeps("stretch_pct", 0.01, "%");
        for ratio in ["1", "10", "100", "1000000"] {
            hanging(&[("n", n), ("ratio", ratio), ("links", "mixed")]).keeps("stretch_pct", 0.01, "%");
        }
    }
}

#[test]
fn a_chain_tells_its_stretch_and_what_each_link_bears() {
    let run = hanging(&[("seconds", "5")]);
    let ends = [run.engine.joint_id(0), run.engine.joint_id(30)];
    let chain = run.world().chain(ends[0], ends[1]).expect("the chain connects them");
    assert!(
        chain.links.len() == 30 && (chain.rest_length - 6.0).abs() < 1e-4,
        "{} links, {} m",
        chain.links.len(),
        chain.rest_length
    );
    assert!(chain.stretch <= 1e-4, "stretched by {}, bound 1e-4", chain.stretch);
    for (above, link) in chain.links.iter().enumerate() {
        let weight = 9.81 * (1.0e4 + 30.0 - above as f32 - 0.5);
        let error = (link.tension - weight).abs() / weight;
        assert!(error <= 0.02, "link {above} bears {} N, {weight} N hang below its middle", link.tension);
    }
    let back = run.world().chain(ends[1], ends[0]).expect("the chain connects them");
    assert_eq!(back.links[0].body, chain.links[29].body, "the other way round");
    assert!(run.world().chain(ends[0], ends[0]).is_err(), "one joint is no chain");
}

#[test]
fn a_joint_without_long_range_ends_its_chain() {
    let mut run = hanging(&[("seconds", "0.1")]);
    let joint = run.engine.joint_id(10);
    let count = |world: &mut World, long_range: bool| {
        world.set_joint_long_range(joint, long_range).expect("valid");
        world.step(DT).expect("valid");
        world.bounds().filter(|bound| bound.kind == BoundKind::Attachment).count()
    };
    // Bounds lead to nine joints above it; what hangs below has no attachment, and one heavy body is no pair.
    assert_eq!(count(run.engine.world_mut(), false), 9);
    assert!(run.world().chain(run.engine.joint_id(0), run.engine.joint_id(30)).is_ok(), "it is a chain all the same");
    assert_eq!(count(run.engine.world_mut(), true), 30);
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
fn thrown_trees_and_loops_gain_no_energy_at_any_ratio() {
    for what in ["mobile", "tree", "graph"] {
        for ratio in ["1", "100", "10000", "1000000"] {
            let run = Run::of("violent", &[("solver", "gs"), ("what", what), ("ratio", ratio), ("seconds", "1")]);
            run.is("non_finite", 0.0);
            run.keeps("energy_growth_pct", 0.1, "%");
        }
    }
}

#[test]
fn a_weight_that_swings_on_a_chain_keeps_to_its_path() {
    let run = Run::of("swinging_weight", &[("solver", "gs")]);
    run.keeps("traj_err_max_m", 0.005, "m");
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
    // Below the cut nothing hangs on an attachment any more, and one heavy body is no pair. The ten links above hang without a weight
    // now, so that two bounds over eight joints come to the nine from the attachment.
    assert_eq!(world.report().counts.bounds_derived, 11);
    assert_eq!(world.bounds().count(), 11);
    let off = LongRangeDef { enabled: false, ..LongRangeDef::default() };
    world.set_long_range(&off).expect("valid");
    world.step(DT).expect("valid");
    assert_eq!(world.bounds().count(), 0);
}

/// Three chains of 8 links each on one static body, and the joints of each.
fn three_chains() -> (World, Vec<Vec<JointId>>) {
    let mut world = World::new(&WorldDef { solver: Solver::GaussSeidel, ..WorldDef::default() }).expect("valid");
    let anchor = world.create_body(&BodyDef::fixed(Pose::IDENTITY)).expect("valid");
    let chains = (0..3).map(|chain| {
        let mut above = (anchor, Vec3::new(chain as f32, 0.0, 0.0));
        let joints = (0..8).map(|link| {
            let pose = Pose::at_xyz(f64::from(chain), -0.2 * f64::from(link) - 0.1, 0.0);
            let mut shape = ShapeDef::new(Shape::cuboid(Vec3::new(0.02, 0.1, 0.02)).expect("valid"));
            shape.filter.collides_with = 0;
            let mass = Mass::Total(1.0 + link as f32);
            let body = world.create_body(&BodyDef::dynamic(pose).with_shape(shape).with_mass(mass)).expect("valid");
            let def = JointDef::new(JointKind::SPHERICAL, above.0, body).at(above.1, Vec3::Y * 0.1);
            above = (body, Vec3::Y * -0.1);
            world.create_joint(&def).expect("valid")
        });
        joints.collect()
    });
    let chains = chains.collect();
    (world, chains)
}

#[test]
fn only_what_a_change_is_connected_to_is_derived_anew_and_to_the_same_bits() {
    let (mut world, chains) = three_chains();
    world.step(DT).expect("valid");
    assert_eq!(world.report().counts.bounds_derived, 21, "all three, seven bounds each");
    let mut expect = |edit: &mut dyn FnMut(&mut World), derived: u32, all: usize| {
        edit(&mut world);
        world.step(DT).expect("valid");
        assert_eq!((world.report().counts.bounds_derived, world.bounds().count()), (derived, all));
        let bounds: Vec<_> = world.bounds().collect();
        // Another world that takes over this one's state derives everything anew.
        let mut saved = Vec::new();
        world.save(&mut saved);
        let mut other = World::new(&WorldDef::default()).expect("valid");
        other.restore(&saved).expect("just saved");
        let said = |bound: &BoundState| {
            let numbers = [bound.distance, bound.upper, bound.lower, bound.tension].map(f32::to_bits);
            (bound.kind, bound.level, numbers, bound.points, bound.active)
        };
        let anew: Vec<_> = other.bounds().map(|bound| said(&bound)).collect();
        assert_eq!(bounds.iter().map(said).collect::<Vec<_>>(), anew, "bounds derived in part and as a whole");
    };
    expect(&mut |_| (), 0, 21);
    expect(&mut |world| world.destroy_joint(chains[1][4]).expect("valid"), 5, 19);
    expect(
        &mut |world| {
            world.set_joint_frames(chains[2][7], Pose::at_xyz(0.0, -0.1, 0.0), Pose::at_xyz(0.0, 0.12, 0.0)).expect("valid")
        },
        7,
        19,
    );
    let ends = [chains[0][2], chains[0][6]];
    let asked = SoftBound { share: 0.9, softness: Softness { compliance: 1e-3, damping: 0.0 } };
    expect(&mut |world| world.set_soft_bound(ends[0], ends[1], Some(asked)).expect("valid"), 8, 20);
    expect(&mut |world| world.set_soft_bound(ends[0], ends[1], None).expect("valid"), 7, 19);
    let body = world.joint_def(chains[2][0]).expect("valid").body_b;
    world.set_mass(body, Mass::Total(50.0)).expect("valid");
    world.step(DT).expect("valid");
    // It holds what hangs on it as something fixed would, as far as that is lighter than a tenth of it: three bodies more have bounds to it.
    assert_eq!(world.report().counts.bounds_derived, 10);
}

#[test]
fn a_chain_held_in_its_middle_has_the_bounds_of_two() {
    let (mut world, chains) = three_chains();
    let middle = world.joint_def(chains[0][4]).expect("valid").body_b;
    world.step(DT).expect("valid");
    world.set_body_kind(middle, BodyKind::Static).expect("valid");
    world.step(DT).expect("valid");
    let first: Vec<BoundState> = world.bounds().filter(|bound| chains[0].contains(&bound.far)).collect();
    let from = |joint: usize| first.iter().filter(|bound| bound.near == chains[0][joint]).count();
    let across = |bound: &&BoundState| {
        let place = |joint: JointId| chains[0].iter().position(|&other| other == joint);
        place(bound.near) <= Some(4) && place(bound.far) > Some(4)
    };
    assert_eq!(first.iter().filter(across).count(), 0, "bounds lead through what nothing moves: {first:?}");
    assert!(from(0) > 0 && from(5) > 0, "both halves have bounds: {first:?}");
}

#[test]
fn what_is_far_from_taut_is_skipped() {
    let (mut world, chains) = three_chains();
    // Folded up, every other link turned over: nothing is near its length.
    for joint in chains.iter().flatten().skip(1).step_by(2) {
        let body = world.joint_def(*joint).expect("valid").body_b;
        let pose = world.pose(body).expect("valid");
        let turned = Quat::from_rotation_z(std::f32::consts::PI);
        world.set_pose(body, Pose::at_xyz(pose.position.x, -0.1, 0.0).rotated(turned)).expect("valid");
    }
    for joint in chains.iter().flatten().step_by(2) {
        let body = world.joint_def(*joint).expect("valid").body_b;
        let pose = world.pose(body).expect("valid");
        world.set_pose(body, Pose::at_xyz(pose.position.x, -0.1, 0.0)).expect("valid");
    }
    let counts = world.step(1.0e-3).expect("valid").counts;
    assert_eq!(counts.bounds, 21);
    assert!(counts.bounds_skipped >= 12, "{counts:?}");
    for _ in 0..2000 {
        world.step(1.0e-3).expect("valid");
    }
    let worst = world.bounds().map(|bound| -bound.slack()).fold(0.0, f32::max);
    assert!(worst <= 1e-4, "after the fall a bound is passed by {worst} m");
}

#[test]
fn a_chain_behaves_the_same_wherever_it_is_picked_up() {
    for links in ["even", "mixed"] {
        let places = |n: usize, step: usize| (0..=n).step_by(step).map(move |at| (n, at));
        for (n, at) in places(16, 1).chain(places(100, 20)) {
            let (n, at) = (n.to_string(), at.to_string());
            let run = Run::of("lifted_chain", &[("solver", "gs"), ("links", links), ("n", &n), ("at", &at)]);
            run.keeps("stretch_pct", 0.01, "%");
            let awake = run.world().report().counts.bodies_awake.to_string();
            assert_eq!(awake, n, "links left in the simulation, picked up at {at}");
        }
    }
}

#[test]
fn two_cars_pull_a_third_up() {
    let run = Run::of("cable_car", &[("cars", "3"), ("substeps", "16")]);
    assert!(run.error("third_rise_m") > 1.0, "the third car rises by {} m", run.error("third_rise_m"));
    run.keeps("stretch_pct", 0.01, "%");
    // Sweeps alone: the cable's bounds are wrapped around the drums.
    for substeps in ["4", "16"] {
        let run = Run::of("cable_car", &[("cars", "3"), ("solver", "gs"), ("substeps", substeps)]);
        assert!(run.error("third_rise_m") > 1.5, "{substeps} substeps: third car rises by {} m", run.error("third_rise_m"));
        run.keeps("car_drop_m", 1.5, "m");
    }
}

#[test]
fn joints_of_a_cable_over_drums_bear_what_hangs_below() {
    const LINKS: usize = 100;
    // Joints 0 and 1 are those of the cars; the others follow along the cable.
    let joint = |links_below: usize, right: bool| if right { LINKS + 1 - links_below } else { links_below + 1 };
    for substeps in ["4", "16"] {
        let scene = common::scene("cable_car", &[("solver", "gs"), ("substeps", substeps)]);
        let (mut loads, mut looks) = ([0.0; 3], 0.0);
        let last = scene.steps - 120;
        let run = Run::watched(scene, |view| {
            if view.step > last {
                // The highest joint that hangs free on each side, and the middle of the cable.
                for (sum, joint) in loads.iter_mut().zip([joint(24, false), joint(24, true), joint(LINKS / 2, false)]) {
                    *sum += f64::from(view.engine.joint_force(joint).expect("our engine tells").length());
                }
                looks += 1.0;
            }
        });
        for (load, links) in loads.map(|sum| sum / looks).into_iter().zip([24.0, 24.0, 27.0]) {
            let weight = 9.81 * (1.0e4 + links);
            let error = (load - weight).abs() / weight;
            assert!(error <= 0.02, "{substeps} substeps: a joint bears {load} N, {weight} N hang below, bound 2 %");
        }
        assert!(run.world().report().counts.bounds_wrapped > 0, "no bound is wrapped");
    }
    assert_eq!(hanging(&[("seconds", "0.1")]).world().report().counts.bounds_wrapped, 0, "a chain that touches nothing");
}

#[test]
fn a_bow_shoots_and_its_bounds_and_stops_hold() {
    let scene = common::scene("crossbow", &[("solver", "gs"), ("substeps", "64")]);
    let mut passed = 0.0_f32;
    let run = Run::watched(scene, |view| {
        let worst = view.engine.bounds().iter().map(|bound| bound.distance - bound.upper).fold(0.0, f32::max);
        passed = passed.max(worst);
    });
    assert!(run.error("arrow_speed") > 3.0, "the arrow flies at {} m/s", run.error("arrow_speed"));
    assert!(passed <= 1e-3, "a bound is passed by {passed} m, bound 1e-3 m");
    run.keeps("joint_gap_m", 1e-3, "m");
    run.keeps("overshoot_deg", 1.0, "°");
}

#[test]
fn a_cable_over_drums_does_not_explode() {
    for substeps in ["4", "16", "64"] {
        let run = Run::of("cable_car", &[("sides", "32"), ("solver", "gs"), ("substeps", substeps), ("seconds", "5")]);
        run.keeps("stretch_pct", 1.0, "%");
        run.keeps("joint_gap_m", 0.05, "m");
        run.keeps("car_drop_m", 0.1, "m");
        let round = Run::of("cable_car", &[("solver", "gs"), ("substeps", substeps)]);
        round.keeps("joint_gap_m", 0.05, "m");
        round.keeps("car_drop_m", 0.5, "m");
    }
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
    let (small, large) = (bounds_of_net(4), bounds_of_net(24));
    assert!(small > 0 && large == 0, "{small} bounds for a net of 16 balls, {large} for one of 576");
}

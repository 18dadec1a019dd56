//! Rigid unions: bodies that fixed joints connect move as one (Müller et al. 2017, §3.5).

use longspan::glam::{DQuat, DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, BodyKind, JointDef, JointId, JointKind, LongRangeDef, MAX_LINEAR_SPEED, Mass, Pose, Shape, ShapeDef,
    SleepSettings, Solver, World, WorldDef,
};

const DT: f32 = 1.0 / 60.0;

fn world(gravity: Vec3) -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    World::new(&WorldDef { gravity, sleep, ..WorldDef::default() }).unwrap()
}

fn cube(half: f32) -> ShapeDef {
    ShapeDef::new(Shape::cuboid(Vec3::splat(half)).unwrap())
}

fn body_at(world: &mut World, position: DVec3) -> BodyId {
    world.create_body(&BodyDef::dynamic(Pose::at(position)).with_shape(cube(0.25))).unwrap()
}

/// A fixed joint in the middle between two bodies, as they stand now.
fn weld(world: &mut World, a: BodyId, b: BodyId) -> JointId {
    let (pose_a, pose_b) = (world.pose(a).unwrap(), world.pose(b).unwrap());
    let middle = 0.5 * (pose_a.position + pose_b.position);
    let mut def = JointDef::new(JointKind::Fixed, a, b);
    for (pose, frame) in [(&pose_a, &mut def.frame_a), (&pose_b, &mut def.frame_b)] {
        *frame = Pose::at(pose.inverse_transform_point(middle).as_dvec3()).rotated(pose.rotation.conjugate());
    }
    world.create_joint(&def).unwrap()
}

/// Cubes of 0.5 m in an L of `count` and three more.
fn bracket(world: &mut World, count: usize) -> Vec<BodyId> {
    let mut bodies: Vec<BodyId> = (0..count).map(|i| body_at(world, DVec3::new(0.5 * i as f64, 5.0, 0.0))).collect();
    for i in 1..=3 {
        bodies.push(body_at(world, DVec3::new(0.0, 5.0 + 0.5 * i as f64, 0.0)));
    }
    for i in 1..count {
        weld(world, bodies[i - 1], bodies[i]);
    }
    weld(world, bodies[0], bodies[count]);
    weld(world, bodies[count], bodies[count + 1]);
    weld(world, bodies[count + 1], bodies[count + 2]);
    bodies
}

/// Linear and angular momentum about the origin, and kinetic energy, in `f64`.
fn motion(world: &World, bodies: &[BodyId]) -> (DVec3, DVec3, f64) {
    let (mut linear, mut angular, mut energy) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for &body in bodies {
        let mass = world.mass_properties(body).unwrap().unwrap();
        let velocity = world.linear_velocity(body).unwrap().as_dvec3();
        let spin = world.angular_velocity(body).unwrap().as_dvec3();
        let frame = world.pose(body).unwrap().rotation.as_dquat().normalize() * mass.inertia_frame.as_dquat().normalize();
        let own = frame * (mass.principal_inertia.as_dvec3() * (frame.conjugate() * spin));
        let kilograms = f64::from(mass.mass);
        linear += velocity * kilograms;
        angular += world.center_of_mass(body).unwrap().cross(velocity * kilograms) + own;
        energy += 0.5 * (kilograms * velocity.length_squared() + own.dot(spin));
    }
    (linear, angular, energy)
}

/// Pose of one body in the frame of another.
fn relative(world: &World, a: BodyId, b: BodyId) -> (DVec3, DQuat) {
    let (a, b) = (world.pose(a).unwrap(), world.pose(b).unwrap());
    let turn = a.rotation.as_dquat().normalize().conjugate();
    (turn * (b.position - a.position), turn * b.rotation.as_dquat().normalize())
}

#[test]
fn a_tumbling_union_keeps_its_momentum_and_gains_no_energy_in_a_minute() {
    let mut world = world(Vec3::ZERO);
    let bodies = bracket(&mut world, 5);
    for (i, &body) in bodies.iter().enumerate() {
        // Not a rigid motion: the union keeps its momentum and loses what was motion of its members against each other.
        world.set_linear_velocity(body, Vec3::new(0.3 + 0.2 * i as f32, -0.1, 0.4 - 0.3 * i as f32)).unwrap();
        world.set_angular_velocity(body, Vec3::new(2.0, 3.0 + i as f32, -1.0)).unwrap();
    }
    let before = motion(&world, &bodies);
    world.step(DT).unwrap();
    let start = motion(&world, &bodies);
    assert!(start.2 < before.2, "{} J after {} J", start.2, before.2);
    let shape: Vec<_> = bodies[1..].iter().map(|&body| relative(&world, bodies[0], body)).collect();
    let mut most = start.2;
    for _ in 0..3600 {
        world.step(DT).unwrap();
        most = most.max(motion(&world, &bodies).2);
    }
    let end = motion(&world, &bodies);
    let linear = (end.0 - before.0).length() / before.0.length();
    // About the origin, from which the union has flown away: against its spin about itself.
    let about = |m: &(DVec3, DVec3, f64), world: &World| m.1 - world.union_of(bodies[0]).unwrap().unwrap().center.cross(m.0);
    let spin = about(&end, &world);
    let angular = (end.1 - before.1).length() / spin.length();
    assert!(linear <= 1.0e-5, "linear momentum off by {linear:e} of itself");
    assert!(angular <= 1.0e-3, "angular momentum off by {angular:e} of itself");
    assert!(most <= start.2 * 1.001, "kinetic energy rose from {} to {most} J", start.2);
    for (&body, (arm, turn)) in bodies[1..].iter().zip(&shape) {
        let now = relative(&world, bodies[0], body);
        let bend = 2.0 * (1.0 - now.1.dot(*turn).abs().min(1.0)).sqrt();
        assert!((now.0 - *arm).length() < 2.0e-6, "a member has moved by {} m", (now.0 - *arm).length());
        assert!(bend < 2.0e-3, "a member has turned by {bend} rad");
    }
}

#[test]
fn a_union_is_told_from_its_bodies() {
    let mut world = world(Vec3::Y * -9.81);
    let bodies = bracket(&mut world, 4);
    let lone = body_at(&mut world, DVec3::new(20.0, 5.0, 0.0));
    assert_eq!(world.union_of(bodies[0]).unwrap(), None, "joints count from the next step on");
    world.step(DT).unwrap();
    let union = world.union_of(bodies[3]).unwrap().expect("fixed joints connect it");
    assert_eq!(union.lead, bodies[0]);
    assert_eq!((union.members, union.joints, union.anchored), (7, 6, false));
    let kilograms: f32 = bodies.iter().map(|&body| world.mass_properties(body).unwrap().unwrap().mass).sum();
    assert!((union.mass - kilograms).abs() < 1e-3, "{} kg", union.mass);
    assert!(union.distance_residual < 1e-6 && union.angle_residual < 1e-6);
    assert_eq!(world.union_members(bodies[2]).unwrap().collect::<Vec<_>>(), bodies);
    assert_eq!(world.union_of(lone).unwrap(), None);
    assert_eq!(world.unions().count(), 1);
    assert_eq!((world.report().counts.unions, world.report().counts.union_members), (1, 7));
    assert_eq!(world.report().counts.joints, 0, "joints inside a union are not solved");
}

#[test]
fn cutting_a_union_leaves_each_piece_its_momentum() {
    let mut world = world(Vec3::ZERO);
    let bodies: Vec<BodyId> = (0..6).map(|i| body_at(&mut world, DVec3::new(0.5 * f64::from(i), 5.0, 0.0))).collect();
    let joints: Vec<JointId> = bodies.windows(2).map(|two| weld(&mut world, two[0], two[1])).collect();
    for (i, &body) in bodies.iter().enumerate() {
        world.set_linear_velocity(body, Vec3::new(1.0, 0.8 * i as f32, 0.3)).unwrap();
        world.set_angular_velocity(body, Vec3::new(0.0, 0.0, 1.6)).unwrap();
    }
    world.step(DT).unwrap();
    let (before, first) = (motion(&world, &bodies), motion(&world, &bodies[..2]));
    world.destroy_joint(joints[1]).unwrap();
    world.step(DT).unwrap();
    let (left, right) = (world.union_of(bodies[0]).unwrap().unwrap(), world.union_of(bodies[5]).unwrap().unwrap());
    assert_eq!((left.members, right.members), (2, 4));
    let after = motion(&world, &bodies);
    let (linear, angular) = ((after.0 - before.0).length(), (after.1 - before.1).length());
    assert!(linear < 1e-5 * before.0.length(), "{linear} kg·m/s of {} lost", before.0.length());
    assert!(angular < 1e-5 * before.1.length(), "{angular} kg·m²/s of {} lost", before.1.length());
    let own = (motion(&world, &bodies[..2]).0 - first.0).length();
    assert!(own < 1e-5 * first.0.length(), "the piece of two has lost {own} of {} kg·m/s", first.0.length());
}

#[test]
fn members_put_elsewhere_are_taken_back_in_without_momentum() {
    let mut world = world(Vec3::ZERO);
    let bodies = bracket(&mut world, 4);
    world.step(DT).unwrap();
    let shape = relative(&world, bodies[0], bodies[6]);
    let center = world.union_of(bodies[0]).unwrap().unwrap().center;
    let pose = world.pose(bodies[2]).unwrap();
    let moved =
        Pose { position: pose.position + DVec3::new(0.1, 0.2, 0.0), rotation: Quat::from_rotation_z(0.4) * pose.rotation };
    world.set_pose(bodies[2], moved).unwrap();
    world.step(DT).unwrap();
    let now = relative(&world, bodies[0], bodies[6]);
    assert!((now.0 - shape.0).length() < 2e-6, "the union has bent by {} m", (now.0 - shape.0).length());
    let drift = world.union_of(bodies[0]).unwrap().unwrap().center - center;
    let expected = DVec3::new(0.1, 0.2, 0.0) / 7.0;
    assert!((drift - expected).length() < 1e-5, "its centre moved by {drift}, expected {expected}");
    assert!(motion(&world, &bodies).2 < 1e-9, "it got {} J", motion(&world, &bodies).2);
}

#[test]
fn crooked_joints_conform_breadth_first_and_say_by_how_much_they_contradict() {
    let mut world = world(Vec3::ZERO);
    let bodies: Vec<BodyId> = [(0.0, 0.0), (0.6, 0.0), (0.6, 0.6), (0.0, 0.6)]
        .iter()
        .map(|&(x, y)| body_at(&mut world, DVec3::new(x, y, 0.0)))
        .collect();
    for i in 0..4 {
        let joint = weld(&mut world, bodies[i], bodies[(i + 1) % 4]);
        if i == 1 {
            let def = world.joint_def(joint).unwrap();
            let off = Pose { position: def.frame_b.position + DVec3::X * 0.02, ..def.frame_b };
            world.set_joint_frames(joint, def.frame_a, off).unwrap();
        }
    }
    world.step(DT).unwrap();
    let union = world.union_of(bodies[0]).unwrap().unwrap();
    assert!((union.distance_residual - 0.02).abs() < 1e-5, "{} m", union.distance_residual);
    assert!(union.angle_residual < 1e-6, "{} rad", union.angle_residual);
    let energy = motion(&world, &bodies).2;
    for _ in 0..60 {
        world.step(DT).unwrap();
    }
    assert!(energy < 1e-9 && motion(&world, &bodies).2 < 1e-9, "a contradiction drives it: {} J", motion(&world, &bodies).2);
}

#[test]
fn what_is_anchored_stands_and_what_hangs_on_it_hangs() {
    let mut world = world(Vec3::Y * -9.81);
    let ground = world.create_body(&BodyDef { kind: BodyKind::Static, ..BodyDef::default() }).unwrap();
    let bodies = bracket(&mut world, 4);
    weld(&mut world, ground, bodies[6]);
    let hung = body_at(&mut world, DVec3::new(1.5, 3.0, 0.0));
    let rope = JointDef::new(JointKind::SPHERICAL, bodies[3], hung).at(Vec3::Y * -0.5, Vec3::Y * 1.5);
    let rope = world.create_joint(&rope).unwrap();
    let start: Vec<Pose> = bodies.iter().map(|&body| world.pose(body).unwrap()).collect();
    for _ in 0..240 {
        world.step(DT).unwrap();
    }
    for (&body, start) in bodies.iter().zip(&start) {
        let moved = (world.pose(body).unwrap().position - start.position).length();
        assert!(moved < 1e-6, "an anchored body has moved by {moved} m");
    }
    assert!(world.union_of(bodies[0]).unwrap().unwrap().anchored);
    let force = world.joint_state(rope).unwrap().force.y;
    let weight = world.mass_properties(hung).unwrap().unwrap().mass * 9.81;
    assert!((force - weight).abs() < 0.02 * weight, "the rope carries {force} N, its weight is {weight} N");
    world.destroy_body(ground).unwrap();
    for _ in 0..60 {
        world.step(DT).unwrap();
    }
    assert!(world.linear_velocity(bodies[0]).unwrap().y < -5.0, "cut loose it falls");
}

#[test]
fn a_kinematic_anchor_carries_the_union_along() {
    let mut world = world(Vec3::Y * -9.81);
    let arm = world
        .create_body(
            &BodyDef { kind: BodyKind::Kinematic, pose: Pose::at(DVec3::Y * 6.0), ..BodyDef::default() }.with_shape(cube(0.1)),
        )
        .unwrap();
    let bodies = bracket(&mut world, 4);
    weld(&mut world, arm, bodies[5]);
    let rider = body_at(&mut world, DVec3::new(1.5, 5.51, 0.0));
    world.step(DT).unwrap();
    let shape = relative(&world, arm, bodies[3]);
    for step in 1..=240 {
        let time = f64::from(step) / 60.0;
        let target = Pose { position: DVec3::new(0.4 * time, 6.0, 0.0), rotation: Quat::from_rotation_y(0.3 * time as f32) };
        world.move_to(arm, target).unwrap();
        world.step(DT).unwrap();
        let now = relative(&world, arm, bodies[3]);
        assert!((now.0 - shape.0).length() < 2e-6, "the end is off by {} m", (now.0 - shape.0).length());
    }
    let (top, rider_pose) = (world.pose(bodies[3]).unwrap().position, world.pose(rider).unwrap().position);
    assert!((rider_pose - top - DVec3::Y * 0.5).length() < 0.15, "who stands on it is carried along: {}", rider_pose - top);
}

/// What a spinning hub holds at arm's length would go faster than bodies may: it is told no more than that.
#[test]
fn what_a_fast_hub_holds_keeps_the_speed_limit() {
    let mut world = world(Vec3::ZERO);
    let hub = world.create_body(&BodyDef { kind: BodyKind::Kinematic, ..BodyDef::dynamic(Pose::IDENTITY) }).unwrap();
    let held = body_at(&mut world, DVec3::X * 20.0);
    weld(&mut world, hub, held);
    world.set_angular_velocity(hub, Vec3::Z * 1000.0).unwrap();
    for step in 0..10 {
        world.step(DT).unwrap();
        let speed = world.linear_velocity(held).unwrap().length();
        assert!(speed <= MAX_LINEAR_SPEED * 1.000_001, "{speed} m/s after {step} steps, limit {MAX_LINEAR_SPEED}");
        assert!(speed > 0.999 * MAX_LINEAR_SPEED, "{speed} m/s after {step} steps: it goes as fast as it may");
    }
}

#[test]
fn a_cantilever_reads_what_statics_says_at_every_joint() {
    for iterations in [1, 2, 20] {
        let mut world = world(Vec3::Y * -9.81);
        world.set_effort(4, iterations).unwrap();
        let ground = world
            .create_body(&BodyDef { kind: BodyKind::Static, pose: Pose::at_xyz(-0.5, 5.0, 0.0), ..BodyDef::default() })
            .unwrap();
        let bodies: Vec<BodyId> = (0..8).map(|i| body_at(&mut world, DVec3::new(0.5 * f64::from(i), 5.0, 0.0))).collect();
        let mut joints = vec![weld(&mut world, ground, bodies[0])];
        joints.extend(bodies.windows(2).map(|two| weld(&mut world, two[0], two[1])));
        let kilograms = world.mass_properties(bodies[0]).unwrap().unwrap().mass;
        // Narrower than what it stands on, so that it rests on the last cube alone.
        let load = BodyDef::dynamic(Pose::at_xyz(3.5, 5.402, 0.0)).with_shape(cube(0.15)).with_mass(Mass::Total(kilograms));
        world.create_body(&load).unwrap();
        for step in 0..180 {
            if step == 60 {
                // The same numbers whether they are found in every step or when asked for.
                world.set_joint_break(joints[0], 1e9, 1e9).unwrap();
            }
            world.step(DT).unwrap();
        }
        for (i, &joint) in joints.iter().enumerate() {
            let state = world.joint_state(joint).unwrap();
            let beyond = (8 - i) as f32;
            let weight = kilograms * 9.81 * (beyond + 1.0);
            assert!((state.force.y - weight).abs() < 0.01 * weight, "joint {i} carries {} N, {weight} N expected", state.force);
            // Half a cube to each joint point; the load stands on the last cube.
            let moment = kilograms * 9.81 * (beyond * 0.25 * beyond + 0.5 * beyond - 0.25);
            let about = state.torque.z;
            assert!((about - moment).abs() < 0.03 * moment, "joint {i} bends by {about} N·m, {moment} N·m expected");
        }
    }
}

#[test]
fn a_limit_inside_a_union_reports_an_overload_at_any_effort() {
    for (substeps, iterations) in [(1, 5), (4, 2), (8, 10)] {
        let mut world = world(Vec3::Y * -9.81);
        world.set_effort(substeps, iterations).unwrap();
        let ground = world.create_body(&BodyDef { kind: BodyKind::Static, ..BodyDef::default() }).unwrap();
        let (a, b) = (body_at(&mut world, DVec3::Y * -0.5), body_at(&mut world, DVec3::Y * -1.0));
        let upper = weld(&mut world, ground, a);
        let lower = weld(&mut world, a, b);
        let weight = world.mass_properties(a).unwrap().unwrap().mass * 9.81;
        world.set_joint_break(upper, 1.9 * weight, f32::INFINITY).unwrap();
        world.set_joint_break(lower, 1.1 * weight, f32::INFINITY).unwrap();
        world.step(DT).unwrap();
        let overloaded: Vec<JointId> = world.overloaded().iter().map(|overload| overload.joint).collect();
        assert_eq!(overloaded, [upper], "at {substeps} substeps of {iterations}");
    }
}

#[test]
fn a_restored_union_goes_on_bit_for_bit() {
    let mut world = world(Vec3::Y * -9.81);
    world.create_body(&BodyDef { kind: BodyKind::Static, ..BodyDef::default() }.with_shape(cube(2.0))).unwrap();
    let bodies = bracket(&mut world, 4);
    let mut bytes = Vec::new();
    let cut = |world: &mut World| {
        let joint = world.body_joints(bodies[3]).unwrap()[0];
        world.destroy_joint(joint).unwrap();
    };
    for step in 0..200 {
        if step == 70 {
            cut(&mut world);
            world.add_impulse(bodies[0], Vec3::new(30.0, 5.0, 8.0)).unwrap();
        }
        if step == 71 || step == 40 {
            world.save(&mut bytes);
            let mut other = World::new(world.def()).unwrap();
            other.restore(&bytes).unwrap();
            for further in 0..60 {
                if step == 40 && further == 30 {
                    other.restore(&bytes).unwrap();
                }
                other.step(DT).unwrap();
            }
            let mut same = World::new(world.def()).unwrap();
            same.restore(&bytes).unwrap();
            let steps = if step == 40 { 30 } else { 60 };
            for _ in 0..steps {
                same.step(DT).unwrap();
            }
            assert_eq!(other.state_hash(), same.state_hash());
            if step == 71 {
                for _ in 0..60 {
                    world.step(DT).unwrap();
                }
                assert_eq!(world.state_hash(), same.state_hash(), "the world that was saved and the restored one part ways");
            }
        }
        world.step(DT).unwrap();
    }
}

#[test]
fn a_union_sleeps_and_wakes_whole() {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let floor = ShapeDef::new(Shape::cuboid(Vec3::new(10.0, 0.5, 10.0)).unwrap());
    world
        .create_body(
            &BodyDef { kind: BodyKind::Static, pose: Pose::at_xyz(0.0, 4.25, 0.0), ..BodyDef::default() }.with_shape(floor),
        )
        .unwrap();
    let bodies = bracket(&mut world, 4);
    for _ in 0..180 {
        world.step(DT).unwrap();
    }
    assert!(bodies.iter().all(|&body| !world.is_awake(body).unwrap()), "it lies still and sleeps");
    let hash = world.state_hash();
    world.step(DT).unwrap();
    assert_eq!(hash, world.state_hash());
    world.add_impulse(bodies[6], Vec3::Z * 200.0).unwrap();
    world.step(DT).unwrap();
    assert!(bodies.iter().all(|&body| world.is_awake(body).unwrap()), "a push at one wakes all");
    assert!(world.linear_velocity(bodies[3]).unwrap().length() > 0.0);
}

#[test]
fn without_unions_the_joints_are_solved() {
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        let long_range = LongRangeDef { union: false, ..LongRangeDef::default() };
        let mut world = World::new(&WorldDef { solver, long_range, gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
        let bodies = bracket(&mut world, 4);
        world.add_impulse(bodies[6], Vec3::Z * 20.0).unwrap();
        world.step(DT).unwrap();
        assert_eq!((world.unions().count(), world.report().counts.joints), (0, 6));
        world.set_long_range(&LongRangeDef::default()).unwrap();
        world.step(DT).unwrap();
        assert_eq!((world.unions().count(), world.report().counts.joints), (1, 0));
        world.set_long_range(&long_range).unwrap();
        world.step(DT).unwrap();
        assert_eq!((world.unions().count(), world.report().counts.joints), (0, 6));
    }
}

//! What bodies have of a joint that breaks: momentum as before, and no spin, energy or speed that it could not have given them.

use crate::common::oracle::dice;
use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, BondMaterial, Cells, Geometry, JointDef, JointKind, Limits, Mass, Material, Motor, Pose, Shape,
    ShapeDef, Softness, Solver, Strength, World, WorldDef,
};

/// Turns x up.
const UPRIGHT: Quat = Quat::from_xyzw(0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2);

fn solid(geometry: Geometry) -> ShapeDef {
    let material = Material { friction: 0.0, ..Material::default() };
    ShapeDef { material, ..ShapeDef::new(Shape::new(geometry).expect("a form")) }
}

/// Greatest spin (rad/s) of a ball that two rods hold by its centre while what falls on it breaks them, and whether it has.
fn spin_of_a_ball_between_rods(solver: Solver, rate: u32, size: f32) -> (f32, bool) {
    let mut world = World::new(&WorldDef { solver, ..WorldDef::default() }).expect("a valid world");
    let at = |x: f32, y: f32| Pose::at((Vec3::new(x, y, 0.0) * size).as_dvec3());
    let body = |world: &mut World, geometry: Geometry, pose: Pose, mass: f32| {
        let def = BodyDef::dynamic(pose).with_shape(solid(geometry)).with_mass(Mass::Total(mass * size.powi(3)));
        world.create_body(&def).expect("a valid body")
    };
    let ball = body(&mut world, Geometry::Ball { radius: 0.06 * size }, at(0.0, 3.0), 1.0);
    // Its limit in impulse goes with mass times speed.
    let limit = 2.0e4 * size.powf(3.5);
    let strength = Strength { tension: limit, compression: limit, ..Strength::UNBREAKABLE };
    for (side, is_first) in [(1.0, false), (-1.0, true)] {
        let kind = JointKind::Distance { limits: Limits::new(size, size), spring_length: None, motor: Motor::Off };
        let [body_a, body_b] = if is_first { [ball, BodyId::NULL] } else { [BodyId::NULL, ball] };
        let mut def = JointDef { strength, ..JointDef::new(kind, body_a, body_b) };
        *(if is_first { &mut def.frame_b } else { &mut def.frame_a }) = at(side, 3.0);
        world.create_joint(&def).expect("a valid joint");
    }
    body(&mut world, Geometry::Box { half_extents: Vec3::new(0.8, 0.3, 0.3) * size }, at(0.0, 3.66), 500.0);
    let mut most = 0.0_f32;
    for _ in 0..rate {
        world.step(1.0 / rate as f32).expect("a valid step");
        most = most.max(world.angular_velocity(ball).expect("the ball").length());
    }
    (most, world.joint_count() < 2)
}

#[test]
fn rods_that_break_turn_no_ball_that_they_hold_by_its_centre() {
    let mut broke = 0;
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        for rate in [30, 60, 240] {
            for size in [0.1, 1.0, 10.0] {
                let (spin, has_broken) = spin_of_a_ball_between_rods(solver, rate, size);
                broke += u32::from(has_broken);
                let what = format!("{solver:?}, {rate} Hz, {size} m");
                assert!(spin < 1e-3, "{what}: the ball turns at {spin} rad/s, with no lever about its centre");
            }
        }
    }
    assert!(broke >= 9, "{broke} of 18 break");
}

/// Linear and angular momentum (about the origin) of all bodies.
fn momentum(world: &World, bodies: &[BodyId]) -> [DVec3; 2] {
    bodies.iter().fold([DVec3::ZERO; 2], |[linear, angular], &body| {
        let (mass, center) = (world.mass_properties(body).unwrap().unwrap(), world.center_of_mass(body).unwrap());
        let push = world.linear_velocity(body).unwrap().as_dvec3() * f64::from(mass.mass);
        let axes = (world.pose(body).unwrap().rotation * mass.inertia_frame).as_dquat();
        let turn = axes.conjugate() * world.angular_velocity(body).unwrap().as_dvec3();
        [linear + push, angular + center.cross(push) + axes * (turn * mass.principal_inertia.as_dvec3())]
    })
}

#[test]
fn a_joint_of_any_kind_that_breaks_keeps_momentum() {
    let soft = Softness { compliance: 1.0e-4, damping: 10.0 };
    let rod = |limits, spring_length| JointKind::Distance { limits, spring_length, motor: Motor::Off };
    let kinds = [
        (JointKind::Fixed, Softness::RIGID),
        (JointKind::Hinge { limits: Limits::NONE, motor: Motor::Off }, soft),
        (JointKind::Spherical { swing_limit: 1.0, twist_limits: Limits::NONE, motor: Default::default() }, soft),
        (rod(Limits::new(1.0, 1.0), None), Softness::RIGID),
        (rod(Limits::NONE, Some(0.9)), soft),
        (JointKind::Prismatic { limits: Limits::new(-0.1, 0.1), motor: Motor::Off }, Softness::RIGID),
        (
            JointKind::Generic {
                linear: [Axis::limited(-0.1, 0.1), Axis::LOCKED, Axis::LOCKED],
                angular: [Axis::LOCKED, Axis::FREE, Axis::LOCKED],
            },
            Softness::RIGID,
        ),
    ];
    let mut broken = 0;
    for (solver, rate) in [Solver::Auto, Solver::GaussSeidel].into_iter().flat_map(|solver| [30, 240].map(|rate| (solver, rate)))
    {
        for (kind, linear) in kinds {
            let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, solver, ..WorldDef::default() }).unwrap();
            let mut bar = |x: f64| {
                let def = BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0));
                world.create_body(&def.with_shape(solid(Geometry::Box { half_extents: Vec3::new(0.4, 0.1, 0.2) }))).unwrap()
            };
            let bodies = [bar(-0.5), bar(0.5)];
            let reach = if matches!(kind, JointKind::Distance { .. }) { 0.0 } else { 0.5 };
            let strength = Strength {
                tension: 100.0,
                compression: 100.0,
                shear: 100.0,
                bending: 20.0,
                torsion: 20.0,
                ..Strength::UNBREAKABLE
            };
            let def = JointDef { linear, strength, ..JointDef::new(kind, bodies[0], bodies[1]) };
            let def = JointDef { frame_a: Pose::at_xyz(reach, 0.0, 0.0), frame_b: Pose::at_xyz(-reach, 0.0, 0.0), ..def };
            world.create_joint(&def).unwrap();
            world.add_impulse_at(bodies[1], Vec3::new(60.0, 90.0, -50.0), DVec3::new(0.8, 0.1, 0.1)).unwrap();
            world.add_torque(bodies[0], Vec3::new(500.0, 0.0, 200.0)).unwrap();
            world.step(1.0 / rate as f32).unwrap();
            let torque = DVec3::new(500.0, 0.0, 200.0) / f64::from(rate);
            let push = DVec3::new(60.0, 90.0, -50.0);
            let expected = [push, DVec3::new(0.8, 0.1, 0.1).cross(push) + torque];
            let found = momentum(&world, &bodies);
            broken += world.broken().len();
            for (found, expected) in found.into_iter().zip(expected) {
                let off = (found - expected).length() / expected.length();
                assert!(off < 2.0e-2, "{kind:?}, {solver:?}, {rate} Hz: momentum {found} instead of {expected}");
            }
        }
    }
    assert!(broken >= 14, "{broken} of 28 break");
}

#[test]
fn cells_of_a_flying_solid_have_its_momentum() {
    let mut dice = dice(7);
    let corners = [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (2.0, 1.0, 0.0), (2.0, 0.0, 1.0)];
    for size in [0.01_f32, 1.0, 100.0] {
        let points: Vec<Vec3> = corners.iter().map(|&(x, y, z)| Vec3::new(x, y, z) * size).collect();
        let forms = [Geometry::Box { half_extents: Vec3::new(1.0, 0.5, 0.5) * size }, Geometry::ConvexHull { points }];
        for geometry in forms {
            let shape = solid(geometry.clone());
            let def = BodyDef {
                linear_velocity: Vec3::new(3.0, 0.0, -1.0) * size,
                angular_velocity: Vec3::new(0.5, 1.0, 2.0),
                ..BodyDef::dynamic(dice.pose(DVec3::Y * 5.0 * f64::from(size)))
            };
            let mut world = World::new(&WorldDef::default()).unwrap();
            let whole = world.create_body(&def.clone().with_shape(shape.clone())).unwrap();
            let expected = momentum(&world, &[whole]);
            world.destroy_body(whole).unwrap();
            let cells = Cells::cut(&geometry, &Cells::random_seeds(&geometry, 20, 1).unwrap()).unwrap();
            let (bodies, _) = world.create_cells(&cells, &def, &shape, &BondMaterial::brittle(1.0e9)).unwrap();
            for (found, expected) in momentum(&world, &bodies).into_iter().zip(expected) {
                let off = (found - expected).length() / expected.length();
                assert!(off < 1.0e-4, "{geometry:?}: cells have {found}, the solid {expected}");
            }
        }
    }
}

#[test]
fn a_joint_above_its_limit_is_told_of_in_every_step_and_one_below_it_sleeps() {
    let rod = JointKind::Distance { limits: Limits::new(1.0, 1.0), spring_length: None, motor: Motor::Off };
    let slider = JointKind::Prismatic { limits: Limits::new(0.0, 0.1), motor: Motor::Off };
    let turning = JointKind::Generic { linear: [Axis::LOCKED; 3], angular: [Axis::FREE, Axis::FREE, Axis::LOCKED] };
    let kinds = [JointKind::Fixed, JointKind::HINGE, JointKind::SPHERICAL, rod, slider, turning];
    let ways = kinds.into_iter().flat_map(|kind| [false, true].map(|is_inside| (kind, is_inside)));
    for (kind, is_inside) in ways {
        for (solver, rate) in
            [Solver::Auto, Solver::GaussSeidel].into_iter().flat_map(|solver| [30.0, 60.0, 240.0].map(|rate| (solver, rate)))
        {
            for limit in [0.95, 1.05] {
                let mut world = World::new(&WorldDef { solver, ..WorldDef::default() }).unwrap();
                let mut hang = |kind: &JointKind, above: BodyId, y: f64, mass: f32, break_force: f32| {
                    let ball = ShapeDef::new(Shape::ball(0.1).unwrap());
                    let body = BodyDef::dynamic(Pose::at_xyz(0.0, y, 0.0)).with_shape(ball).with_mass(Mass::Total(mass));
                    let body = world.create_body(&body).unwrap();
                    let on_body = if matches!(kind, JointKind::Distance { .. }) { Vec3::ZERO } else { Vec3::Y };
                    // The axis of a slider is upright.
                    let mut def = JointDef::new(*kind, above, body).at(Vec3::ZERO, on_body);
                    (def.frame_a.rotation, def.frame_b.rotation) = (UPRIGHT, UPRIGHT);
                    (body, world.create_joint(&JointDef { break_force, ..def }).unwrap())
                };
                // Hanging on the world, or on what hangs there.
                let above =
                    if is_inside { hang(&JointKind::HINGE, BodyId::NULL, -1.0, 1.0, f32::INFINITY).0 } else { BodyId::NULL };
                let y = if is_inside { -2.0 } else { -1.0 };
                let (body, joint) = hang(&kind, above, y, 2.0, limit * 2.0 * 9.81);
                let what = format!("{kind:?}, on another: {is_inside}, {solver:?}, {rate} Hz, limit {limit} of the load");
                // Sweeps find the load within some steps.
                let settled = if solver == Solver::GaussSeidel { 0.5 } else { 0.1 };
                for step in 0..(2.0 * rate) as u32 {
                    world.step(1.0 / rate).unwrap();
                    let is_told = world.overloaded().iter().any(|overload| overload.joint == joint);
                    assert!(is_told == (limit < 1.0) || step < (settled * rate) as u32, "{what}: told in step {step}: {is_told}");
                }
                assert_eq!(world.is_awake(body).unwrap(), limit < 1.0, "{what}");
            }
        }
    }
}

/// A ball of 10 kg that hangs on the world by a distance joint (`side` 1) or is borne up by it (−1), along a direction that the joint's frames know
/// nothing of: its share of a limit of `limit` N along the line, or whether that has broken it. Across the line it bears next to nothing.
fn share_along_a_line(solver: Solver, rate: u32, spring: bool, side: f32, seed: usize, limit: f32) -> Option<f32> {
    let mut random = dice(seed);
    let mut any = || random.between(-1.0, 1.0) as f32;
    let along = Vec3::new(any(), any(), any()).normalize();
    let frame = Quat::from_xyzw(any(), any(), any(), any()).normalize();
    let mut world = World::new(&WorldDef { gravity: along * 10.0, solver, ..WorldDef::default() }).expect("a valid world");
    let ball = BodyDef::dynamic(Pose::at((along * side).as_dvec3())).with_shape(solid(Geometry::Ball { radius: 0.1 }));
    let ball = world.create_body(&ball.with_mass(Mass::Total(10.0))).expect("a valid body");
    let limits = if spring { Limits::NONE } else { Limits::new(if side > 0.0 { 0.0 } else { 1.0 }, 1.0) };
    let kind = JointKind::Distance { limits, spring_length: spring.then_some(1.0), motor: Motor::Off };
    let strength = match side > 0.0 {
        true => Strength { tension: limit, compression: 1.0e-3, shear: 1.0e-3, ..Strength::UNBREAKABLE },
        false => Strength { compression: limit, tension: 1.0e-3, shear: 1.0e-3, ..Strength::UNBREAKABLE },
    };
    let mut def =
        JointDef { strength, linear: Softness { compliance: 1.0e-6, damping: 100.0 }, ..JointDef::new(kind, BodyId::NULL, ball) };
    if !spring {
        def.linear = Softness::RIGID;
    }
    (def.frame_a.rotation, def.frame_b.rotation) = (frame, frame);
    let joint = world.create_joint(&def).expect("a valid joint");
    for _ in 0..rate / 3 {
        world.step(1.0 / rate as f32).expect("a valid step");
        if let [broken] = world.broken() {
            let force = broken.force.dot(along) * -side;
            assert!((force - side * limit).abs() < 0.3 * limit + 30.0, "told of {force} N along the line");
            return None;
        }
    }
    Some(world.joint_stress(joint).expect("a joint").share)
}

#[test]
fn a_distance_joint_bears_what_pulls_or_presses_along_its_line() {
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        for rate in [30, 60, 240] {
            for (spring, side) in [(false, 1.0), (false, -1.0), (true, 1.0)] {
                for seed in 1..6 {
                    let what = format!("{solver:?}, {rate} Hz, spring {spring}, side {side}, direction {seed}");
                    // It bears 100 N.
                    let share = share_along_a_line(solver, rate, spring, side, seed, 250.0);
                    assert!(share.is_some_and(|share| (share - 0.4).abs() < 0.02), "{what}: share {share:?} of 250 N, not 0.4");
                    let share = share_along_a_line(solver, rate, spring, side, seed, 80.0);
                    assert!(share.is_none(), "{what}: not broken at 80 N, with share {share:?}");
                }
            }
        }
    }
}

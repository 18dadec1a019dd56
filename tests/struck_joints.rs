//! What joints hold answers to a blow, to a force that acts for a few steps and to another mass as mechanics says.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Geometry, JointDef, JointKind, Limits, Mass, Material, Motor, Pose, Shape, ShapeDef, SphericalMotor, World,
    WorldDef,
};

use crate::common::oracle::{self, Dice};

fn weightless() -> World {
    World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap()
}

fn run(world: &mut World, count: usize, rate: f32) {
    for _ in 0..count {
        world.step(1.0 / rate).unwrap();
    }
}

/// A rod of a kilogram, as long as `size` along x (m), that begins at the origin.
fn rod(world: &mut World, size: f32) -> BodyId {
    let shape = Shape::cuboid(Vec3::new(0.5, 0.05, 0.05) * size).unwrap();
    let pose = Pose { position: DVec3::X * f64::from(0.5 * size), rotation: Quat::IDENTITY };
    let mut def = BodyDef::dynamic(pose).with_shape(ShapeDef::new(shape));
    (def.mass, def.can_sleep) = (Mass::Total(1.0), false);
    world.create_body(&def).unwrap()
}

/// Moment of inertia of such a rod about its beginning (kg·m²).
fn inertia_about_end(size: f32) -> f32 {
    size * size * (1.01 / 12.0 + 0.25)
}

/// Holds a body at the origin of the world, with the joint's axis along z.
fn hold(world: &mut World, kind: JointKind, body: BodyId, size: f32) {
    let turned = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    let mut def = JointDef::new(kind, BodyId::NULL, body);
    def.frame_a = Pose { position: DVec3::ZERO, rotation: turned };
    def.frame_b = Pose { position: DVec3::X * f64::from(-0.5 * size), rotation: turned };
    world.create_joint(&def).unwrap();
}

/// A two-step method that takes over from the substep before a share of what acted in it gave three quarters of the impulse of a force
/// that acts for one step.
#[test]
fn a_force_of_a_few_steps_gives_its_impulse() {
    let rope = JointKind::Distance { limits: Limits::new(0.0, 0.5), spring_length: None, motor: Motor::Off };
    for rate in [30.0_f32, 60.0, 240.0] {
        for steps in [1, 2, 3, 6] {
            for (name, kind) in [("a hinge", JointKind::HINGE), ("a ball joint", JointKind::SPHERICAL), ("a rope", rope)] {
                let mut world = weightless();
                let body = rod(&mut world, 1.0);
                let is_rope = matches!(kind, JointKind::Distance { .. });
                if is_rope {
                    world.create_joint(&JointDef::new(kind, BodyId::NULL, body)).unwrap();
                } else {
                    hold(&mut world, kind, body, 1.0);
                }
                run(&mut world, 5, rate);
                let impulse = 0.02;
                for _ in 0..steps {
                    world.add_force(body, Vec3::Y * (impulse * rate / steps as f32)).unwrap();
                    world.step(1.0 / rate).unwrap();
                }
                run(&mut world, 10, rate);
                let share = if is_rope {
                    world.linear_velocity(body).unwrap().length() / impulse
                } else {
                    world.angular_velocity(body).unwrap().z / (0.5 * impulse / inertia_about_end(1.0))
                };
                assert!((share - 1.0).abs() < 2.0e-3, "{name}, {steps} steps, {rate} Hz: {share} of the impulse");
            }
        }
    }
}

/// The same where two bodies and five answer: what they have of momentum is what the force gave.
#[test]
fn a_force_of_one_step_gives_a_free_chain_its_impulse() {
    for (rate, count) in [(60.0_f32, 2), (60.0, 5), (240.0, 5)] {
        let mut world = weightless();
        let mut chain = Vec::new();
        for number in 0..count {
            let body = rod(&mut world, 1.0);
            world.set_pose(body, Pose { position: DVec3::X * (0.5 + f64::from(number)), rotation: Quat::IDENTITY }).unwrap();
            if let Some(&last) = chain.last() {
                let mut def = JointDef::new(JointKind::SPHERICAL, last, body);
                (def.frame_a.position, def.frame_b.position) = (DVec3::X * 0.5, DVec3::X * -0.5);
                world.create_joint(&def).unwrap();
            }
            chain.push(body);
        }
        run(&mut world, 5, rate);
        world.add_force(chain[0], Vec3::Y * (0.02 * rate)).unwrap();
        run(&mut world, 11, rate);
        let momentum: f32 = chain.iter().map(|&body| world.linear_velocity(body).unwrap().y).sum();
        assert!((momentum / 0.02 - 1.0).abs() < 2.0e-3, "{count} rods, {rate} Hz: {} of the impulse", momentum / 0.02);
    }
}

/// Looked for at the end of a way on which the joint would have turned it far, the speed was 0.4 to 0.66 of it from 0.05 rad in a substep on, and on
/// a ball joint five times of it, about the rod's length.
#[test]
fn a_blow_turns_a_rod_about_its_joint_at_the_speed_that_its_inertia_says() {
    for rate in [30.0_f32, 60.0, 240.0] {
        for (size, speed) in [(1.0_f32, 0.1_f32), (1.0, 0.8), (1.0, 3.0), (1.0, 9.0), (1.0, 20.0), (0.05, 9.0), (20.0, 3.0)] {
            for (name, kind) in [("a hinge", JointKind::HINGE), ("a ball joint", JointKind::SPHERICAL)] {
                for is_set in [false, true] {
                    let mut world = weightless();
                    let body = rod(&mut world, size);
                    hold(&mut world, kind, body, size);
                    let impulse = speed * inertia_about_end(size);
                    if is_set {
                        let own = size * size * 1.01 / 12.0;
                        world.set_angular_velocity(body, Vec3::Z * (impulse / own)).unwrap();
                    } else {
                        world.add_angular_impulse(body, Vec3::Z * impulse).unwrap();
                    }
                    run(&mut world, 3, rate);
                    let turning = world.angular_velocity(body).unwrap();
                    let what = format!("{name}, {size} m, {speed} rad/s, {rate} Hz, set: {is_set}");
                    assert!((turning.z / speed - 1.0).abs() < 0.01, "{what}: {} of the speed", turning.z / speed);
                    assert!(turning.truncate().length() < 1.0e-3 * speed, "{what}: turns at {turning}");
                }
            }
        }
    }
}

/// What a pendulum swings like does not depend on its mass; with half the mass it lost a tenth of its energy, with a hundredth it was flung round.
#[test]
fn a_pendulum_swings_on_alike_with_another_mass() {
    for rate in [30.0_f32, 60.0, 240.0] {
        for share in [0.01_f32, 0.5, 0.9, 1.1, 2.0, 100.0] {
            for (name, kind) in [("a hinge", JointKind::HINGE), ("a ball joint", JointKind::SPHERICAL)] {
                let mut world = World::new(&WorldDef::default()).unwrap();
                let body = rod(&mut world, 1.0);
                hold(&mut world, kind, body, 1.0);
                let energy = |world: &World| {
                    let spin = world.angular_velocity(body).unwrap().length();
                    let height = world.center_of_mass(body).unwrap().y as f32;
                    0.5 * inertia_about_end(1.0) * spin * spin + 9.81 * height
                };
                run(&mut world, (0.4 * rate) as usize, rate);
                world.set_mass(body, Mass::Total(share)).unwrap();
                run(&mut world, rate as usize, rate);
                // Of m g l; it starts with none.
                let gained = energy(&world) / (9.81 * 0.5);
                let most = 3.0e-3 * (60.0 / rate).max(0.5).powi(2);
                assert!(gained.abs() < most, "{name}, {share} of the mass, {rate} Hz: {gained} of m g l");
            }
        }
    }
}

/// A block and a capsule on one joint with stops, and a box that flies at them: kinetic energy (J) and momentum (N·s).
struct Hit {
    world: World,
    bodies: [(BodyId, f32); 3],
}

impl Hit {
    fn new(kind: JointKind, dice: &mut Dice) -> Self {
        let mut world = weightless();
        let mut make = |shape: Shape, mass: f32, position: DVec3| {
            let mut def = BodyDef::dynamic(dice.pose(position)).with_shape(ShapeDef::new(shape));
            if mass > 10.0 {
                def.pose.rotation = Quat::IDENTITY;
            }
            (def.mass, def.can_sleep) = (Mass::Total(mass), false);
            (world.create_body(&def).unwrap(), mass)
        };
        let block = make(Shape::cuboid(Vec3::new(0.2, 0.3, 0.1)).unwrap(), 30.0, DVec3::ZERO);
        let limb = make(Shape::capsule(0.2, 0.06).unwrap(), 4.0, DVec3::new(-0.2, -0.5, 0.0));
        let missile = make(Shape::cuboid(Vec3::splat(0.2)).unwrap(), 8.0, DVec3::ZERO);
        world.set_pose(limb.0, Pose { position: DVec3::new(-0.2, -0.5, 0.0), rotation: Quat::IDENTITY }).unwrap();
        let mut def = JointDef::new(kind, block.0, limb.0);
        (def.frame_a.position, def.frame_b.position) = (DVec3::new(-0.2, -0.25, 0.0), DVec3::new(0.0, 0.25, 0.0));
        world.create_joint(&def).unwrap();
        let (from, to) = (dice.direction() * 1.5, DVec3::new(-0.1, -0.25, 0.0) + dice.vector(0.25));
        world.set_pose(missile.0, Pose { position: from, ..world.pose(missile.0).unwrap() }).unwrap();
        world.set_linear_velocity(missile.0, ((to - from).normalize() * 10.0).as_vec3()).unwrap();
        world.set_angular_velocity(missile.0, dice.vector(3.0).as_vec3()).unwrap();
        Self { world, bodies: [block, limb, missile] }
    }

    fn energy(&self) -> f64 {
        let of = |&(body, mass): &(BodyId, f32)| {
            let properties = self.world.mass_properties(body).unwrap().unwrap();
            let axes = self.world.pose(body).unwrap().rotation * properties.inertia_frame;
            let spin = axes.conjugate() * self.world.angular_velocity(body).unwrap();
            let turning = (properties.principal_inertia * spin * spin).element_sum();
            f64::from(0.5 * (mass * self.world.linear_velocity(body).unwrap().length_squared() + turning))
        };
        self.bodies.iter().map(of).sum()
    }

    fn momentum(&self) -> Vec3 {
        self.bodies.iter().map(|&(body, mass)| self.world.linear_velocity(body).unwrap() * mass).sum()
    }
}

/// As a stop was met, contacts that had not closed yet were taken for closed: of 200 hits by a box three to seven gained, up to seven million times
/// what there was, and ropes flung bodies by kilometres.
#[test]
fn what_flies_beside_a_joint_that_meets_its_stop_gains_nothing() {
    let range = Limits::new(-0.6, 0.6);
    let kinds = [
        ("a hinge", JointKind::Hinge { limits: range, motor: Motor::Off }),
        ("a slider", JointKind::Prismatic { limits: Limits::new(-0.05, 0.05), motor: Motor::Off }),
        ("a rope", JointKind::Distance { limits: Limits::new(0.0, 0.1), spring_length: None, motor: Motor::Off }),
        ("a ball joint", JointKind::Spherical { swing_limit: 0.5, twist_limits: range, motor: SphericalMotor::Off }),
    ];
    for (number, (name, kind)) in kinds.into_iter().enumerate() {
        for (rate, hits) in [(60.0_f32, 60), (240.0, 20)] {
            for hit in 0..hits {
                let mut dice = oracle::dice(1000 * number + hit);
                let mut scene = Hit::new(kind, &mut dice);
                let (energy, momentum) = (scene.energy(), scene.momentum());
                for step in 0..(0.6 * rate) as usize {
                    scene.world.step(1.0 / rate).unwrap();
                    let gained = scene.energy() / energy - 1.0;
                    let lost = (scene.momentum() - momentum).length() / momentum.length();
                    let what = format!("{name}, hit {hit}, {rate} Hz, step {step}");
                    assert!(gained < 0.01, "{what}: {gained} of the energy more");
                    assert!(lost < 1.0e-3, "{what}: {lost} of the momentum off");
                }
            }
        }
    }
}

/// Carried by an articulation that it never touches, and extrapolated by what its momentum did in the last substep, it gained up to 26,000 times its
/// energy.
#[test]
fn what_tumbles_past_a_hinged_bar_keeps_its_energy() {
    let cylinder = Shape::new(Geometry::Cylinder { half_height: 0.42, radius: 0.035 }).unwrap();
    let shapes = [Shape::capsule(0.385, 0.035).unwrap(), Shape::cuboid(Vec3::new(0.035, 0.42, 0.035)).unwrap(), cylinder];
    for (shape, rate, spin) in [(0, 60.0_f32, 200.0_f32), (1, 60.0, 200.0), (2, 60.0, 80.0), (0, 30.0, 40.0), (0, 240.0, 800.0)] {
        for case in 0..10 {
            let mut dice = oracle::dice(case);
            let mut world = weightless();
            let mut def = BodyDef::dynamic(Pose::IDENTITY).with_shape(ShapeDef::new(shapes[shape].clone()));
            (def.mass, def.can_sleep) = (Mass::Total(5.0), false);
            def.linear_velocity = Vec3::X * 12.0;
            def.angular_velocity = Vec3::new(dice.between(0.25, 0.5) as f32, dice.between(0.5, 1.0) as f32, 0.0) * spin;
            let body = world.create_body(&def).unwrap();
            let beside = DVec3::new(6.0 + dice.between(-3.0, 3.0), 1.2 + dice.between(0.0, 0.5), dice.between(-1.0, 1.0));
            let bar = BodyDef::dynamic(Pose { position: beside, rotation: Quat::from_rotation_z(std::f32::consts::FRAC_PI_2) });
            let bar = world.create_body(&bar.with_shape(ShapeDef::new(Shape::capsule(0.4, 0.035).unwrap()))).unwrap();
            let mut joint = JointDef::new(JointKind::SPHERICAL, BodyId::NULL, bar);
            (joint.frame_a.position, joint.frame_b.position) = (beside - DVec3::X * 0.45, DVec3::Y * 0.45);
            world.create_joint(&joint).unwrap();
            let mass = world.mass_properties(body).unwrap().unwrap();
            let energy = |world: &World| {
                let axes = world.pose(body).unwrap().rotation * mass.inertia_frame;
                let spin = axes.conjugate() * world.angular_velocity(body).unwrap();
                0.5 * (mass.principal_inertia * spin * spin).element_sum()
            };
            let before = energy(&world);
            for step in 0..rate as usize {
                world.step(1.0 / rate).unwrap();
                let share = energy(&world) / before;
                assert!((share - 1.0).abs() < 0.01, "shape {shape}, case {case}, {rate} Hz, step {step}: {share} of the energy");
                let speed = world.linear_velocity(body).unwrap().length();
                assert!((speed - 12.0).abs() < 0.01, "shape {shape}, case {case}, {rate} Hz, step {step}: {speed} m/s");
            }
        }
    }
}

/// A stop that had pressed against a force went on without it, in the share that a two-step method takes over: at 0.24 of the impulse.
#[test]
fn what_is_let_go_stays_at_its_stop() {
    let rope = JointKind::Distance { limits: Limits::new(0.0, 0.5), spring_length: None, motor: Motor::Off };
    let slider = JointKind::Prismatic { limits: Limits::new(0.0, 1.0), motor: Motor::Off };
    for rate in [30.0_f32, 60.0, 240.0] {
        for steps in [1_usize, 3, 60] {
            for (name, kind, push) in [("a rope", rope, Vec3::X), ("a slider", slider, Vec3::NEG_X)] {
                let mut world = weightless();
                let body = rod(&mut world, 1.0);
                let mut def = JointDef::new(kind, BodyId::NULL, body);
                if name == "a slider" {
                    def.frame_a.position = DVec3::X * 0.5;
                }
                world.create_joint(&def).unwrap();
                run(&mut world, 5, rate);
                for _ in 0..steps {
                    world.add_force(body, push * 100.0).unwrap();
                    world.step(1.0 / rate).unwrap();
                }
                run(&mut world, 5, rate);
                let speed = world.linear_velocity(body).unwrap().length();
                // Of what the force gives in a step.
                let share = speed / (100.0 / rate);
                assert!(share < 1.0e-3, "{name}, {steps} steps, {rate} Hz: leaves its stop with {share} of a step's impulse");
            }
        }
    }
}

/// Contacts of what turns far within a step, taken where it starts, are of where it will not be: sticks that passed two hinged capsules at 5 cm were turned
/// aside in half to all cases, up to 1300 times their energy.
#[test]
fn a_spinning_stick_passes_jointed_bodies_as_if_they_were_not_there() {
    for (rate, stride, clearance) in
        [(60.0_f32, 0.1_f32, 0.01_f32), (60.0, 0.3, 0.05), (60.0, 0.5, 0.05), (30.0, 0.5, 0.2), (240.0, 0.5, 0.05)]
    {
        for case in 0..12 {
            let mut dice = oracle::dice(case);
            let mut world = weightless();
            let mut make = |shape: Shape, pose: Pose| {
                let mut def = BodyDef::dynamic(pose).with_shape(ShapeDef::new(shape));
                (def.mass, def.can_sleep) = (Mass::Total(1.0), false);
                world.create_body(&def).unwrap()
            };
            let along = Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2);
            let capsules =
                [-0.3, 0.3].map(|x| make(Shape::capsule(0.25, 0.05).unwrap(), Pose { position: DVec3::X * x, rotation: along }));
            let height = f64::from(0.05 + 0.08 + clearance);
            let start = DVec3::new(dice.between(-0.2, 0.2), -0.7, height);
            let turned = Quat::from_rotation_z(dice.between(0.0, 3.0) as f32);
            let stick = make(Shape::cuboid(Vec3::new(0.4, 0.04, 0.08)).unwrap(), Pose { position: start, rotation: turned });
            let mut def = JointDef::new(JointKind::SPHERICAL, capsules[0], capsules[1]);
            (def.frame_a.position, def.frame_b.position) = (DVec3::Y * 0.3, DVec3::Y * -0.3);
            world.create_joint(&def).unwrap();
            let (speed, spin) = (Vec3::Y * 2.0, Vec3::Z * (stride * rate));
            world.set_linear_velocity(stick, speed).unwrap();
            world.set_angular_velocity(stick, spin).unwrap();
            for step in 0..(0.7 * rate) as usize {
                world.step(1.0 / rate).unwrap();
                let what = format!("{rate} Hz, {stride} rad a step, {clearance} m, case {case}, step {step}");
                let off = (world.linear_velocity(stick).unwrap() - speed).length() / 2.0;
                let turned = (world.angular_velocity(stick).unwrap() - spin).length() / spin.length();
                assert!(off < 1.0e-3 && turned < 1.0e-3, "{what}: {off} of its speed off, {turned} of its spin");
            }
        }
    }
}

/// Two plates, each of 10 kg and half a metre wide along x, side by side, and a ball of a gram that comes down on the left one, without friction.
struct Plates {
    world: World,
    plates: [BodyId; 2],
    ball: BodyId,
}

impl Plates {
    /// The left plate hangs on the world at its edge, or on the other plate; the ball reaches `spot` on its face in the middle of a step.
    fn new(is_door: bool, radius: f32, velocity: Vec3, spot: DVec3, rate: f32) -> Self {
        let mut world = weightless();
        let mut make = |shape: Shape, mass: f32, at: DVec3| {
            let mut shape = ShapeDef::new(shape);
            shape.material = Material { friction: 0.0, restitution: 0.5, ..Material::default() };
            let mut def = BodyDef::dynamic(Pose { position: at, rotation: Quat::IDENTITY }).with_shape(shape);
            (def.mass, def.can_sleep) = (Mass::Total(mass), false);
            world.create_body(&def).unwrap()
        };
        let plate = Shape::cuboid(Vec3::new(0.25, 0.02, 0.25)).unwrap();
        let plates = [-0.26, 0.26].map(|x| make(plate.clone(), 10.0, DVec3::X * x));
        let over = spot + DVec3::Y * f64::from(0.02 + radius);
        let shape = Shape::new(Geometry::Ball { radius }).unwrap();
        let ball = make(shape, 0.001, over - velocity.as_dvec3() * (2.5 / f64::from(rate)));
        world.set_linear_velocity(ball, velocity).unwrap();
        world.set_fast(ball, true).unwrap();
        let (other, x) = if is_door { (BodyId::NULL, -0.25) } else { (plates[1], 0.26) };
        let mut joint = JointDef::new(JointKind::HINGE, other, plates[0]);
        joint.frame_a.position = DVec3::X * if is_door { -0.51 } else { -0.26 };
        joint.frame_b.position = DVec3::X * x;
        let along = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
        (joint.frame_a.rotation, joint.frame_b.rotation) = (along, along);
        world.create_joint(&joint).unwrap();
        Self { world, plates, ball }
    }

    /// What the plates have of momentum and of angular momentum about a point.
    fn momenta(&self, about: DVec3) -> [DVec3; 2] {
        let of = |&plate: &BodyId| {
            let properties = self.world.mass_properties(plate).unwrap().unwrap();
            let axes = self.world.pose(plate).unwrap().rotation * properties.inertia_frame;
            let spin = axes * (properties.principal_inertia * (axes.conjugate() * self.world.angular_velocity(plate).unwrap()));
            let momentum = self.world.linear_velocity(plate).unwrap().as_dvec3() * 10.0;
            let lever = self.world.center_of_mass(plate).unwrap() - about;
            [momentum, lever.cross(momentum) + spin.as_dvec3()]
        };
        let [[p, l], [q, m]] = [of(&self.plates[0]), of(&self.plates[1])];
        [p + q, l + m]
    }
}

/// Taken from where a step began, the normal was that of an edge that the ball had passed or not reached: of 200 shots at 30 m/s 34 came back more than
/// 5 % off along the face, and at 100 m/s 156.
#[test]
fn what_comes_fast_onto_a_face_that_a_hinge_holds_keeps_its_speed_along_it() {
    for (rate, speed, radius) in
        [(30.0_f32, 30.0_f32, 0.05_f32), (60.0, 30.0, 0.05), (60.0, 100.0, 0.05), (240.0, 100.0, 0.02), (60.0, 900.0, 0.0045)]
    {
        let mut at_a_seam = 0;
        for case in 0..20 {
            let mut dice = oracle::dice(case);
            let spot = DVec3::new(-0.26 + dice.between(-0.2, 0.2), 0.0, dice.between(-0.2, 0.2));
            let turn = dice.between(0.0, std::f64::consts::TAU) as f32;
            let velocity = Vec3::new(0.77 * turn.cos(), -0.64, 0.77 * turn.sin()) * speed;
            for is_door in [true, false] {
                let mut scene = Plates::new(is_door, radius, velocity, spot, rate);
                run(&mut scene.world, 3, rate);
                let what = format!("{speed} m/s, {rate} Hz, {radius} m, case {case}, door: {is_door}");
                let then = scene.world.linear_velocity(scene.ball).unwrap();
                let along = (then - velocity).reject_from_normalized(Vec3::Y).length() / speed;
                // Off the edge of the plate beside, as from flush plates that nothing joins: 10 of 200.
                if along > 0.01 {
                    at_a_seam += 1;
                    assert!(at_a_seam <= 4, "{what}: {along} of its speed off along the face, and of {at_a_seam} so far");
                    continue;
                }
                assert!((then.y / velocity.y + 0.5).abs() < 0.03, "{what}: leaves at {} m/s from {}", then.y, velocity.y);
                // A blow has no moment about where it is; at rates at which a plate is passed in a few substeps that is known to half its width.
                let [momentum, angular] = scene.momenta(spot + DVec3::Y * 0.02);
                let arm = angular.length() / momentum.length();
                assert!(is_door || arm < 0.1, "{what}: struck {arm} m beside the spot");
            }
        }
    }
}

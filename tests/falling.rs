//! What falls together stays together, and falls as a single body does.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Geometry, JointDef, JointKind, LocalPose, MAX_LINEAR_SPEED, Mass, Pose, Shape, ShapeDef, Solver, World,
    WorldDef,
};

const GRAVITY: f64 = 9.81;

/// A hollow cube of this width (m), the walls of which are a fiftieth of it thick, and things that touch them from inside.
struct Room {
    world: World,
    room: BodyId,
    things: Vec<BodyId>,
}

impl Room {
    fn new(width: f32, shape: &Shape, density: f32) -> Self {
        let mut world = World::new(&WorldDef { gravity: Vec3::NEG_Y * GRAVITY as f32, ..WorldDef::default() }).unwrap();
        let (half, wall) = (0.5 * width, 0.02 * width);
        let walls = (0..6).map(|side| {
            let mut extents = Vec3::splat(half + wall);
            extents[side / 2] = 0.5 * wall;
            let mut position = Vec3::ZERO;
            position[side / 2] = (half + 0.5 * wall) * if side % 2 == 0 { -1.0 } else { 1.0 };
            let shape = ShapeDef::new(Shape::new(Geometry::Box { half_extents: extents }).unwrap());
            ShapeDef { local_pose: LocalPose { position, rotation: Quat::IDENTITY }, ..shape }
        });
        let room = world.create_body(&walls.fold(BodyDef::dynamic(Pose::IDENTITY), BodyDef::with_shape)).unwrap();
        let (w, near) = (f64::from(width), 0.45 * f64::from(width));
        let places = [
            DVec3::new(0.0, near, 0.0),
            DVec3::new(0.25 * w, -near, 0.0),
            DVec3::new(near, 0.2 * w, 0.0),
            DVec3::new(-0.25 * w, near, 0.25 * w),
            DVec3::new(0.0, 0.0, near),
            // One that touches nothing.
            DVec3::new(0.0, -0.1 * w, -0.2 * w),
        ];
        let part = ShapeDef { density, ..ShapeDef::new(shape.clone()) };
        let things = places.map(|at| world.create_body(&BodyDef::dynamic(Pose::at(at)).with_shape(part.clone())).unwrap());
        Self { world, room, things: things.to_vec() }
    }

    /// Greatest distance that a thing has gone from its place in the room, and the room from its parabola (m), in a second.
    fn strays(mut self, rate: u32) -> [f64; 2] {
        let place = |world: &World, body: BodyId| world.pose(body).unwrap().position;
        let places =
            |world: &World| self.things.iter().map(|&body| place(world, body) - place(world, self.room)).collect::<Vec<_>>();
        let before = places(&self.world);
        for _ in 0..rate {
            self.world.step(1.0 / rate as f32).unwrap();
        }
        let moved = places(&self.world).iter().zip(&before).map(|(now, before)| (now - before).length()).fold(0.0, f64::max);
        [moved, (place(&self.world, self.room).y + 0.5 * GRAVITY).abs()]
    }
}

#[test]
fn what_lies_in_a_falling_room_falls_with_it() {
    for width in [0.05_f32, 0.2, 2.0, 20.0] {
        let half = 0.05 * width;
        let shapes = [
            ("ball", Shape::ball(half).unwrap()),
            ("box", Shape::cuboid(Vec3::splat(half)).unwrap()),
            ("cylinder", Shape::new(Geometry::Cylinder { half_height: half, radius: half }).unwrap()),
        ];
        for (name, shape) in &shapes {
            for density in [10.0, 1000.0, 1.0e5] {
                for rate in [30, 60, 120, 240] {
                    let [moved, off] = Room::new(width, shape, density).strays(rate);
                    let case = format!("{name} of {density} kg/m³ in a room of {width} m at {rate} Hz");
                    assert!(moved < 5.0e-4 * f64::from(width), "{case}: moved by {moved:.2e} m in it");
                    assert!(off < 1.0e-4, "{case}: {off:.2e} m off the parabola");
                }
            }
        }
    }
}

/// How far something falls or is pushed in two seconds with this damping (1/s), over g/c (t − (1 − exp(−c t))/c).
fn damped_way(damping: f32, by_force: bool, rate: f32, substeps: u32) -> f64 {
    let gravity = if by_force { 0.0 } else { GRAVITY as f32 };
    let mut world = World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, substeps, ..WorldDef::default() }).unwrap();
    let ball = ShapeDef::new(Shape::ball(0.1).unwrap());
    let body =
        world.create_body(&BodyDef { linear_damping: damping, ..BodyDef::dynamic(Pose::IDENTITY) }.with_shape(ball)).unwrap();
    let mass = world.mass_properties(body).unwrap().unwrap().mass;
    for _ in 0..(2.0 * rate) as u32 {
        if by_force {
            world.add_force(body, Vec3::NEG_Y * (mass * GRAVITY as f32)).unwrap();
        }
        world.step(1.0 / rate).unwrap();
    }
    let c = f64::from(damping);
    -world.pose(body).unwrap().position.y / (GRAVITY / c * (2.0 - (1.0 - (-2.0 * c).exp()) / c))
}

#[test]
fn what_is_damped_falls_at_its_terminal_speed() {
    for (rate, substeps) in [(30.0, 1), (30.0, 4), (60.0, 4), (240.0, 4)] {
        for damping in [1.0, 5.0, 20.0, 100.0, 1000.0] {
            for by_force in [false, true] {
                // Its speed rises as in implicit steps: it is behind by g/c h/2. Where way and speed did not agree it fell 0.8 of it with 100/s, and
                // rose with 1000.
                // By a force it is ahead by half a step of its speed, as each step moves it by the velocity at its end.
                let bound = if by_force { 0.5 / rate } else { 0.3 / (rate * substeps as f32) };
                let off = damped_way(damping, by_force, rate, substeps) - 1.0;
                assert!(
                    off.abs() < f64::from(bound),
                    "{damping}/s at {rate} Hz in {substeps} substeps: off by {off}, bound {bound}"
                );
            }
        }
    }
}

/// Bodies at rest that are to be pushed along x, by the name of how they are connected.
fn pushed(world: &mut World, how: &str) -> Vec<BodyId> {
    let half = 0.1;
    let ball = ShapeDef::new(Shape::ball(half).unwrap());
    let mut add = |x: f64| {
        let mut def = BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0)).with_mass(Mass::Total(1.0)).with_shape(ball.clone());
        def.locked_axes.translation[1] = how == "on a rail";
        def.linear_damping = if how == "damped" { 5.0 } else { 0.0 };
        world.create_body(&def).unwrap()
    };
    let apart = if how == "touching" { 0.2 } else { 0.3 };
    let count = if ["touching", "welded", "hinged"].contains(&how) { 2 } else { 1 };
    let bodies: Vec<BodyId> = (0..count).map(|number| add(apart * f64::from(number))).collect();
    let kind = if how == "welded" { JointKind::Fixed } else { JointKind::HINGE };
    if ["welded", "hinged"].contains(&how) {
        world.create_joint(&JointDef::new(kind, bodies[0], bodies[1]).at(Vec3::X * 0.15, Vec3::X * -0.15)).unwrap();
    }
    bodies
}

#[test]
fn what_is_pushed_beyond_the_greatest_speed_goes_that_way_at_that_speed() {
    let ways = ["alone", "on a rail", "damped", "touching", "welded", "hinged"];
    for (solver, rate) in
        [Solver::Auto, Solver::GaussSeidel].into_iter().flat_map(|solver| [30.0, 60.0, 240.0].map(|rate| (solver, rate)))
    {
        for (how, exponent) in ways.into_iter().flat_map(|how| (4..=10).map(move |exponent| (how, exponent))) {
            for by_force in [false, true] {
                let pull = Vec3::X * 10.0_f32.powi(exponent);
                let gravity = if by_force { Vec3::ZERO } else { pull };
                let mut world = World::new(&WorldDef { solver, gravity, ..WorldDef::default() }).unwrap();
                let bodies = pushed(&mut world, how);
                let most = f64::from(MAX_LINEAR_SPEED) / f64::from(rate);
                for step in 0..4 {
                    let place = |world: &World| bodies.iter().map(|&body| world.pose(body).unwrap().position).collect::<Vec<_>>();
                    let (before, speed) = (place(&world), world.linear_velocity(bodies[0]).unwrap().x);
                    if by_force {
                        bodies.iter().for_each(|&body| world.add_force(body, pull).unwrap());
                    }
                    world.step(1.0 / rate).unwrap();
                    for (before, after) in before.into_iter().zip(place(&world)) {
                        let way = (after - before) / most;
                        let what = format!(
                            "{solver:?}, {rate} Hz, {how}, {pull} m/s², by force: {by_force}, step {step}: {way} of the greatest way"
                        );
                        assert!(way.x > 0.0 && way.length() < 1.0 + 1.0e-4, "{what}");
                        // Joints turn what they hold a little, and take some of its way.
                        let least = if how == "hinged" { 0.99 } else { 0.999 };
                        assert!(speed < 0.9999 * MAX_LINEAR_SPEED || way.x > least, "{what} at {speed} m/s");
                    }
                }
            }
        }
    }
}

/// Nothing on a smooth floor takes speed along it. What a hit sent off its way was put back to where it touched, and the work of gravity on the rest of the
/// way was taken from all of its velocity: of 60 boxes and compounds each at 60 steps a second one and five lost up to nine tenths of it.
#[test]
fn what_lands_on_a_smooth_floor_keeps_its_speed_along_it() {
    let smooth = |geometry: Geometry| {
        let mut shape = ShapeDef::new(Shape::new(geometry).unwrap());
        shape.material.friction = 0.0;
        shape
    };
    for rate in [30.0_f32, 60.0, 120.0, 240.0] {
        for throw in 0..60_u32 {
            let mut world = World::new(&WorldDef::default()).unwrap();
            let ground = smooth(Geometry::Box { half_extents: Vec3::new(4.0, 0.1, 4.0) });
            world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.1, 0.0)).with_shape(ground)).unwrap();
            let [x, y, z, w] = [0.37, 0.73, 0.59, 0.17].map(|step| 2.0 * (1.0 + throw as f32 * step).fract() - 1.0);
            // The first of them is one that lost it.
            let (rotation, spin) = if throw == 0 {
                (Quat::from_xyzw(-0.902067, -0.031706, 0.079503, -0.423023), Vec3::new(3.291, 2.925, -3.8472))
            } else {
                (Quat::from_xyzw(x, y, z, w), Vec3::new(y, z, x) * 6.0)
            };
            let pose = Pose::at_xyz(0.01, 0.3, 0.015).rotated(rotation.normalize());
            let velocity = Vec3::new(0.379_473, -0.948_683, 0.158_114);
            let def = BodyDef { linear_velocity: velocity, angular_velocity: spin, ..BodyDef::dynamic(pose) };
            let body =
                world.create_body(&def.with_shape(smooth(Geometry::Box { half_extents: Vec3::new(0.05, 0.03, 0.04) }))).unwrap();
            for _ in 0..rate as u32 {
                world.step(1.0 / rate).unwrap();
                let now = world.linear_velocity(body).unwrap();
                let off = (now - velocity).reject_from_normalized(Vec3::Y).length();
                assert!(off < 2.0e-3, "throw {throw} at {rate} Hz: {now} of {velocity} m/s");
            }
        }
    }
}

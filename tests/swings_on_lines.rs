//! What hangs on ropes, rods or bars that close a loop keeps the energy of its swing while it touches something.

use std::f64::consts::PI;

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, BodyId, JointDef, JointKind, Limits, Mass, Material, Motor, Pose, Shape, ShapeDef, World, WorldDef};

const GRAVITY: f64 = 9.81;
const RATES: [f64; 4] = [30.0, 60.0, 120.0, 240.0];

struct Scene {
    world: World,
    /// With the mass of each (kg).
    bodies: Vec<(BodyId, f64)>,
    size: f64,
    friction: f32,
}

impl Scene {
    /// In which gravity leans by so much against what is at z > 0.
    fn new(size: f64, lean: f64, friction: f32) -> Self {
        let gravity = (GRAVITY * DVec3::new(0.0, -1.0, lean)).as_vec3();
        Self { world: World::new(&WorldDef { gravity, ..WorldDef::default() }).unwrap(), bodies: Vec::new(), size, friction }
    }

    /// A body at a place over `size`; one without a mass is fixed.
    fn add(&mut self, shape: Shape, mass: f64, at: DVec3) -> BodyId {
        let material = Material { friction: self.friction, ..Material::default() };
        let (shape, pose) = (ShapeDef { material, ..ShapeDef::new(shape) }, Pose::at(at * self.size));
        if mass == 0.0 {
            return self.world.create_body(&BodyDef::fixed(pose).with_shape(shape)).unwrap();
        }
        let mass = mass * self.size.powi(3);
        let def = BodyDef { mass: Mass::Total(mass as f32), ..BodyDef::dynamic(pose) };
        let body = self.world.create_body(&def.with_shape(shape)).unwrap();
        self.bodies.push((body, mass));
        body
    }

    fn cuboid(&mut self, half: Vec3, mass: f64, at: DVec3) -> BodyId {
        self.add(Shape::cuboid(half * self.size as f32).unwrap(), mass, at)
    }

    fn ball(&mut self, at: DVec3) -> BodyId {
        self.add(Shape::ball(0.1 * self.size as f32).unwrap(), 1.0, at)
    }

    /// Hangs a body, from a point of it, on a line from a point of the world: a rod, or a rope, which can be shorter.
    fn hang(&mut self, body: BodyId, is_rope: bool, from: DVec3, to: DVec3) {
        let length = ((to - from).length() * self.size) as f32;
        let limits = Limits::new(if is_rope { 0.0 } else { length }, length);
        let own = to * self.size - self.world.pose(body).unwrap().position;
        let kind = JointKind::Distance { limits, spring_length: None, motor: Motor::Off };
        let def = JointDef::new(kind, BodyId::NULL, body).at((from * self.size).as_vec3(), own.as_vec3());
        self.world.create_joint(&def).unwrap();
    }

    /// Kinetic and potential energy of all that moves in a translation (J).
    fn energy(&self) -> f64 {
        let gravity = self.world.gravity().as_dvec3();
        let of = |&(body, mass): &(BodyId, f64)| {
            let speed = self.world.linear_velocity(body).unwrap().as_dvec3();
            mass * (0.5 * speed.length_squared() - gravity.dot(self.world.pose(body).unwrap().position))
        };
        self.bodies.iter().map(of).sum()
    }

    /// What is left of its energy after so many half swings on a length over `size`, begun at `angle`, and the most that it has been.
    fn kept(&mut self, rate: f64, half_swings: f64, [length, angle]: [f64; 2]) -> [f64; 2] {
        let mass: f64 = self.bodies.iter().map(|(_, mass)| mass).sum();
        let own = mass * GRAVITY * length * self.size * (1.0 - angle.cos());
        let (before, mut most) = (self.energy(), 0.0_f64);
        let seconds = half_swings * PI * (length * self.size / GRAVITY).sqrt();
        for _ in 0..(seconds * rate) as usize {
            self.world.step((1.0 / rate) as f32).unwrap();
            most = most.max((self.energy() - before) / own);
        }
        [1.0 + (self.energy() - before) / own, 1.0 + most]
    }
}

/// Where what hangs below a point is, on a line of this length at an angle from straight down.
fn below(point: DVec3, length: f64, angle: f64) -> DVec3 {
    point + length * DVec3::new(angle.sin(), -angle.cos(), 0.0)
}

/// A ball on lines of a metre in the plane across its swing, beside a wall that it does not rub on.
fn ball_at_a_wall(size: f64, [lines, gap, lean]: [f64; 3], is_rope: bool, angle: f64) -> Scene {
    let mut scene = Scene::new(size, lean, 0.0);
    let at = below(DVec3::ZERO, 1.0, angle);
    let ball = scene.ball(at);
    for line in 0..lines as usize {
        let aside = if lines == 1.0 { 0.0 } else { -0.3 + 0.3 * line as f64 };
        scene.hang(ball, is_rope, DVec3::Z * aside, at);
    }
    scene.cuboid(Vec3::new(3.0, 3.0, 0.1), 0.0, DVec3::new(0.0, 0.0, 0.2 + gap));
    scene
}

#[test]
fn a_ball_on_lines_keeps_its_energy_beside_a_wall() {
    for rate in RATES {
        for size in [0.1, 1.0, 10.0] {
            for (lines, is_rope, gap) in
                [(1.0, true, 0.0), (2.0, true, 0.0), (2.0, true, 1.0e-3), (2.0, false, 0.0), (3.0, true, 0.0)]
            {
                let [kept, most] = ball_at_a_wall(size, [lines, gap, 0.0], is_rope, 0.3).kept(rate, 8.0, [1.0, 0.3]);
                let most_told = if gap > 0.0 { 1.0e-3 } else { half_substep(size, rate) };
                let what = format!("{lines} lines of {size} m (ropes: {is_rope}), {gap} m from the wall, {rate} steps a second");
                println!("{what}: {kept:.4}, {most:.4} at most");
                assert!(
                    kept > 0.998 && kept.max(most) < 1.0 + most_told,
                    "{what}: {kept} of the energy are left, {most} at most"
                );
            }
        }
    }
}

/// Share of the energy of a swing of this length (m) by which ½ h v·a is too much at most, ¼ ω h: what presses has velocities of half a substep before,
/// and what is flush with a wall is pressed by rounding.
fn half_substep(size: f64, rate: f64) -> f64 {
    0.25 * (GRAVITY / size).sqrt() / (4.0 * rate) * 2.05
}

#[test]
fn a_ball_that_a_wall_bears_keeps_its_energy() {
    for rate in RATES {
        for lean in [0.01, 0.5] {
            let [kept, most] = ball_at_a_wall(1.0, [2.0, 0.0, lean], true, 0.3).kept(rate, 24.0, [1.0, 0.3]);
            println!("{lean} of its weight, {rate} steps a second: {kept:.4}, {most:.4} at most");
            let half_substep = half_substep(1.0, rate);
            assert!((kept - 1.0).abs() < half_substep && most < 1.0 + half_substep, "{lean}, {rate}: {kept}, {most} at most");
        }
    }
}

/// A seat on four ropes of two metres with a crate on it.
fn seat(size: f64) -> Scene {
    let mut scene = Scene::new(size, 0.0, 1.0);
    let at = below(DVec3::ZERO, 2.0, 0.3);
    let seat = scene.cuboid(Vec3::new(0.3, 0.03, 0.25), 5.0, at);
    scene.cuboid(Vec3::splat(0.2), 20.0, at + DVec3::Y * 0.23);
    for (x, z) in [(-0.3, -0.25), (-0.3, 0.25), (0.3, -0.25), (0.3, 0.25)] {
        let aside = DVec3::new(x, 0.0, z);
        scene.hang(seat, true, aside, at + aside);
    }
    scene
}

/// Two balls that touch, each on two ropes of a metre.
fn pair(size: f64) -> Scene {
    let mut scene = Scene::new(size, 0.0, 0.0);
    for place in [0.0, 0.200_002] {
        let point = DVec3::X * place;
        let at = below(point, 1.0, 0.3);
        let ball = scene.ball(at);
        for aside in [-0.4, 0.4] {
            scene.hang(ball, true, point + DVec3::Z * aside, at);
        }
    }
    scene
}

#[test]
fn what_swings_on_ropes_with_what_it_touches_keeps_its_energy() {
    for rate in RATES {
        for size in [0.1, 1.0, 10.0] {
            for (name, mut scene, length) in [("a seat with a crate", seat(size), 2.0), ("two balls", pair(size), 1.0)] {
                let [kept, _] = scene.kept(rate, 8.0, [length, 0.3]);
                let what = format!("{name}, {size} times as large, {rate} steps a second");
                println!("{what}: {kept:.4}");
                let most = 0.004 + half_substep(length * size, rate);
                assert!((kept - 1.0).abs() < most, "{what}: {kept} of the energy are left");
            }
        }
    }
}

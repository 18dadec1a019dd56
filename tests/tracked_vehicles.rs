//! A vehicle stands on its tracks as on a floor: links that bear a hundred times what they weigh do not sink, neither into the ground nor into wheels.

use std::f64::consts::{FRAC_PI_2, PI};

use longspan::glam::{DQuat, DVec2, DVec3, Quat, Vec3};
use longspan::{
    ArticulationSettings, BodyDef, BodyId, Geometry, JointDef, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, World,
    WorldDef,
};

/// Radius of a wheel, of the path that hinges are made on, and half a link's thickness, of a vehicle of size 1 (m).
const WHEEL: f64 = 0.276;
const PATH: f64 = 0.33;
const HALF_LINK: f64 = 0.027;
const LINKS: usize = 24;
/// Distance of the first axle from the last (m), and how high they are made over where links lie on the ground.
const SPAN: f64 = 1.2;
const HIGH: f64 = 0.38;

/// A vehicle on two tracks.
struct Vehicle {
    world: World,
    chassis: BodyId,
    wheels: Vec<BodyId>,
    links: Vec<BodyId>,
    size: f64,
}

impl Vehicle {
    /// Made a little over the ground; its first wheels hold their place.
    fn made(size: f64, budget: f32) -> Self {
        let articulations = ArticulationSettings { halving_budget: budget, ..ArticulationSettings::default() };
        let gravity = Vec3::NEG_Y * 9.81;
        let mut world = World::new(&WorldDef { gravity, articulations, ..WorldDef::default() }).expect("a valid world");
        let ground = shape(Geometry::HalfSpace { normal: Vec3::Y }, 0.8);
        world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(ground)).expect("a valid body");
        let at = Pose::at(DVec3::Y * HIGH * size);
        let hull = cuboid(DVec3::new(0.9, 0.2, 0.35) * size, 0.5);
        let chassis = put(&mut world, at, hull, 400.0 * size.powi(3));
        let mut own = Self { world, chassis, wheels: Vec::new(), links: Vec::new(), size };
        for side in [-0.6, 0.6] {
            own.add_wheels(side);
            own.add_track(side);
        }
        own
    }

    fn add_wheels(&mut self, side: f64) {
        let size = self.size;
        let across = DQuat::from_rotation_x(FRAC_PI_2).as_quat();
        for place in 0..3 {
            let at = DVec3::new(SPAN * (0.5 * f64::from(place) - 0.5), HIGH, side) * size;
            let drum = Geometry::Cylinder { half_height: (0.12 * size) as f32, radius: (WHEEL * size) as f32 };
            let wheel = put(&mut self.world, Pose::at(at).rotated(across), shape(drum, 1.5), 20.0 * size.powi(3));
            let motor = match place {
                0 => Motor::Velocity { target: 0.0, max_force: (800.0 * size.powi(4)) as f32 },
                _ => Motor::Off,
            };
            self.hinge(self.chassis, wheel, JointKind::Hinge { limits: Limits::NONE, motor }, at, 0.0);
            self.wheels.push(wheel);
        }
    }

    fn add_track(&mut self, side: f64) {
        let size = self.size;
        let pitch = (2.0 * SPAN + 2.0 * PI * PATH) / LINKS as f64;
        let points: Vec<DVec2> = (0..LINKS).map(|number| path(number as f64 * pitch) * size).collect();
        let first = self.links.len();
        let lift = DVec3::new(0.0, HIGH, side) * size;
        for (number, &from) in points.iter().enumerate() {
            let to = points[(number + 1) % LINKS];
            let half = DVec3::new(0.46 * (to - from).length(), HALF_LINK * size, 0.13 * size);
            let turn = Quat::from_rotation_z((to - from).to_angle() as f32);
            let pose = Pose::at((0.5 * (from + to)).extend(0.0) + lift).rotated(turn);
            self.links.push(put(&mut self.world, pose, cuboid(half, 1.0), 3.0 * size.powi(3)));
        }
        for (number, &at) in points.iter().enumerate() {
            let ends = [(number + LINKS - 1) % LINKS, number].map(|number| self.links[first + number]);
            self.hinge(ends[0], ends[1], JointKind::HINGE, at.extend(0.0) + lift, 0.5 * size.powi(4));
        }
    }

    /// A hinge about z at a point of the world.
    fn hinge(&mut self, a: BodyId, b: BodyId, kind: JointKind, at: DVec3, friction: f64) {
        let frame = |body: BodyId| {
            let pose = self.world.pose(body).expect("it is there");
            let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
            Pose::at(pose.inverse_transform_point(at).as_dvec3()).rotated(pose.rotation.conjugate() * about_z)
        };
        let mut def = JointDef::new(kind, a, b);
        (def.frame_a, def.frame_b, def.friction) = (frame(a), frame(b), friction as f32);
        self.world.create_joint(&def).expect("a valid joint");
    }

    fn step(&mut self, rate: f32, seconds: f32) {
        for _ in 0..(seconds * rate * self.size.sqrt() as f32) as u32 {
            self.world.step(1.0 / rate).expect("a valid step");
        }
    }

    /// Least height of these bodies, over the vehicle's size.
    fn lowest(&self, bodies: &[BodyId]) -> f64 {
        let height = |&body: &BodyId| self.world.pose(body).expect("it is there").position.y;
        bodies.iter().map(height).fold(f64::INFINITY, f64::min) / self.size
    }

    /// Way of the chassis along the tracks, over the vehicle's size.
    fn way(&self) -> f64 {
        self.world.pose(self.chassis).expect("it is there").position.x / self.size
    }
}

/// Where the path of hinges is so far along it, from over the first axle on (m).
fn path(along: f64) -> DVec2 {
    let (half, arc) = (0.5 * SPAN, PI * PATH);
    let round = |way: f64| DVec2::from_angle(FRAC_PI_2 - way / PATH) * PATH;
    match along {
        way if way < SPAN => DVec2::new(way - half, PATH),
        way if way < SPAN + arc => round(way - SPAN) + DVec2::X * half,
        way if way < 2.0 * SPAN + arc => DVec2::new(half - (way - SPAN - arc), -PATH),
        way => round(way - 2.0 * SPAN) - DVec2::X * half,
    }
}

fn shape(geometry: Geometry, friction: f32) -> ShapeDef {
    let mut def = ShapeDef::new(Shape::new(geometry).expect("a valid shape"));
    def.material.friction = friction;
    def
}

fn cuboid(half: DVec3, friction: f32) -> ShapeDef {
    shape(Geometry::Box { half_extents: half.as_vec3() }, friction)
}

fn put(world: &mut World, pose: Pose, shape: ShapeDef, mass: f64) -> BodyId {
    let def = BodyDef::dynamic(pose).with_shape(shape).with_mass(Mass::Total(mass as f32));
    world.create_body(&def).expect("a valid body")
}

/// How deep a parked vehicle may stand: half a millimetre of one of 1.8 m; where it lands by sweeps at few steps a second one wheel may stay in a link
/// that it has come to the middle of, by 10 mm of 60.
const FLAT: f64 = 5.0e-4;
const PRESSED_IN: f64 = 1.5e-2;

#[test]
fn a_parked_vehicle_stands_on_its_tracks_and_falls_asleep() {
    let cases = [
        (30.0, 1.0, PRESSED_IN),
        (60.0, 1.0, PRESSED_IN),
        (120.0, 1.0, FLAT),
        (240.0, 1.0, FLAT),
        (120.0, 0.1, FLAT),
        (240.0, 0.1, FLAT),
        (30.0, 10.0, FLAT),
        (60.0, 10.0, FLAT),
    ];
    for (rate, size, most) in cases {
        let mut vehicle = Vehicle::made(size, ArticulationSettings::default().halving_budget);
        vehicle.step(rate, 4.0);
        // Links lie flat on the ground, and wheels on them.
        let link = vehicle.lowest(&vehicle.links) - HALF_LINK;
        let axle = vehicle.lowest(&vehicle.wheels) - (WHEEL + 2.0 * HALF_LINK);
        let what = format!("size {size} at {rate}/s");
        assert!(link.abs() < most && axle.abs() < most, "{what}: links {link} m and axles {axle} m too high, bound {most} m");
        assert!(vehicle.way().abs() < 5.0e-3, "{what}: it has gone {} m", vehicle.way());
        assert!(!vehicle.world.is_awake(vehicle.chassis).expect("it is there"), "{what}: it is awake");
    }
}

#[test]
fn what_is_swept_on_tracks_comes_up_again_and_does_not_creep() {
    // Too little for a factor.
    let mut vehicle = Vehicle::made(1.0, 1.0);
    vehicle.step(60.0, 4.0);
    let (link, before) = (vehicle.lowest(&vehicle.links) - HALF_LINK, vehicle.way());
    vehicle.step(60.0, 2.0);
    let crept = (vehicle.way() - before).abs();
    // 45 mm and 5 mm/s where each substep began from nothing.
    assert!(link > -0.015, "a link is {link} m in the ground");
    assert!(crept < 2.0e-3, "it has crept {crept} m in 2 s");
}

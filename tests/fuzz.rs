//! Random calls over the whole interface: no panic, no pose that is not finite, and a world that was saved and restored goes on to the bit.
//!
//! Every seed is a world of its own and gives the same calls wherever it runs. `LONGSPAN_FUZZ_SEEDS=first..last` and
//! `LONGSPAN_FUZZ_CALLS=n` take others, for a search of hours; a failure names its seed and call.

use std::num::NonZero;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::thread::{available_parallelism, scope};

use longspan::glam::Vec3;
use longspan::{
    Axis, BodyDef, BodyId, BodyKind, CollisionFilter, FractureSettings, Geometry, JointDef, JointId, JointKind, Limits,
    LocalPose, LockedAxes, MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED, Mass, Material, Motor, Pose, QueryFilter, Ray, Shape, ShapeDef,
    ShapeId, Softness, Solver, SphericalMotor, Strength, World, WorldDef,
};
use longspan_scenes::Random;

/// Seeds and calls of each in an ordinary run, and seeds whose twins once differed.
const SEEDS: std::ops::Range<u64> = 0..6;
const MENDED: [u64; 12] =
    [119, 5521, 9021, 9033, 200_007, 800_059, 1_000_066, 2_050_084, 2_130_013, 5_100_035, 5_100_105, 5_100_195];
const CALLS: u32 = 700;

/// Most bodies of a world: more make calls slow, not more different.
const MAX_BODIES: usize = 40;

/// What rounding may put speeds above the limit that they are kept to.
const ROUNDED: f32 = 1.0 + 1.0e-6;

/// Makes what calls are made with.
struct Make {
    random: Random,
    shapes: Vec<Shape>,
}

type Motion = (Pose, Vec3, Vec3);

struct Fuzz {
    make: Make,
    world: World,
}

impl Make {
    fn chance(&mut self, one_in: usize) -> bool {
        self.random.index(one_in) == 0
    }

    fn pose(&mut self) -> Pose {
        let position = self.random.vector(3.0) + Vec3::Y * 3.0;
        Pose { position: position.as_dvec3(), rotation: self.random.rotation() }
    }

    /// A value over many orders of magnitude, now and then zero or endless.
    fn magnitude(&mut self) -> f32 {
        match self.random.index(8) {
            0 => 0.0,
            1 => f32::INFINITY,
            _ => 10.0_f32.powf(self.random.between(-4.0, 5.0)),
        }
    }

    fn shape_def(&mut self) -> ShapeDef {
        let shape = self.shapes[self.random.index(self.shapes.len())].clone();
        let material = Material {
            friction: self.random.between(0.0, 1.2),
            restitution: if self.chance(3) { self.random.between(0.0, 1.0) } else { 0.0 },
            ..Material::default()
        };
        let density = 10.0_f32.powf(self.random.between(1.0, 4.0));
        let local_pose = if self.chance(3) { LocalPose::at(self.random.vector(0.5)) } else { LocalPose::IDENTITY };
        ShapeDef { material, density, local_pose, sensor: self.chance(12), ..ShapeDef::new(shape) }
    }

    fn kind(&mut self) -> BodyKind {
        [BodyKind::Dynamic, BodyKind::Dynamic, BodyKind::Dynamic, BodyKind::Kinematic, BodyKind::Static][self.random.index(5)]
    }

    fn limits(&mut self, size: f32) -> Limits {
        match self.random.index(3) {
            0 => Limits::NONE,
            1 => Limits::new(0.0, 0.0),
            _ => Limits::new(self.random.between(-size, 0.0), self.random.between(0.0, size)),
        }
    }

    fn softness(&mut self) -> Softness {
        if self.chance(3) {
            Softness { compliance: 10.0_f32.powf(self.random.between(-8.0, -2.0)), damping: self.random.between(0.0, 100.0) }
        } else {
            Softness::RIGID
        }
    }

    fn motor(&mut self) -> Motor {
        let (target, max_force) = (self.random.between(-3.0, 3.0), self.magnitude());
        match self.random.index(3) {
            0 => Motor::Off,
            1 => Motor::Velocity { target, max_force },
            _ => Motor::Position { target, softness: self.softness(), max_force },
        }
    }

    fn joint_kind(&mut self) -> JointKind {
        let axis = |own: &mut Self| Axis { limits: own.limits(1.0), motor: own.motor() };
        match self.random.index(7) {
            0 | 1 => JointKind::Fixed,
            2 => JointKind::Hinge { limits: self.limits(2.0), motor: self.motor() },
            3 => JointKind::Spherical {
                swing_limit: self.random.between(0.1, 3.1),
                twist_limits: self.limits(2.0),
                motor: SphericalMotor::Velocity { target: self.random.vector(3.0), max_torque: self.magnitude() },
            },
            4 => JointKind::Prismatic { limits: self.limits(1.0), motor: self.motor() },
            5 => JointKind::Distance {
                limits: Limits::new(0.0, self.random.between(0.5, 3.0)),
                spring_length: None,
                motor: Motor::Off,
            },
            _ => JointKind::Generic { linear: [0; 3].map(|_: i32| axis(self)), angular: [0; 3].map(|_: i32| axis(self)) },
        }
    }

    fn strength(&mut self) -> Strength {
        if self.chance(2) {
            return Strength::UNBREAKABLE;
        }
        let limit = |own: &mut Self| 10.0_f32.powf(own.random.between(1.0, 6.0));
        Strength { tension: limit(self), shear: limit(self), bending: limit(self), ..Strength::UNBREAKABLE }
    }
}

impl Fuzz {
    fn new(seed: u64) -> Self {
        let mut random = Random::new(seed * 7919 + 99);
        let solver = [Solver::Auto, Solver::Auto, Solver::GaussSeidel, Solver::Direct][random.index(4)];
        let def = WorldDef {
            solver,
            support: random.index(3) == 0,
            hold: random.index(2) == 0,
            substeps: 1 + random.index(6) as u32,
            iterations: 1 + random.index(4) as u32,
            threads: 1 + random.index(3) as u32,
            ..WorldDef::default()
        };
        let geometries = [
            Geometry::Ball { radius: 0.4 },
            Geometry::Box { half_extents: Vec3::new(0.5, 0.3, 0.4) },
            Geometry::Capsule { half_height: 0.4, radius: 0.2 },
            Geometry::Cylinder { half_height: 0.3, radius: 0.3 },
            Geometry::Cone { half_height: 0.4, radius: 0.3 },
            Geometry::Compound {
                parts: [-1.0, 1.0]
                    .map(|x| (LocalPose::at(Vec3::X * x), Geometry::Box { half_extents: Vec3::splat(0.3) }))
                    .to_vec(),
            },
        ];
        let shapes = geometries.map(|geometry| Shape::new(geometry).unwrap()).to_vec();
        let mut world = World::new(&def).unwrap();
        let floor = Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap();
        world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(ShapeDef::new(floor))).unwrap();
        Self { make: Make { random, shapes }, world }
    }

    fn body(&mut self) -> BodyId {
        while self.world.body_count() == 0 {
            self.create_body();
        }
        let bodies: Vec<BodyId> = self.world.bodies().collect();
        bodies[self.make.random.index(bodies.len())]
    }

    fn joint(&mut self) -> Option<JointId> {
        let joints: Vec<JointId> = self.world.joints().collect();
        (!joints.is_empty()).then(|| joints[self.make.random.index(joints.len())])
    }

    fn shape_of(&mut self, body: BodyId) -> Option<ShapeId> {
        let shapes = self.world.body_shapes(body).ok()?.to_vec();
        (!shapes.is_empty()).then(|| shapes[self.make.random.index(shapes.len())])
    }

    fn create_joint(&mut self) {
        let kind = self.make.joint_kind();
        let (body_a, body_b) = (if self.make.chance(6) { BodyId::default() } else { self.body() }, self.body());
        let frame =
            |own: &mut Self| Pose { position: own.make.random.vector(0.6).as_dvec3(), rotation: own.make.random.rotation() };
        let def = JointDef {
            frame_a: frame(self),
            frame_b: frame(self),
            linear: self.make.softness(),
            angular: self.make.softness(),
            friction: if self.make.chance(3) { self.make.random.between(0.0, 5.0) } else { 0.0 },
            strength: self.make.strength(),
            collide_connected: self.make.chance(4),
            ..JointDef::new(kind, body_a, body_b)
        };
        let _ = self.world.create_joint(&def);
    }

    fn create_body(&mut self) {
        if self.world.body_count() >= MAX_BODIES {
            return;
        }
        let (kind, pose, shape) = (self.make.kind(), self.make.pose(), self.make.shape_def());
        let def = BodyDef {
            kind,
            linear_velocity: if self.make.chance(2) && kind != BodyKind::Static {
                self.make.random.vector(5.0)
            } else {
                Vec3::ZERO
            },
            fast: self.make.chance(6),
            ..BodyDef::dynamic(pose).with_shape(shape)
        };
        let _ = self.world.create_body(&def);
    }

    /// Changes something of a body. What does not apply to it is refused, and that is right.
    fn edit_body(&mut self) {
        let (body, number) = (self.body(), self.make.random.index(18));
        let _ = match number {
            0 => self.world.set_pose(body, self.make.pose()),
            1 => self.world.set_linear_velocity(body, self.make.random.vector(8.0)),
            2 => self.world.set_angular_velocity(body, self.make.random.vector(20.0)),
            3 => self.world.move_to(body, self.make.pose()),
            4 => self.world.set_mass(body, Mass::Total(10.0_f32.powf(self.make.random.between(-1.0, 4.0)))),
            5 => self.world.set_damping(body, self.make.random.between(0.0, 3.0), self.make.random.between(0.0, 3.0)),
            6 => self.world.set_gravity_scale(body, self.make.random.between(-1.0, 2.0)),
            7 => {
                let [translation, rotation] = [0, 1].map(|_: i32| [0; 3].map(|_: i32| self.make.random.index(4) == 0));
                self.world.set_locked_axes(body, LockedAxes { translation, rotation })
            }
            8 => self.world.set_body_kind(body, self.make.kind()),
            9 => self.world.add_force(body, self.make.random.vector(500.0)),
            10 => self.world.add_impulse(body, self.make.random.vector(50.0)),
            11 => self.world.add_angular_impulse(body, self.make.random.vector(5.0)),
            12 => self.world.put_to_sleep(body),
            13 => self.world.wake(body),
            14 => self.world.set_can_sleep(body, self.make.random.index(2) == 0),
            15 => {
                let def = self.make.shape_def();
                self.world.attach_shape(body, &def).map(drop)
            }
            16 => match self.shape_of(body) {
                Some(shape) if self.make.random.index(2) == 0 => self.world.destroy_shape(shape),
                Some(shape) => {
                    let def = self.make.shape_def();
                    self.world.set_shape_def(shape, &def)
                }
                None => Ok(()),
            },
            _ => match self.shape_of(body) {
                Some(shape) => self
                    .world
                    .set_filter(shape, CollisionFilter { collides_with: !0 << self.make.random.index(2), ..Default::default() }),
                None => Ok(()),
            },
        };
    }

    fn edit_joint(&mut self) {
        let Some(joint) = self.joint() else { return };
        let _ = match self.make.random.index(9) {
            0 => self.world.set_joint_kind(joint, self.make.joint_kind()),
            1 => self.world.set_joint_softness(joint, self.make.softness(), self.make.softness(), self.make.softness()),
            2 => self.world.set_joint_friction(joint, self.make.random.between(0.0, 5.0)),
            3 => self.world.set_joint_frames(
                joint,
                Pose::at(self.make.random.vector(0.5).as_dvec3()),
                Pose { position: self.make.random.vector(0.5).as_dvec3(), rotation: self.make.random.rotation() },
            ),
            4 => {
                let solver = [Solver::Auto, Solver::GaussSeidel, Solver::Direct][self.make.random.index(3)];
                self.world.set_joint_solver(joint, solver)
            }
            5 => self.world.set_joint_strength(joint, self.make.strength()),
            6 => self.world.apply_fractures(&[joint]),
            7 => self.world.set_joint_long_range(joint, self.make.random.index(2) == 0),
            _ => self.world.destroy_joint(joint),
        };
    }

    /// Asks the world what a host may ask at any time.
    fn ask(&mut self) {
        let (body, joint) = (self.body(), self.joint());
        let world = &self.world;
        let _ = (world.support(body), world.supporters(body), world.supported_by(body), world.path_to_ground(body));
        let _ = (world.would_lose_support(&[body]), world.load_on(body), world.support_hull(body), world.contact_force(body));
        let _ = (world.union_of(body), world.contacts().count(), world.bounds().count(), world.planes().count());
        if let Some(joint) = joint {
            let _ = (world.joint_state(joint), world.joint_stress(joint), world.chain(joint, joint));
        }
        let (origin, direction) = (self.make.random.vector(4.0).as_dvec3(), self.make.random.vector(1.0).normalize_or(Vec3::Y));
        let ray = Ray { origin, direction, length: 10.0 };
        let _ = self.world.cast_ray(&ray, &QueryFilter::default());
    }

    fn call(&mut self) {
        match self.make.random.index(20) {
            0..=2 => self.create_body(),
            3..=4 => self.create_joint(),
            5..=8 => self.edit_body(),
            9..=10 => self.edit_joint(),
            11 => self.ask(),
            12 if self.make.chance(4) => {
                let body = self.body();
                let _ = self.world.destroy_body(body);
            }
            13 if self.make.chance(8) => {
                let gravity = self.make.random.vector(12.0);
                self.world.set_gravity(gravity).unwrap();
            }
            13 if self.make.chance(4) => {
                let most = 1 + self.make.random.index(3) as u32;
                let by_load = self.make.random.index(2) == 0;
                self.world.set_fracture_settings(FractureSettings { most, by_load }).unwrap();
            }
            _ => self.step(),
        }
    }

    fn motions(&self) -> Vec<(BodyId, Motion)> {
        let motion = |body| {
            let world = &self.world;
            (world.pose(body).unwrap(), world.linear_velocity(body).unwrap(), world.angular_velocity(body).unwrap())
        };
        self.world.bodies().map(|body| (body, motion(body))).collect()
    }

    /// What moved otherwise than before, with what holds it.
    fn differences(&self, before: &[(BodyId, Motion)]) -> String {
        let now = self.motions();
        let differing = now.iter().zip(before).filter(|(now, before)| now != before);
        let told = differing.map(|((body, now), (_, before))| {
            let world = &self.world;
            let joints: Vec<_> = world.joints().map(|joint| world.joint_def(joint).unwrap()).collect();
            let joints: Vec<_> = joints.iter().filter(|def| def.body_a == *body || def.body_b == *body).collect();
            let (kind, contacts) = (world.body_kind(*body).unwrap(), world.contacts_of(*body).unwrap().count());
            format!("{body:?}, {kind:?}, {contacts} contacts, {joints:?}:\n  {before:?}\n  {now:?}")
        });
        told.collect::<Vec<_>>().join("\n")
    }

    /// Takes a step as a twin: once, and once more from a snapshot of before, both after the same edits.
    fn step_twice(&mut self, dt: f32) {
        let edits = self.make.random.index(3);
        let mut saved = Vec::new();
        self.world.save(&mut saved);
        let random = self.make.random.clone();
        self.edit_and_step(edits, dt);
        let (first, motions) = (self.world.state_hash(), self.motions());
        self.world.restore(&saved).unwrap();
        self.make.random = random;
        self.edit_and_step(edits, dt);
        let told = || self.differences(&motions);
        assert_eq!(self.world.state_hash(), first, "a step after a restore differs from the one before it:\n{}", told());
    }

    fn edit_and_step(&mut self, edits: usize, dt: f32) {
        for _ in 0..edits {
            if self.make.chance(2) { self.edit_body() } else { self.edit_joint() }
        }
        self.world.step(dt).unwrap();
    }

    /// Takes a step, now and then as a twin.
    fn step(&mut self) {
        let dt = [1.0 / 60.0, 1.0 / 60.0, 1.0 / 30.0, 1.0 / 240.0][self.make.random.index(4)];
        if self.make.chance(4) {
            self.step_twice(dt);
        } else {
            self.world.step(dt).unwrap();
        }
        for body in self.world.bodies() {
            let (pose, linear) = (self.world.pose(body).unwrap(), self.world.linear_velocity(body).unwrap());
            assert!(pose.position.is_finite() && pose.rotation.is_finite() && linear.is_finite(), "{body:?} is at {pose:?}");
            let (speed, spin) = (linear.length(), self.world.angular_velocity(body).unwrap().length());
            assert!(
                speed <= MAX_LINEAR_SPEED * ROUNDED && spin <= MAX_ANGULAR_SPEED * ROUNDED,
                "{body:?}: {speed} m/s, {spin} rad/s"
            );
        }
        for broken in self.world.broken() {
            assert!(broken.force.is_finite() && broken.torque.is_finite(), "{broken:?}");
        }
    }
}

fn from_environment<T: std::str::FromStr>(name: &str) -> Option<T> {
    std::env::var(name).ok()?.parse().ok()
}

#[test]
fn random_calls_leave_a_world_that_steps_and_restores_to_the_bit() {
    let chosen = std::env::var("LONGSPAN_FUZZ_SEEDS").ok();
    let ends = chosen.as_deref().and_then(|seeds| seeds.split_once(".."));
    let seeds = ends.map_or(SEEDS, |(first, last)| first.parse().expect("a number")..last.parse().expect("a number"));
    let calls = from_environment("LONGSPAN_FUZZ_CALLS").unwrap_or(CALLS);
    let mended = if chosen.is_none() { &MENDED[..] } else { &[] };
    let waiting = Mutex::new(seeds.chain(mended.iter().copied()));
    let threads = available_parallelism().map_or(1, NonZero::get);
    scope(|threads_of_test| {
        for _ in 0..threads {
            threads_of_test.spawn(|| {
                loop {
                    let Some(seed) = waiting.lock().unwrap().next() else { break };
                    run(seed, calls);
                }
            });
        }
    });
}

fn run(seed: u64, calls: u32) {
    let mut fuzz = Fuzz::new(seed);
    for number in 0..calls {
        let outcome = catch_unwind(AssertUnwindSafe(|| fuzz.call()));
        assert!(outcome.is_ok(), "seed {seed}, call {number}");
    }
}

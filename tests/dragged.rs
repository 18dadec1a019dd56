//! What a hand drags about by a spring is solved as one with what it touches, whatever limbs it has.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, JointDef, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, Softness, SphericalMotor, World,
    WorldDef,
};

/// How a hand holds a limb.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Grip {
    /// By a ball joint that gives.
    Ball,
    /// By six axes whose motors are springs.
    Axes,
    /// By a spring.
    Spring,
}

/// A limb, half of its length along its y axis without the caps, and its radius (m).
struct Limb {
    body: BodyId,
    half: f64,
    radius: f64,
}

/// A ragdoll of eleven capsules (kg, m) that lies on its back just above a floor.
struct Doll {
    world: World,
    size: f64,
    limbs: Vec<Limb>,
}

impl Doll {
    fn new(size: f64) -> Self {
        let mut world = World::new(&WorldDef::default()).unwrap();
        let floor = ShapeDef::new(Shape::cuboid(Vec3::new(60.0, 1.0, 60.0) * size.max(1.0) as f32).unwrap());
        world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -size.max(1.0), 0.0)).with_shape(floor)).unwrap();
        let mut doll = Self { world, size, limbs: Vec::new() };
        let ball = |swing_limit: f32| JointKind::Spherical {
            swing_limit,
            twist_limits: Limits::new(-0.5, 0.5),
            motor: SphericalMotor::Off,
        };
        let bends = JointKind::Hinge { limits: Limits::new(0.0, 2.4), motor: Motor::Off };
        let across = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let up = Quat::from_rotation_arc(Vec3::X, Vec3::Y);
        let pelvis = doll.limb((0.0, 0.0), across, (0.08, 0.11), 12.0);
        let chest = doll.limb((0.0, 0.33), Quat::IDENTITY, (0.12, 0.14), 24.0);
        let head = doll.limb((0.0, 0.72), Quat::IDENTITY, (0.02, 0.10), 5.0);
        doll.join((pelvis, chest), ball(0.6), (0.0, 0.12), up);
        doll.join((chest, head), ball(0.7), (0.0, 0.59), up);
        for side in [-1.0, 1.0] {
            let arm = doll.limb((side * 0.35, 0.47), across, (0.10, 0.05), 2.2);
            let hand = doll.limb((side * 0.64, 0.47), across, (0.10, 0.04), 1.6);
            let thigh = doll.limb((side * 0.10, -0.32), Quat::IDENTITY, (0.14, 0.075), 7.5);
            let shin = doll.limb((side * 0.10, -0.76), Quat::IDENTITY, (0.15, 0.055), 3.6);
            doll.join((chest, arm), ball(1.4), (side * 0.19, 0.47), Quat::IDENTITY);
            doll.join((arm, hand), bends, (side * 0.50, 0.47), up);
            doll.join((pelvis, thigh), ball(1.1), (side * 0.10, -0.11), up);
            doll.join((thigh, shin), bends, (side * 0.10, -0.54), Quat::IDENTITY);
        }
        doll
    }

    fn place((x, y): (f64, f64), turn: Quat, size: f64) -> Pose {
        // On its back: up is along −z, and the thickest limb is 5 mm above the floor.
        let back = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        let at = back.as_dquat() * DVec3::new(x, y, 0.0) + DVec3::Y * 0.145;
        Pose::at(at * size).rotated(back * turn)
    }

    fn limb(&mut self, at: (f64, f64), turn: Quat, (half, radius): (f64, f64), mass: f32) -> usize {
        let Self { world, size, limbs } = self;
        let (half, radius) = (half * *size, radius * *size);
        let shape = ShapeDef::new(Shape::capsule(half as f32, radius as f32).unwrap());
        let def = BodyDef::dynamic(Self::place(at, turn, *size)).with_shape(shape);
        let body = world.create_body(&def.with_mass(Mass::Total(mass * size.powi(3) as f32))).unwrap();
        limbs.push(Limb { body, half, radius });
        limbs.len() - 1
    }

    fn join(&mut self, (a, b): (usize, usize), kind: JointKind, at: (f64, f64), frame: Quat) {
        let [a, b] = [a, b].map(|limb| self.limbs[limb].body);
        let joint = Self::place(at, frame, self.size);
        let local = |body: BodyId| {
            let pose = self.world.pose(body).unwrap();
            let back = pose.rotation.conjugate();
            Pose::at(back.as_dquat() * (joint.position - pose.position)).rotated(back * joint.rotation)
        };
        let (frame_a, frame_b) = (local(a), local(b));
        self.world.create_joint(&JointDef { frame_a, frame_b, ..JointDef::new(kind, a, b) }).unwrap();
    }

    /// A hand that holds a limb in its middle, by a spring of 4 Hz under all that hangs on it.
    fn grip(&mut self, limb: usize, grip: Grip) -> BodyId {
        let (body, mass) = (self.limbs[limb].body, 75.0 * self.size.powi(3));
        let pose = self.world.pose(body).unwrap();
        let hand = self.world.create_body(&BodyDef::kinematic(pose)).unwrap();
        let rate = std::f64::consts::TAU * 4.0;
        let softness = Softness { compliance: (1.0 / (mass * rate * rate)) as f32, damping: (2.0 * mass * rate) as f32 };
        let free = Axis { limits: Limits::NONE, motor: Motor::Off };
        let held = Axis { limits: Limits::NONE, motor: Motor::Position { target: 0.0, softness, max_force: f32::INFINITY } };
        let kind = match grip {
            Grip::Ball => {
                JointKind::Spherical { swing_limit: std::f32::consts::PI, twist_limits: Limits::NONE, motor: SphericalMotor::Off }
            }
            Grip::Axes => JointKind::Generic { linear: [held; 3], angular: [free; 3] },
            Grip::Spring => {
                JointKind::Distance { limits: Limits::new(0.0, f32::INFINITY), spring_length: Some(0.0), motor: Motor::Off }
            }
        };
        let linear = if grip == Grip::Axes { Softness::RIGID } else { softness };
        self.world.create_joint(&JointDef { linear, ..JointDef::new(kind, hand, body) }).unwrap();
        hand
    }

    /// How deep the deepest limb is in the floor (m).
    fn depth(&self) -> f64 {
        let deep = |limb: &Limb| {
            let pose = self.world.pose(limb.body).unwrap();
            let axis = pose.rotation.as_dquat() * DVec3::Y;
            limb.radius + limb.half * axis.y.abs() - pose.position.y
        };
        self.limbs.iter().map(deep).fold(0.0, f64::max)
    }
}

/// Drags a ragdoll by one arm for two seconds; in how many steps of all its island was given up, and how deep limbs came into the floor (sizes).
fn drag(grip: Grip, rate: u32, size: f64, speed: f64) -> (usize, f64) {
    let mut doll = Doll::new(size);
    let hand = doll.grip(4, grip);
    let start = doll.world.pose(hand).unwrap();
    let (mut given_up, mut deepest) = (0, 0.0_f64);
    for step in 1..=2 * rate {
        let t = f64::from(step) / f64::from(rate);
        let way = DVec3::new(speed * (t - 0.3).max(0.0), (2.0 * t).min(1.0), 0.3 * (3.0 * t).sin()) * size;
        doll.world.move_to(hand, Pose { position: start.position + way, ..start }).unwrap();
        doll.world.step(1.0 / rate as f32).unwrap();
        given_up += usize::from(doll.world.islands().iter().any(|island| island.given_up));
        deepest = deepest.max(doll.depth() / size);
    }
    (given_up, deepest)
}

/// Measured: see the messages. What a hand's spring is drawn by was taken for a gap that the step has opened: of the steps by a ball joint half were
/// given up, and limbs went 40 mm into the floor.
fn is_solved_as_one(grip: Grip) {
    for (rate, size, speed) in
        [(30, 1.0, 1.0), (30, 1.0, 5.0), (60, 1.0, 3.0), (120, 1.0, 3.0), (240, 1.0, 3.0), (120, 0.1, 3.0), (30, 10.0, 2.0)]
    {
        let (given_up, depth) = drag(grip, rate, size, speed);
        let scene = format!("{grip:?} at {rate} 1/s, size {size}, {speed} sizes a second");
        assert!(given_up == 0, "{scene}: {given_up} of {} steps are given up", 2 * rate);
        // A hundredth of a man's height is what is seen.
        assert!(depth < 0.01, "{scene}: limbs are {depth} of the size in the floor, bound 0.01");
    }
}

#[test]
fn a_ragdoll_that_a_ball_joint_drags_is_solved_as_one() {
    is_solved_as_one(Grip::Ball);
}

#[test]
fn a_ragdoll_that_six_axes_drag_is_solved_as_one() {
    is_solved_as_one(Grip::Axes);
}

#[test]
fn a_ragdoll_that_a_spring_drags_is_solved_as_one() {
    is_solved_as_one(Grip::Spring);
}

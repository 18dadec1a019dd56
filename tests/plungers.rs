//! What a spring throws leaves at the speed that the spring gives it: plungers, catapults and slings, from rest.

use longspan::glam::{Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, JointDef, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, SleepSettings, Softness, World,
    WorldDef,
};

const PLUNGER: f32 = 0.1;
const DRAWN: f32 = 0.05;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Spring {
    Slider,
    SixAxis,
    Line,
    /// About an axis above it.
    Arm,
}

/// How far the axis of an arm is from what it throws, over what it is drawn by: so far that what it throws goes straight, to 0.4 %.
const ARM: f32 = 20.0;

impl Spring {
    /// A spring that is slack where its body's middle is at the origin.
    fn joint(self, body: BodyId, softness: Softness, drawn: f32) -> JointDef {
        // A motor that no bound stops is an equation to its solver, one that a bound stops is not.
        let max_force = if self == Self::SixAxis { 1.0e12 } else { f32::INFINITY };
        let motor = Motor::Position { target: 0.0, softness, max_force };
        let limits = Limits::NONE;
        let along = [Axis { limits, motor }, Axis::LOCKED, Axis::LOCKED];
        let length = 4.0 * drawn;
        let kind = match self {
            Self::Slider => JointKind::Prismatic { limits, motor },
            Self::SixAxis => JointKind::Generic { linear: along, angular: [Axis::LOCKED; 3] },
            Self::Arm => JointKind::Hinge { limits, motor },
            Self::Line => {
                JointKind::Distance { limits: Limits::new(0.0, f32::INFINITY), spring_length: Some(length), motor: Motor::Off }
            }
        };
        let at = match self {
            Self::Line => Vec3::X * -length,
            Self::Arm => Vec3::Y * (ARM * drawn),
            _ => Vec3::ZERO,
        };
        let mut joint = JointDef::new(kind, BodyId::NULL, body).at(at, if self == Self::Arm { at } else { Vec3::ZERO });
        if self == Self::Line {
            joint.linear = softness;
        }
        if self == Self::Arm {
            let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
            (joint.frame_a, joint.frame_b) = (joint.frame_a.rotated(about_z), joint.frame_b.rotated(about_z));
        }
        joint
    }
}

/// Speed at which a drawn spring throws a ball that lies on it, over that of one mass on the spring as it comes through the middle. Both are one
/// until there, as each is pressed on the other.
fn thrown(spring: Spring, rate: f32, frequency: f32, size: f32, ball_mass: f32) -> f32 {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, sleep, ..WorldDef::default() }).expect("a valid world");
    let (half, radius, drawn) = (0.05 * size, 0.02 * size, DRAWN * size);
    let mass = PLUNGER * size.powi(3);
    let shape = |shape: Shape| {
        let mut shape = ShapeDef::new(shape);
        (shape.material.friction, shape.material.restitution) = (0.0, 0.0);
        shape
    };
    let (arm, omega) = (ARM * drawn, std::f32::consts::TAU * frequency);
    let turn = if spring == Spring::Arm { -drawn / arm } else { 0.0 };
    let at = |x: f32| match spring {
        Spring::Arm => Quat::from_rotation_z(turn) * Vec3::new(x, -arm, 0.0) + Vec3::Y * arm,
        _ => Vec3::X * (x - drawn),
    };
    // An arm has its own inertia to turn as well.
    let inertia = if spring == Spring::Arm { mass * (half * half + radius * radius) / 3.0 } else { 0.0 };
    let moved = mass + inertia / (arm * arm);
    let pose = Pose::at(at(0.0).as_dvec3()).rotated(Quat::from_rotation_z(turn));
    let def = BodyDef::dynamic(pose).with_shape(shape(Shape::cuboid(Vec3::new(half, radius, radius)).expect("a shape")));
    let plunger = world.create_body(&def.with_mass(Mass::Total(mass))).expect("a valid body");
    let stiffness = moved * omega * omega * if spring == Spring::Arm { arm * arm } else { 1.0 };
    let softness = Softness { compliance: stiffness.recip(), damping: 0.0 };
    world.create_joint(&spring.joint(plunger, softness, drawn)).expect("a valid joint");
    let def = BodyDef::dynamic(Pose::at(at(half + radius).as_dvec3())).with_shape(shape(Shape::ball(radius).expect("a shape")));
    let ball = world.create_body(&def.with_mass(Mass::Total(ball_mass * mass))).expect("a valid body");
    for _ in 0..(0.4 * rate) as u32 {
        world.step(1.0 / rate).expect("a valid step");
    }
    world.linear_velocity(ball).expect("a body of the world").length() / (drawn * omega / (1.0 + ball_mass * mass / moved).sqrt())
}

#[test]
fn a_plunger_throws_at_the_speed_of_its_spring() {
    for spring in [Spring::Slider, Spring::SixAxis, Spring::Line, Spring::Arm] {
        // How much too slow: a spring of 13 Hz goes through the middle within a step of 1/30 s, in which it turns by 2.7 rad of its swing.
        for (rate, slow) in [(30.0, 0.06), (60.0, 0.03), (120.0, 0.01), (240.0, 0.01)] {
            for (size, frequency, ball_mass) in [(1.0, 8.0, 0.1), (0.1, 13.0, 0.4), (10.0, 13.0, 0.1), (1.0, 18.0, 1.6)] {
                let share = thrown(spring, rate, frequency, size, ball_mass);
                let what = format!("{spring:?} of {frequency} Hz, {size} m, a ball of {ball_mass} of its mass, {rate}/s");
                assert!((1.0 - slow..1.01).contains(&share), "{what}: thrown at {share} of its speed, {} to 1.01", 1.0 - slow);
            }
        }
    }
}

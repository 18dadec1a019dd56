//! Ragdolls that nobody has measured out come to rest and fall asleep, however their limbs come to lie.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, JointDef, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, SphericalMotor, World, WorldDef,
};

/// Friction of a joint (N·m) over m ∛m of the limb that it holds (kg): a tenth of what gravity turns limbs by that are as long as these. A limb
/// which swings freely comes to rest in seconds then; without friction it swings for ever.
const FRICTION: f32 = 0.1;

struct Maker {
    world: World,
    size: f32,
}

impl Maker {
    fn limb(&mut self, at: DVec3, turn: Quat, shape: Shape, mass: f32) -> BodyId {
        let def = BodyDef::dynamic(Pose::at(at * f64::from(self.size)).rotated(turn)).with_shape(ShapeDef::new(shape));
        self.world.create_body(&def.with_mass(Mass::Total(mass * self.size.powi(3)))).unwrap()
    }

    fn join(&mut self, kind: JointKind, (a, b): (BodyId, BodyId), at: DVec3, frame: Quat) {
        let mut def = JointDef::new(kind, a, b);
        let place = |body: BodyId| {
            let pose = self.world.pose(body).unwrap();
            let back = pose.rotation.conjugate();
            Pose::at(back.as_dquat() * (at * f64::from(self.size) - pose.position)).rotated(back * frame)
        };
        (def.frame_a, def.frame_b) = (place(a), place(b));
        let mass = self.world.mass_properties(b).unwrap().unwrap().mass;
        def.friction = FRICTION * mass * mass.cbrt();
        self.world.create_joint(&def).unwrap();
    }

    fn ragdoll(&mut self, at: DVec3) -> Vec<BodyId> {
        let up = Quat::from_rotation_arc(Vec3::X, Vec3::Y);
        let ball_joint = |swing_limit: f32| JointKind::Spherical {
            swing_limit,
            twist_limits: Limits::new(-0.5, 0.5),
            motor: SphericalMotor::Off,
        };
        let bends = JointKind::Hinge { limits: Limits::new(0.0, 2.4), motor: Motor::Off };
        let size = self.size;
        let torso = self.limb(at, Quat::IDENTITY, Shape::cuboid(Vec3::new(0.2, 0.3, 0.1) * size).unwrap(), 40.0);
        let head = self.limb(at + DVec3::Y * 0.45, Quat::IDENTITY, Shape::ball(0.12 * size).unwrap(), 5.0);
        self.join(ball_joint(0.6), (torso, head), at + DVec3::Y * 0.32, up);
        let mut all = vec![torso, head];
        for side in [-1.0, 1.0] {
            let (mut inner, mut thigh) = (torso, torso);
            for part in 0..2 {
                let x = side * (0.34 + 0.3 * f64::from(part));
                let across = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
                let arm = self.limb(at + DVec3::new(x, 0.25, 0.0), across, Shape::capsule(0.1 * size, 0.05 * size).unwrap(), 3.0);
                let (kind, frame) = if part == 0 { (ball_joint(1.5), Quat::IDENTITY) } else { (bends, up) };
                self.join(kind, (inner, arm), at + DVec3::new(x - side * 0.15, 0.25, 0.0), frame);
                let y = -(0.5 + 0.4 * f64::from(part));
                let leg = self.limb(
                    at + DVec3::new(side * 0.1, y, 0.0),
                    Quat::IDENTITY,
                    Shape::capsule(0.12 * size, 0.07 * size).unwrap(),
                    8.0,
                );
                let (kind, frame) = if part == 0 { (ball_joint(1.2), up) } else { (bends, Quat::IDENTITY) };
                self.join(kind, (thigh, leg), at + DVec3::new(side * 0.1, y + 0.2, 0.0), frame);
                (inner, thigh) = (arm, leg);
                all.extend([arm, leg]);
            }
        }
        all
    }
}

/// When a ragdoll that is thrown on a floor falls asleep (s); none within half a minute.
fn sleeps_after(rate: f32, size: f32, throw: Vec3) -> Option<f32> {
    let mut maker = Maker { world: World::new(&WorldDef::default()).unwrap(), size };
    let floor = ShapeDef::new(Shape::cuboid(Vec3::new(100.0, 1.0, 100.0)).unwrap());
    maker.world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -1.0, 0.0)).with_shape(floor)).unwrap();
    let all = maker.ragdoll(DVec3::Y * 2.0);
    for body in all {
        maker.world.set_linear_velocity(body, throw).unwrap();
    }
    (0..(30.0 * rate) as u32).find_map(|step| {
        maker.world.step(1.0 / rate).unwrap();
        (maker.world.awake_body_count() == 0).then_some(step as f32 / rate)
    })
}

/// One in several hundred goes on: limbs overlap that stops do not let part, recovery pushes at them in each step and lifts the doll by a
/// millimetre, until it slips and falls. 1 of 810 throws did so; with chaos in every fall that is which, not whether.
#[test]
fn a_ragdoll_with_friction_in_its_joints_falls_asleep() {
    let (mut awake, mut throws) = (Vec::new(), 0);
    for rate in [30.0, 60.0, 144.0] {
        for size in [0.3, 1.0, 3.0] {
            for number in 0..8_u8 {
                let throw = Vec3::new(0.5 * f32::from(number), 0.3 * f32::from(number % 3), 0.25 * f32::from(number));
                throws += 1;
                if sleeps_after(rate, size, throw).is_none() {
                    awake.push(format!("{rate} 1/s, size {size}, thrown at {throw}"));
                }
            }
        }
    }
    assert!(awake.len() <= 1, "{} of {throws} are awake after 30 s: {awake:#?}", awake.len());
}

//! What the host draws along by a limit or a frame of its joint moves at that speed past walls that it does not touch, and its joint bears its weight.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, JointDef, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, SleepSettings, World, WorldDef,
};

const RATES: [f32; 4] = [30.0, 60.0, 120.0, 240.0];

/// What the host moves of a joint: the upper end of a rope, the lower one of a slide or a turn, or a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Drawn {
    Rope,
    Slider,
    SixAxes,
    Frame,
    Arm,
}

impl Drawn {
    const ALL: [Self; 5] = [Self::Rope, Self::Slider, Self::SixAxes, Self::Frame, Self::Arm];

    /// The joint when its body has been drawn `way` (m, or rad of an arm) from where it was; a rope is 12 sizes long at first.
    fn joint(self, cabin: BodyId, way: f32, size: f32) -> JointDef {
        let above = Limits::new(way, f32::INFINITY);
        let up = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let kind = match self {
            Self::Rope => {
                let limits = Limits::new(0.0, 12.0 * size - way);
                JointKind::Distance { limits, spring_length: None, motor: Motor::Off }
            }
            Self::Slider => JointKind::Prismatic { limits: above, motor: Motor::Off },
            Self::SixAxes => {
                let linear = [Axis { limits: above, motor: Motor::Off }, Axis::LOCKED, Axis::LOCKED];
                JointKind::Generic { linear, angular: [Axis::LOCKED; 3] }
            }
            Self::Frame => JointKind::Fixed,
            Self::Arm => JointKind::Hinge { limits: above, motor: Motor::Off },
        };
        let size = f64::from(size);
        let mut def = JointDef::new(kind, BodyId::NULL, cabin);
        (def.frame_a, def.frame_b) = match self {
            Self::Rope => (Pose::at_xyz(0.0, 12.5 * size, 0.0), Pose::at_xyz(0.0, 0.5 * size, 0.0)),
            Self::Slider | Self::SixAxes => (Pose::IDENTITY.rotated(up), Pose::IDENTITY.rotated(up)),
            Self::Frame => (Pose::at_xyz(0.0, f64::from(way), 0.0), Pose::IDENTITY),
            // About z, with the cabin beside it.
            Self::Arm => {
                let about = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
                (Pose::at_xyz(-3.0 * size, 0.0, 0.0).rotated(about), Pose::at_xyz(-3.0 * size, 0.0, 0.0).rotated(about))
            }
        };
        def
    }
}

/// A cabin of 100 kg and an edge of `size` (m) between walls `air` of that beside it.
fn cabin_between_walls(size: f32, air: f32, sides: [Vec3; 2]) -> (World, BodyId) {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let gravity = Vec3::NEG_Y * 9.81;
    let mut world = World::new(&WorldDef { gravity, sleep, ..WorldDef::default() }).expect("a valid world");
    let cuboid = |half: Vec3| ShapeDef::new(Shape::cuboid(half * size).expect("a valid shape"));
    let def = BodyDef::dynamic(Pose::IDENTITY).with_shape(cuboid(Vec3::splat(0.5))).with_mass(Mass::Total(100.0));
    let cabin = world.create_body(&def).expect("a valid body");
    for side in sides.into_iter().flat_map(|side| [side, -side]) {
        let half = Vec3::splat(8.0) * (Vec3::ONE - side.abs()) + side.abs() * 0.1;
        let at: DVec3 = (side * ((0.6 + air) * size)).as_dvec3();
        world.create_body(&BodyDef::fixed(Pose::at(at)).with_shape(cuboid(half))).expect("a valid body");
    }
    (world, cabin)
}

/// Draws a cabin at a speed of `pace` √size (m/s) for two tenths of the time in which √size falls by its size, or by 0.6 of that.
fn draw(drawn: Drawn, rate: f32, size: f32, (air, pace): (f32, f32)) {
    let what = format!("{drawn:?} at {rate} steps a second, {size} m, {air} of it beside, pace {pace}");
    let sides = if drawn == Drawn::Arm { [Vec3::Z; 2] } else { [Vec3::X, Vec3::Z] };
    let (mut world, cabin) = cabin_between_walls(size, air, sides);
    let speed = pace * size.sqrt();
    let arm = if drawn == Drawn::Arm { 3.0 * size } else { 1.0 };
    let def = |way: f32| drawn.joint(cabin, way / arm, size);
    let joint = world.create_joint(&def(0.0)).expect("a valid joint");
    let count = (0.6 * size.sqrt() * rate).ceil().max(24.0) as u32;
    let (mut told, mut force, mut seen) = (0.0, 0.0, 0);
    for step in 1..=count {
        let now = def(step as f32 * speed / rate);
        match drawn {
            Drawn::Frame => world.set_joint_frames(joint, now.frame_a, now.frame_b).expect("valid frames"),
            _ => world.set_joint_kind(joint, now.kind).expect("a valid kind"),
        }
        world.step(1.0 / rate).expect("a valid step");
        if step > count / 2 {
            told += world.linear_velocity(cabin).expect("it stays").length() / speed;
            force += world.joint_state(joint).expect("it stays").force.length() / 981.0;
            seen += 1;
        }
    }
    let (told, force) = (told / seen as f32, force / seen as f32);
    assert!((told - 1.0).abs() < 0.01, "{what}: told {told} of its speed, bound 1 %");
    // The joint of an arm bears what leads it round too, a hundredth of its weight.
    assert!((force - 1.0).abs() < 0.03, "{what}: bears {force} of its weight, bound 3 %");
}

#[test]
fn what_is_drawn_past_walls_is_told_its_speed_and_bears_its_weight() {
    for (drawn, rate) in Drawn::ALL.into_iter().flat_map(|drawn| RATES.map(|rate| (drawn, rate))) {
        for size in [0.2, 1.0, 10.0] {
            for path in [(0.01, 0.6), (0.05, 0.6), (0.05, 0.2), (0.01, 0.06)] {
                draw(drawn, rate, size, path);
            }
        }
    }
}

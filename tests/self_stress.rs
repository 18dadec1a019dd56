//! What a motor draws out of a stack is not pressed ever harder by what holds it.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, JointDef, JointId, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, World, WorldDef,
};

const GRAVITY: f32 = 9.81;

/// What draws the block.
#[derive(Debug, Clone, Copy)]
enum Puller {
    Slider,
    SixAxis,
    Rope,
}

/// A tower of twelve courses of three blocks on a floor, each course across the one below it, in units of `scale`.
struct Tower {
    world: World,
    scale: f64,
    blocks: Vec<BodyId>,
}

impl Tower {
    fn new(scale: f64) -> Self {
        let mut world = World::new(&WorldDef::default()).unwrap();
        let size = scale as f32;
        let floor = Shape::cuboid(Vec3::new(10.0, 1.0, 10.0) * size).unwrap();
        world.create_body(&BodyDef::fixed(Pose::at(DVec3::Y * -scale)).with_shape(ShapeDef::new(floor))).unwrap();
        let mut blocks = Vec::new();
        for course in 0..12 {
            for place in 0..3 {
                let aside = 0.301 * (f64::from(place) - 1.0);
                let (across, along) = if course % 2 == 0 { (DVec3::Z, 0.0) } else { (DVec3::X, std::f32::consts::FRAC_PI_2) };
                let pose = Pose::at((across * aside + DVec3::Y * (0.1 + 0.2 * f64::from(course))) * scale);
                let mut shape = ShapeDef::new(Shape::cuboid(Vec3::new(0.45, 0.1, 0.15) * size).unwrap());
                shape.material.friction = 0.4;
                let body = BodyDef::dynamic(pose.rotated(Quat::from_rotation_y(along))).with_shape(shape);
                blocks.push(world.create_body(&body.with_mass(Mass::Total(3.0 * size.powi(3)))).unwrap());
            }
        }
        Self { world, scale, blocks }
    }

    /// A speed where all lengths are `scale` times as long under the same gravity (m/s).
    fn speed(&self, speed: f32) -> f32 {
        speed * (self.scale as f32).sqrt()
    }

    fn step(&mut self, rate: f32) {
        self.world.step((self.scale as f32).sqrt() / rate).unwrap();
    }

    /// Has the middle block of a course drawn out along its length.
    fn draw(&mut self, course: usize, puller: Puller) -> JointId {
        let block = self.blocks[3 * course + 1];
        let at = self.world.pose(block).unwrap();
        let out = at.rotation.as_dquat() * DVec3::X;
        let (world, length) = (&mut self.world, self.scale as f32);
        let speed = 0.5 * length.sqrt();
        let velocity = |target| Motor::Velocity { target, max_force: f32::INFINITY };
        let kind = match puller {
            Puller::Slider => JointKind::Prismatic { limits: Limits::new(0.0, 1.5 * length), motor: velocity(speed) },
            Puller::SixAxis => {
                let drawn = Axis { limits: Limits::new(0.0, 1.5 * length), motor: velocity(speed) };
                JointKind::Generic { linear: [drawn, Axis::LOCKED, Axis::LOCKED], angular: [Axis::LOCKED; 3] }
            }
            Puller::Rope => {
                JointKind::Distance { limits: Limits::new(0.0, 10.0 * length), spring_length: None, motor: velocity(-speed) }
            }
        };
        let mut def = JointDef::new(kind, BodyId::NULL, block);
        def.frame_a = at;
        if matches!(puller, Puller::Rope) {
            def.frame_a = Pose::at(at.position + out * (4.0 * self.scale));
            def.frame_b = Pose::at(DVec3::X * (0.45 * self.scale));
        }
        world.create_joint(&def).unwrap()
    }
}

#[test]
fn a_block_that_is_drawn_out_of_a_tower_throws_nothing_about() {
    for (puller, rate, scale) in [
        (Puller::Slider, 30.0, 1.0),
        (Puller::Slider, 120.0, 1.0),
        (Puller::Slider, 240.0, 0.1),
        (Puller::SixAxis, 240.0, 1.0),
        (Puller::Rope, 60.0, 10.0),
        (Puller::Rope, 240.0, 1.0),
    ] {
        let mut tower = Tower::new(scale);
        (0..rate as usize).for_each(|_| tower.step(rate));
        let joint = tower.draw(4, puller);
        let weight = 108.0 * GRAVITY * (scale as f32).powi(3);
        let mut fastest = 0.0_f32;
        // A rope lets the block fall once it is out.
        let length = if matches!(puller, Puller::Rope) { 0.8 } else { 2.9 };
        for step in 0..(length * rate) as usize {
            tower.step(rate);
            let speeds = tower.blocks.iter().map(|&block| tower.world.linear_velocity(block).unwrap().length());
            fastest = speeds.fold(fastest, f32::max);
            let force = tower.world.joint_state(joint).unwrap().force;
            // Along its way it has the blow of the start as well, which has 0.6 s to go.
            let at_rest = step as f32 * (scale as f32).sqrt() > 0.6 * rate;
            let most = if at_rest { force.length() } else { force.y.abs() };
            assert!(most < 2.0 * weight, "{puller:?}, {rate} Hz, {scale} m: {force} N in the joint, the tower weighs {weight} N");
        }
        assert!(fastest < 1.5 * tower.speed(0.5), "{puller:?}, {rate} Hz, {scale} m: a block at {fastest} m/s");
    }
}

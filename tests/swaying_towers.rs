//! Towers of blocks that are set swaying come to rest: nothing gives them energy.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Mass, Pose, Shape, ShapeDef, World, WorldDef};

const GRAVITY: f64 = 9.81;

/// How the planks of a layer lie.
#[derive(Debug, Clone, Copy)]
enum Layers {
    /// Three planks side by side, a millimetre apart.
    Three,
    /// The same, but for the middle one of the seventh.
    Gap,
    /// Two planks far apart.
    Two,
}

struct Tower {
    world: World,
    blocks: Vec<(BodyId, f64)>,
    size: f64,
}

impl Tower {
    const LAYERS: usize = 18;
    const HEIGHT: f64 = 0.15;

    /// A tower over which velocities grow evenly with height, to 0.2 of the height a second.
    fn swaying(layers: Layers, size: f64) -> Self {
        let mut world = World::new(&WorldDef::default()).unwrap();
        let floor = Shape::cuboid(Vec3::new(20.0, 1.0, 20.0) * size as f32).unwrap();
        world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -size, 0.0)).with_shape(ShapeDef::new(floor))).unwrap();
        let mut tower = Self { world, blocks: Vec::new(), size };
        for layer in 0..Self::LAYERS {
            let (half_width, across): (f64, &[f64]) = match layers {
                Layers::Gap if layer == 6 => (0.1245, &[-0.25, 0.25]),
                Layers::Three | Layers::Gap => (0.1245, &[-0.25, 0.0, 0.25]),
                Layers::Two => (0.1, &[-0.28, 0.28]),
            };
            for &place in across {
                tower.add(layer, half_width, place);
            }
        }
        tower
    }

    fn add(&mut self, layer: usize, half_width: f64, across: f64) {
        let size = self.size;
        let shape = Shape::cuboid(DVec3::new(0.375, 0.5 * Self::HEIGHT, half_width).as_vec3() * size as f32).unwrap();
        let height = Self::HEIGHT * (layer as f64 + 0.5);
        let turn = Quat::from_rotation_y(if layer.is_multiple_of(2) { 0.0 } else { std::f32::consts::FRAC_PI_2 });
        let at = turn.as_dquat() * DVec3::new(0.0, height, across);
        let mass = (5.0 * size.powi(3)) as f32;
        let def = BodyDef {
            mass: Mass::Total(mass),
            linear_velocity: Vec3::X * (0.2 * height * size.sqrt()) as f32,
            ..BodyDef::dynamic(Pose { position: at * size, rotation: turn })
        };
        let body = self.world.create_body(&def.with_shape(ShapeDef::new(shape))).unwrap();
        self.blocks.push((body, f64::from(mass)));
    }

    /// Energy over that of the same tower a metre high, but for a constant (J).
    fn energy(&self) -> f64 {
        let of = |&(body, mass): &(BodyId, f64)| {
            let properties = self.world.mass_properties(body).unwrap().unwrap();
            let pose = self.world.pose(body).unwrap();
            let spin = (pose.rotation * properties.inertia_frame).as_dquat().conjugate()
                * self.world.angular_velocity(body).unwrap().as_dvec3();
            let speed = self.world.linear_velocity(body).unwrap().as_dvec3().length();
            let turned = 0.5 * (spin * spin).dot(properties.principal_inertia.as_dvec3());
            mass * (0.5 * speed * speed + GRAVITY * pose.position.y) + turned
        };
        self.blocks.iter().map(of).sum::<f64>() / self.size.powi(4)
    }
}

/// Left to sweeps alone, as everything with a body faster than 0.49 m/s was, they rose by 2 to 21 times the energy of their sway, and fell.
#[test]
fn towers_that_sway_come_to_rest() {
    for (layers, size, rate) in [
        (Layers::Three, 1.0, 30.0),
        (Layers::Three, 1.0, 60.0),
        (Layers::Gap, 1.0, 60.0),
        (Layers::Gap, 1.0, 120.0),
        (Layers::Two, 1.0, 30.0),
        (Layers::Two, 1.0, 60.0),
        (Layers::Two, 10.0, 60.0),
        (Layers::Two, 1.0, 240.0),
    ] {
        let mut tower = Tower::swaying(layers, size);
        let first = tower.energy();
        let kick = first - {
            let still = Tower::swaying(layers, size);
            still.blocks.iter().map(|&(body, mass)| mass * GRAVITY * still.world.pose(body).unwrap().position.y).sum::<f64>()
                / size.powi(4)
        };
        let (mut least, mut rise) = (first, 0.0_f64);
        for _ in 0..(4.0 * size.sqrt() * rate) as usize {
            tower.world.step(1.0 / rate as f32).unwrap();
            let now = tower.energy();
            (least, rise) = (least.min(now), rise.max(now - least));
        }
        let what = format!("{layers:?}, {size} m, {rate}/s");
        assert!(rise < kick, "{what}: energy rises by {rise} J, bound {kick} J, that of its sway");
        let (top, _) = *tower.blocks.last().unwrap();
        let height = tower.world.pose(top).unwrap().position.y / size;
        let stood = Tower::HEIGHT * (Tower::LAYERS as f64 - 0.5);
        assert!((height - stood).abs() < 0.02, "{what}: the top is {height} m high, not {stood} m");
    }
}

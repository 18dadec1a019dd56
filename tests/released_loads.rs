//! What carried a load stays where it is when the load is gone.

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, BodyId, Geometry, Mass, Pose, Shape, ShapeDef, SleepSettings, World, WorldDef};

const GRAVITY: f32 = 9.81;

/// How a load goes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Release {
    Destroyed,
    Lightened,
    Lifted,
    LetGo,
    Weightless,
}

const RELEASES: [Release; 5] = [Release::Destroyed, Release::Lightened, Release::Lifted, Release::LetGo, Release::Weightless];

/// A stack of boxes of one size (m), the last of which is so many times as heavy as the others.
struct Stack {
    world: World,
    boxes: Vec<BodyId>,
    load: BodyId,
}

impl Stack {
    fn new(count: usize, size: f32, ratio: f32) -> Self {
        let def = WorldDef {
            gravity: Vec3::NEG_Y * GRAVITY,
            sleep: SleepSettings { enabled: false, ..SleepSettings::default() },
            ..WorldDef::default()
        };
        let mut world = World::new(&def).expect("a valid world");
        let block = |half: Vec3, density: f32| ShapeDef {
            density,
            ..ShapeDef::new(Shape::new(Geometry::Box { half_extents: half }).expect("a valid shape"))
        };
        let ground =
            BodyDef::fixed(Pose::at(DVec3::NEG_Y * f64::from(size))).with_shape(block(Vec3::new(20.0, 1.0, 20.0) * size, 1000.0));
        world.create_body(&ground).expect("a valid body");
        let mut boxes: Vec<BodyId> = (0..=count)
            .map(|place| {
                let density = if place == count { 1000.0 * ratio } else { 1000.0 };
                let at = DVec3::Y * (f64::from(size) * (place as f64 + 0.5));
                world
                    .create_body(&BodyDef::dynamic(Pose::at(at)).with_shape(block(Vec3::splat(0.5 * size), density)))
                    .expect("a valid body")
            })
            .collect();
        let load = boxes.pop().expect("a load");
        Self { world, boxes, load }
    }

    fn height(&self, body: BodyId) -> f64 {
        self.world.pose(body).expect("it stays").position.y
    }

    fn release(&mut self, how: Release, size: f32) {
        let Self { world, load, .. } = self;
        match how {
            Release::Destroyed => world.destroy_body(*load).expect("it is there"),
            Release::Lightened => world.set_mass(*load, Mass::Total(1000.0 * size.powi(3))).expect("a valid mass"),
            Release::Lifted => {
                let pose = world.pose(*load).expect("it is there");
                let lifted = Pose { position: pose.position + DVec3::Y * f64::from(10.0 * size), ..pose };
                world.set_pose(*load, lifted).expect("a valid pose");
            }
            Release::LetGo => {}
            Release::Weightless => world.set_gravity(Vec3::ZERO).expect("valid gravity"),
        }
    }
}

/// How far the boxes under a load rise within a quarter of a second after it is gone, over what they fall in that time.
fn rise(how: Release, (count, size, ratio): (usize, f32, f32), rate: f32) -> f64 {
    let mut stack = Stack::new(count, size, if how == Release::LetGo { 1.0 } else { ratio });
    let dt = 1.0 / rate;
    for _ in 0..rate as u32 {
        if how == Release::LetGo {
            let push = (ratio - 1.0) * 1000.0 * size.powi(3) * GRAVITY;
            stack.world.add_force(stack.load, Vec3::NEG_Y * push).expect("a valid force");
        }
        stack.world.step(dt).expect("a valid step");
    }
    let before: Vec<f64> = stack.boxes.iter().map(|&body| stack.height(body)).collect();
    stack.release(how, size);
    let mut most = 0.0_f64;
    for _ in 0..(0.25 * rate) as u32 {
        stack.world.step(dt).expect("a valid step");
        most = stack.boxes.iter().zip(&before).map(|(&body, before)| stack.height(body) - before).fold(most, f64::max);
    }
    most / f64::from(0.5 * GRAVITY * 0.25 * 0.25)
}

#[test]
fn what_carried_a_load_does_not_rise_when_it_is_gone() {
    let mut worst = (0.0, String::new());
    let mut failed = 0;
    let mut runs = 0;
    for how in RELEASES {
        for stack in [1, 3, 8].into_iter().flat_map(|count| {
            [0.1, 1.0, 10.0].into_iter().flat_map(move |size| [2.0, 10.0, 100.0].map(|ratio| (count, size, ratio)))
        }) {
            for rate in [30.0, 60.0, 240.0] {
                let rise = rise(how, stack, rate);
                runs += 1;
                // A hundredth of a fall: 3 mm.
                if rise > 0.01 {
                    failed += 1;
                }
                if rise > worst.0 {
                    worst = (rise, format!("{how:?} {stack:?} at {rate} Hz"));
                }
            }
        }
    }
    assert!(failed == 0, "{failed} of {runs} rise, {} at worst: {}", worst.0, worst.1);
}

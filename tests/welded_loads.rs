//! What is told of bodies that fixed joints make one: the forces on each, and what each joint bears.

use longspan::glam::{DVec3, Vec3};
use longspan::{
    BodyDef, BodyId, BodyKind, Geometry, JointDef, JointId, JointKind, Mass, Material, Pose, Shape, ShapeDef, World, WorldDef,
};

const RATES: [f32; 3] = [30.0, 60.0, 240.0];

fn body(world: &mut World, mass: f32, at: DVec3, geometry: Geometry, restitution: f32) -> BodyId {
    let mut shape = ShapeDef::new(Shape::new(geometry).unwrap());
    shape.material = Material { restitution, ..Material::default() };
    world.create_body(&BodyDef { mass: Mass::Total(mass), ..BodyDef::dynamic(Pose::at(at)) }.with_shape(shape)).unwrap()
}

fn slab() -> Geometry {
    Geometry::Box { half_extents: Vec3::new(1.0, 0.1, 1.0) }
}

/// A slab of 50 kg at the origin that a fixed joint holds to the world or to a body of this kind.
fn held_slab(world: &mut World, kind: Option<BodyKind>) -> (BodyId, JointId) {
    let plate = body(world, 50.0, DVec3::ZERO, slab(), 0.0);
    let mut def = JointDef::new(JointKind::Fixed, BodyId::NULL, plate);
    if let Some(kind) = kind {
        let beside = BodyDef { kind, ..BodyDef::fixed(Pose::at(DVec3::X * 3.0)) };
        def.body_a = world.create_body(&beside.with_shape(ShapeDef::new(Shape::cuboid(Vec3::splat(0.5)).unwrap()))).unwrap();
        def.frame_a = Pose::at(DVec3::X * -3.0);
    }
    (plate, world.create_joint(&def).unwrap())
}

/// Nothing took the force of the step before from what is held to something static: it grew by the load in every step, and stayed as it was
/// when what lay there fell asleep.
#[test]
fn the_force_on_what_is_welded_to_something_static_is_that_of_its_contacts_now() {
    for rate in RATES {
        for kind in [None, Some(BodyKind::Static), Some(BodyKind::Kinematic)] {
            let mut world = World::new(&WorldDef::default()).unwrap();
            let (plate, joint) = held_slab(&mut world, kind);
            let cube = Geometry::Box { half_extents: Vec3::splat(0.2) };
            let boxes = [-0.5, 0.5].map(|x| body(&mut world, 20.0, DVec3::new(x, 0.3, 0.0), cube.clone(), 0.0));
            let weight = 20.0 * 9.81;
            let what = format!("{kind:?} at {rate} Hz");
            for step in 0..(2.0 * rate) as usize {
                world.step(1.0 / rate).unwrap();
                let force = world.contact_force(plate).unwrap();
                assert!((force.y + 2.0 * weight).abs() < 0.01 * weight, "{what}: {force} N in step {step}, of {}", 2.0 * weight);
            }
            assert!(!world.is_awake(boxes[0]).unwrap(), "{what}: it does not sleep");
            // One is woken, the other sleeps on.
            world.set_linear_velocity(boxes[0], Vec3::X * 0.1).unwrap();
            world.step(1.0 / rate).unwrap();
            assert!(!world.is_awake(boxes[1]).unwrap());
            let force = world.contact_force(plate).unwrap();
            assert!((force.y + 2.0 * weight).abs() < 0.05 * weight, "{what}: {force} N as one has been woken");
            // Until the next step it is what it was, though nothing holds the plate any more.
            world.destroy_joint(joint).unwrap();
            let after = world.contact_force(plate).unwrap();
            assert!((after - force).length() < 0.01 * weight, "{what}: {after} N as the joint has gone, {force} N before");
        }
    }
}

#[test]
fn a_bounce_on_what_is_welded_leaves_no_force_behind() {
    for rate in RATES {
        for kind in [None, Some(BodyKind::Static), Some(BodyKind::Kinematic)] {
            let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
            let (plate, _) = held_slab(&mut world, kind);
            let ball = body(&mut world, 20.0, DVec3::Y * 0.4, Geometry::Ball { radius: 0.1 }, 1.0);
            world.set_linear_velocity(ball, Vec3::NEG_Y * 2.0).unwrap();
            for _ in 0..(0.5 * rate) as usize {
                world.step(1.0 / rate).unwrap();
            }
            assert!(world.linear_velocity(ball).unwrap().y > 1.99);
            assert_eq!(world.contact_force(plate).unwrap(), Vec3::ZERO, "{kind:?} at {rate} Hz");
        }
    }
}

//! Logs that come down on logs at small angles lie on them: no end of one goes into another while the other end has the contact.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Geometry, Pose, Shape, ShapeDef, World, WorldDef};

/// Deepest overlap at which a log lies on another, over the radius: rows at the ends of the stretch let a log that rocks on another in by a twentieth
/// of the radius midway.
const DEEP: f32 = 0.1;

#[derive(Debug, Clone, Copy)]
enum Kind {
    Cylinder,
    Capsule,
}

fn log(world: &mut World, kind: Kind, (radius, half_height): (f32, f32), is_static: bool, (at, turn): (DVec3, Quat)) -> BodyId {
    let geometry = match kind {
        Kind::Cylinder => Geometry::Cylinder { half_height, radius },
        Kind::Capsule => Geometry::Capsule { half_height, radius },
    };
    let part = ShapeDef::new(Shape::new(geometry).unwrap());
    let pose = Pose { position: at, rotation: turn * Quat::from_rotation_x(std::f32::consts::FRAC_PI_2) };
    let def = if is_static { BodyDef::fixed(pose) } else { BodyDef::dynamic(pose) };
    world.create_body(&def.with_shape(part)).unwrap()
}

fn depth(world: &World, body: BodyId) -> f32 {
    let contacts = world.contacts_of(body).unwrap();
    contacts.flat_map(|contact| contact.points().to_vec()).map(|point| -point.separation).fold(0.0, f32::max)
}

/// With a contact at the nearest point alone a log turned about that for a step, and its far end was up to two radii deep before there was a contact there;
/// then that end had the only one, and the other went in.
#[test]
fn a_log_that_falls_on_a_log_at_a_small_angle_goes_in_with_neither_end() {
    for (below, above) in [(Kind::Cylinder, Kind::Cylinder), (Kind::Cylinder, Kind::Capsule), (Kind::Capsule, Kind::Capsule)] {
        for (radius, rate) in [(0.01_f32, 60.0_f32), (0.01, 240.0), (0.1, 30.0), (10.0, 30.0)] {
            for (slender, angle, tilt) in [
                (2.0_f32, 0.1_f32, 0.05_f32),
                (5.0, 0.005, 0.005),
                (5.0, 0.03, 0.02),
                (9.0, 0.01, -0.01),
                (9.0, 0.06, 0.03),
                (9.0, 0.2, -0.04),
                (30.0, 0.002, 0.002),
                (30.0, 0.02, 0.01),
            ] {
                for aside in [-0.6_f32, 0.1, 0.5] {
                    let mut world = World::new(&WorldDef::default()).unwrap();
                    let size = (radius, slender * radius);
                    log(&mut world, below, size, true, (DVec3::ZERO, Quat::IDENTITY));
                    let height = radius * ((4.0 - aside * aside).sqrt() + tilt.abs() * slender + 0.1);
                    let at = Vec3::new(aside * radius, height, 0.1 * radius).as_dvec3();
                    let turn = Quat::from_rotation_y(angle) * Quat::from_rotation_x(tilt);
                    let body = log(&mut world, above, size, false, (at, turn));
                    // Until it has rolled off.
                    for step in 0..(rate * (20.0 * radius / 9.81).sqrt()).ceil() as u32 {
                        world.step(1.0 / rate).unwrap();
                        let deep = depth(&world, body) / radius;
                        assert!(
                            deep < DEEP,
                            "{above:?} on {below:?} of {radius} m, {slender} times as long, at {angle} and {tilt} rad, {aside} radii aside, {rate} Hz, \
                             step {step}: {deep} radii deep"
                        );
                    }
                }
            }
        }
    }
}

//! Motors without a bound near a dead centre, where no force would do what they ask for: what they drive stalls there or goes past it,
//! and nothing leaps.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, CollisionFilter, JointDef, JointId, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, World, WorldDef,
};

/// A body of this shape that nothing collides with.
fn part(world: &mut World, pose: Pose, shape: Shape, mass: f32) -> BodyId {
    let mut shape = ShapeDef::new(shape);
    shape.filter = CollisionFilter { member_of: 2, collides_with: 0 };
    world.create_body(&BodyDef::dynamic(pose).with_shape(shape).with_mass(Mass::Total(mass))).unwrap()
}

/// A joint whose axis is turned from x by `axis`, at these points of its bodies.
fn join(world: &mut World, kind: JointKind, [a, b]: [BodyId; 2], [on_a, on_b]: [DVec3; 2], axis: Quat) -> JointId {
    let mut def = JointDef::new(kind, a, b);
    (def.frame_a, def.frame_b) = (Pose::at(on_a).rotated(axis), Pose::at(on_b).rotated(axis));
    world.create_joint(&def).unwrap()
}

fn motor(target: f32) -> JointKind {
    JointKind::Prismatic { limits: Limits::NONE, motor: Motor::Velocity { target, max_force: f32::INFINITY } }
}

/// A load of 1000 kg that stands on the floor, a chain of links upright on it, and a hook on a slider above that lowers the chain.
struct Hoist {
    world: World,
    load: BodyId,
    links: Vec<BodyId>,
    hook: BodyId,
    slider: JointId,
    joints: Vec<JointId>,
}

impl Hoist {
    fn new(count: usize, size: f64, link: JointKind) -> Self {
        let mut world = World::new(&WorldDef::default()).unwrap();
        let long = size as f32;
        let floor = ShapeDef::new(Shape::cuboid(Vec3::new(30.0, 0.5, 30.0) * long).unwrap());
        world.create_body(&BodyDef::fixed(Pose::at(DVec3::Y * (-0.5 * size))).with_shape(floor)).unwrap();
        let block = ShapeDef::new(Shape::cuboid(Vec3::splat(0.5) * long).unwrap());
        let standing = BodyDef::dynamic(Pose::at(DVec3::Y * (0.5 * size))).with_shape(block);
        let load = world.create_body(&standing.with_mass(Mass::Total(1000.0))).unwrap();
        let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
        let (step, end) = (0.3 * size, DVec3::Y * (0.15 * size));
        let (mut before, mut at) = (load, DVec3::Y * (0.5 * size));
        let (mut links, mut joints) = (Vec::new(), Vec::new());
        for number in 0..count {
            let pose = Pose::at(DVec3::Y * (size + step * (number as f64 + 0.5)));
            let own = part(&mut world, pose, Shape::capsule(0.12 * long, 0.03 * long).unwrap(), 1.0);
            joints.push(join(&mut world, link, [before, own], [at, -end], about_z));
            links.push(own);
            (before, at) = (own, end);
        }
        let top = DVec3::Y * (size + step * count as f64);
        let hook = part(&mut world, Pose::at(top), Shape::cuboid(Vec3::splat(0.1) * long).unwrap(), 20.0);
        joints.push(join(&mut world, JointKind::SPHERICAL, [before, hook], [at, DVec3::ZERO], Quat::IDENTITY));
        let up = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let slider = join(&mut world, motor(0.0), [BodyId::NULL, hook], [top, DVec3::ZERO], up);
        Self { world, load, links, hook, slider, joints }
    }
}

#[test]
fn a_hook_lets_a_chain_down_on_what_stands_at_the_speed_of_its_motor() {
    for rate in [30.0_f32, 60.0, 120.0, 240.0] {
        for (count, size, push, link) in [
            (5, 1.0, 0.0, JointKind::SPHERICAL),
            (9, 1.0, 0.05, JointKind::SPHERICAL),
            (5, 0.1, 0.05, JointKind::SPHERICAL),
            (7, 10.0, 0.05, JointKind::SPHERICAL),
            (5, 1.0, 0.05, JointKind::HINGE),
        ] {
            let what = format!("{count} links, size {size}, pushed at {push} m/s, {rate} Hz");
            let mut hoist = Hoist::new(count, size, link);
            let (unit, speed) = ((size as f32).sqrt(), 0.5 * (size as f32).sqrt());
            for _ in 0..rate as usize {
                hoist.world.step(1.0 / rate).unwrap();
            }
            let middle = hoist.links[count / 2];
            hoist.world.set_linear_velocity(middle, Vec3::X * (push * unit)).unwrap();
            hoist.world.set_joint_kind(hoist.slider, motor(-speed)).unwrap();
            let height = |hoist: &Hoist, body: BodyId| hoist.world.pose(body).unwrap().position.y;
            let (top, stands) = (height(&hoist, hoist.hook), height(&hoist, hoist.load));
            for step in 1..=(unit * rate) as usize {
                hoist.world.step(1.0 / rate).unwrap();
                let asked = top - f64::from(speed / rate) * step as f64;
                let (off, lifted) = (height(&hoist, hoist.hook) - asked, height(&hoist, hoist.load) - stands);
                // It waits for a moment where the chain is exactly straight.
                assert!(off.abs() < 0.05 * size, "{what}: the hook is {off} m off");
                assert!(lifted < 0.03 * size, "{what}: the load is lifted by {lifted} m");
                let gap = hoist.joints.iter().map(|&joint| hoist.world.joint_state(joint).unwrap().gap).fold(0.0, f32::max);
                assert!(gap < 1.0e-3 * size as f32, "{what}: a joint is {gap} m open");
            }
        }
    }
}

#[test]
fn a_crank_that_a_slider_pushes_out_to_its_dead_centre_is_not_thrown_about() {
    const CRANK: f64 = 0.3;
    for rate in [30.0_f32, 60.0, 120.0, 240.0] {
        for speed in [0.2_f32, 0.6, 2.0] {
            let mut world = World::new(&WorldDef::default()).unwrap();
            let (x, y) = (CRANK * 0.9_f64.cos(), CRANK * 0.9_f64.sin());
            let reach = x + (1.0 - y * y).sqrt();
            let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
            let wheel = part(&mut world, Pose::IDENTITY, Shape::cuboid(Vec3::new(0.3, 0.3, 0.05)).unwrap(), 5.0);
            join(&mut world, JointKind::HINGE, [BodyId::NULL, wheel], [DVec3::ZERO; 2], about_z);
            let lean = (-y).atan2(reach - x) as f32;
            let along = Pose::at_xyz(0.5 * (x + reach), 0.5 * y, 0.0).rotated(Quat::from_rotation_z(lean));
            let rod = part(&mut world, along, Shape::cuboid(Vec3::new(0.5, 0.03, 0.03)).unwrap(), 1.0);
            let block = part(&mut world, Pose::at_xyz(reach, 0.0, 0.0), Shape::cuboid(Vec3::splat(0.1)).unwrap(), 5.0);
            let points = [DVec3::new(x, y, 0.0), DVec3::X * -0.5];
            let mut def = JointDef::new(JointKind::HINGE, wheel, rod);
            (def.frame_a, def.frame_b) = (Pose::at(points[0]).rotated(about_z), Pose::at(points[1]).rotated(about_z));
            world.create_joint(&def).unwrap();
            join(&mut world, JointKind::HINGE, [rod, block], [DVec3::X * 0.5, DVec3::ZERO], about_z);
            let slider = join(&mut world, motor(speed), [BodyId::NULL, block], [DVec3::ZERO; 2], Quat::IDENTITY);
            let mut before = reach;
            for step in 0..(6.0 * rate) as usize {
                if step % rate as usize == 0 {
                    let sign = if (step / rate as usize).is_multiple_of(2) { 1.0 } else { -1.0 };
                    world.set_joint_kind(slider, motor(sign * speed)).unwrap();
                }
                world.step(1.0 / rate).unwrap();
                let at = world.pose(block).unwrap().position.x;
                let moved = (at - before).abs() * f64::from(rate);
                let what = format!("asked for {speed} m/s, {rate} Hz: {moved} m/s, at {at} m");
                // Up to 128 m/s where the motor was obeyed.
                assert!(moved < 1.5 * f64::from(speed) + 3.0, "{what}");
                assert!((0.69..1.31).contains(&at), "{what}");
                before = at;
            }
        }
    }
}

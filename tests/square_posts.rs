//! Ropes of links over posts with edges: what lies across an edge neither spins about itself nor goes in.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Geometry, JointDef, JointKind, LocalPose, Mass, Pose, Shape, ShapeDef, SleepSettings, World, WorldDef,
};

/// Half the width of the post (m), and how far above its middle the rope is let go, round an arc.
const HALF: f64 = 0.25;
const ARC: f64 = 0.375;

/// A rope of capsules of this length (m) with 50 kg at each end that falls onto a post; its bodies, and the load on the left.
fn rope(world: &mut World, length: f64) -> (Vec<BodyId>, BodyId) {
    let post = Shape::cuboid(Vec3::new(HALF as f32, HALF as f32, 1.0)).expect("a valid shape");
    world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(ShapeDef::new(post))).expect("a valid body");
    let (radius, count) = (0.15 * length, (4.0 / length).round() as usize);
    let arc = std::f64::consts::PI * ARC;
    let mut link = ShapeDef::new(Shape::capsule((0.5 * length - radius) as f32, radius as f32).expect("a valid shape"));
    link.local_pose = LocalPose { rotation: Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2), ..LocalPose::default() };
    let half = (0.5 * length) as f32;
    let join = |world: &mut World, a: BodyId, b: BodyId, ends: [Vec3; 2]| {
        world.create_joint(&JointDef::new(JointKind::SPHERICAL, a, b).at(ends[0], ends[1])).expect("a valid joint");
    };
    let mut links = Vec::new();
    for i in 0..count {
        let along = (i as f64 + 0.5) * length - 2.0;
        let straight = along.abs() - 0.5 * arc;
        let (at, angle) = if straight < 0.0 {
            (DVec3::new((along / ARC).sin(), (along / ARC).cos(), 0.0) * ARC, -along / ARC)
        } else {
            (DVec3::new(ARC.copysign(along), -straight, 0.0), -std::f64::consts::FRAC_PI_2.copysign(along))
        };
        let pose = Pose::at(at).rotated(Quat::from_rotation_z(angle as f32));
        let next = world.create_body(&BodyDef::dynamic(pose).with_shape(link.clone())).expect("a valid body");
        if let Some(&last) = links.last() {
            join(world, last, next, [Vec3::X * half, Vec3::NEG_X * half]);
        }
        links.push(next);
    }
    let mut loads = [(0, -1.0_f32), (count - 1, 1.0)].into_iter().map(|(end, side)| {
        let at = DVec3::new(f64::from(side) * ARC, -(2.0 - 0.5 * arc) - 0.15, 0.0);
        let def = BodyDef { mass: Mass::Total(50.0), ..BodyDef::dynamic(Pose::at(at)) };
        let ball = ShapeDef::new(Shape::new(Geometry::Ball { radius: 0.15 }).expect("a valid shape"));
        let load = world.create_body(&def.with_shape(ball)).expect("a valid body");
        join(world, links[end], load, [Vec3::X * (side * half), Vec3::Y * 0.15]);
        load
    });
    let left = loads.next().expect("two loads");
    loads.for_each(drop);
    (links, left)
}

/// With the levers of the start of each step the push of an edge lay beside a link's own line as soon as that turned on it, and spun it: links of 10 cm
/// were 12 cm in the post at 30 steps a second and 7 cm at 60, of 5 cm 6 cm, and spun at up to 700 rad/s.
#[test]
fn a_rope_over_a_square_post_comes_to_hang_on_it() {
    for length in [0.1, 0.05] {
        let mut heights = Vec::new();
        for rate in [30.0_f32, 60.0, 120.0] {
            let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
            let mut world = World::new(&WorldDef { sleep, ..WorldDef::default() }).expect("a valid world");
            let (links, load) = rope(&mut world, length);
            let (mut deep, mut spin, mut gap) = (0.0_f32, 0.0_f32, 0.0_f32);
            for step in 0..(4.0 * rate) as u32 {
                let residuals = world.step(1.0 / rate).expect("a valid step").residuals;
                gap = gap.max(residuals.joint_gap);
                // It has fallen onto the post by then.
                if step as f32 > rate {
                    deep = deep.max(residuals.penetration);
                }
            }
            for &link in &links {
                spin = spin.max(world.angular_velocity(link).expect("a body of the world").length());
            }
            heights.push(world.pose(load).expect("a body of the world").position.y);
            println!(
                "links of {length} m at {rate} Hz: {deep} m deep, {spin} rad/s, gap {gap} m, load at {:?} m",
                heights.last()
            );
            assert!(deep < 1.0e-3 && gap < 1.0e-3, "links of {length} m at {rate} Hz: {deep} m deep, {gap} m open");
            assert!(spin < 10.0, "links of {length} m at {rate} Hz: a link spins at {spin} rad/s");
        }
        let (low, high) = heights.iter().fold((f64::MAX, f64::MIN), |(low, high), &y| (low.min(y), high.max(y)));
        assert!(high - low < 5.0e-3, "links of {length} m: loads hang at {heights:?} m");
    }
}

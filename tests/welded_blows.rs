//! What the host does to a body that is welded to something static or kinematic acts on its joints.

use longspan::glam::{DVec3, Vec3};
use longspan::{
    BodyDef, BodyId, BodyKind, JointDef, JointKind, LongRangeDef, Mass, Pose, Shape, ShapeDef, Strength, World, WorldDef,
};

/// How a body is struck.
const BLOWS: [&str; 4] = ["an impulse", "an impulse at its middle", "a velocity", "a force for a step"];

/// A row of bodies of two kilograms, the first welded to something, the last of which is struck by so much (N·s); how many joints break within
/// half a second if they bear 50 N on a mean over a tenth of it.
fn broken_by(blow: &str, impulse: f32, kind: Option<BodyKind>, count: usize, unions: bool, moving: Vec3) -> usize {
    let long_range = LongRangeDef { union: unions, ..LongRangeDef::default() };
    let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, long_range, ..WorldDef::default() }).unwrap();
    let cube = ShapeDef::new(Shape::cuboid(Vec3::splat(0.1)).unwrap());
    let mut before = BodyId::NULL;
    if let Some(kind) = kind {
        let def = BodyDef { kind, linear_velocity: moving, ..BodyDef::fixed(Pose::at(DVec3::X * -0.2)) };
        before = world.create_body(&def.with_shape(cube.clone())).unwrap();
    }
    let mut last = before;
    for number in 0..count {
        let at = 0.2 * number as f64;
        let def = BodyDef { linear_velocity: moving, ..BodyDef::dynamic(Pose::at(DVec3::X * at)) }.with_mass(Mass::Total(2.0));
        let body = world.create_body(&def.with_shape(cube.clone())).unwrap();
        let mut joint = JointDef::new(JointKind::Fixed, last, body);
        joint.frame_a = Pose::at(DVec3::X * if last == BodyId::NULL { at } else { 0.2 });
        joint.strength = Strength { tension: 50.0, window: 0.1, ..joint.strength };
        world.create_joint(&joint).unwrap();
        last = body;
    }
    let dt = 1.0 / 60.0;
    for _ in 0..4 {
        world.step(dt).unwrap();
    }
    match blow {
        "an impulse" => world.add_impulse(last, Vec3::X * impulse).unwrap(),
        "a velocity" => world.set_linear_velocity(last, moving + Vec3::X * (impulse / 2.0)).unwrap(),
        "a force for a step" => world.add_force(last, Vec3::X * (impulse / dt)).unwrap(),
        _ => world.add_impulse_at(last, Vec3::X * impulse, world.pose(last).unwrap().position).unwrap(),
    }
    let mut step = || {
        world.step(dt).unwrap();
        world.broken().len()
    };
    (0..30).map(|_| step()).sum()
}

#[test]
fn a_blow_on_what_is_welded_breaks_its_joints_beyond_their_strength() {
    for (kind, blow) in
        [None, Some(BodyKind::Static), Some(BodyKind::Kinematic)].into_iter().flat_map(|kind| BLOWS.map(|blow| (kind, blow)))
    {
        for (count, unions) in [(1, true), (1, false), (3, true)] {
            let moving = if kind == Some(BodyKind::Kinematic) { Vec3::new(0.0, 2.0, 0.0) } else { Vec3::ZERO };
            let what = format!("{blow} on {count} of {kind:?}, unions {unions}");
            // 100 N and 40 N in the mean. Impulses were taken and thrown away.
            assert!(broken_by(blow, 10.0, kind, count, unions, moving) > 0, "{what}: nothing breaks at 100 N");
            assert_eq!(broken_by(blow, 4.0, kind, count, unions, moving), 0, "{what}: breaks at 40 N");
        }
    }
}

//! What stands by thrust: arches, cards and wedges, judged by equilibrium inside the friction cones.

use crate::common::Run;
use longspan::glam::Vec3;
use longspan::{BodyDef, BodyId, Geometry, Mass, Material, Pose, Shape, ShapeDef, Verdict, World, WorldDef};

const DT: f32 = 1.0 / 60.0;

fn by_thrust() -> WorldDef {
    WorldDef { support: true, support_by_thrust: true, ..WorldDef::default() }
}

fn cuboid(half: Vec3) -> ShapeDef {
    ShapeDef::new(Shape::cuboid(half).unwrap())
}

fn run(world: &mut World, steps: u32) {
    for _ in 0..steps {
        world.step(DT).unwrap();
    }
}

fn verdict(world: &World, body: BodyId) -> Verdict {
    world.support(body).unwrap().verdict
}

/// What becomes of the bodies of a scene, and what was said of them after a second, by projection alone and by thrust too: those
/// that stay, and those that are called supported, of which none may go.
fn judged(scene: &str, keys: &[(&str, &str)]) -> (f64, f64, f64) {
    let of = |thrust: &str| {
        let run = Run::of(scene, &[keys, &[("support", "on"), ("thrust", thrust)]].concat());
        run.is("wrongly_supported", 0.0);
        run.is("later_wrongly_supported", 0.0);
        run
    };
    let (projected, by_thrust) = (of("off"), of("on"));
    let stay = by_thrust.error("later_stay");
    assert_eq!(projected.error("later_stay"), stay, "{scene} {keys:?}: the setting changes no motion");
    (stay, projected.error("later_supported"), by_thrust.error("later_supported"))
}

#[test]
fn arches_and_houses_of_cards_stand_by_thrust_while_friction_holds() {
    assert_eq!(judged("arch", &[]), (11.0, 4.0, 11.0), "stones that stay, by projection, and by thrust");
    assert_eq!(judged("arch", &[("friction", "0.3")]), (0.0, 0.0, 0.0));
    assert_eq!(judged("card_house", &[]), (15.0, 0.0, 15.0), "cards that stay, by projection, and by thrust");
    let (stay, projected, by_thrust) = judged("card_house", &[("levels", "1"), ("friction", "0.3")]);
    assert_eq!((stay, projected, by_thrust), (0.0, 0.0, 0.0), "cards that lean by more than atan 0.3");
}

#[test]
fn a_wedge_hangs_between_blocks_that_friction_holds_and_drives_others_apart() {
    let steep = ("angle_deg", "10");
    assert_eq!(judged("wedge", &[steep]), (1.0, 0.0, 1.0), "between fixed blocks");
    assert_eq!(judged("wedge", &[steep, ("free", "on")]), (3.0, 2.0, 3.0), "between free ones");
    let sliding = Run::of("wedge", &[steep, ("free", "on"), ("friction", "0.1"), ("support", "on"), ("thrust", "on")]);
    sliding.is("stay", 0.0);
    sliding.is("supported", 0.0);
}

/// The stones of an arch on the floor from one springer to the other: eleven wedges from 2 m to 2.6 m of radius.
fn add_arch(world: &mut World, friction: f32) -> Vec<BodyId> {
    let surface = Material { friction, ..Material::default() };
    let angle = |number: u32| std::f32::consts::PI * number as f32 / 11.0;
    let stone = |number: u32| {
        let middle = 0.5 * (angle(number) + angle(number + 1));
        let center = 2.3 * Vec3::new(middle.cos(), middle.sin(), 0.0);
        let corner =
            |at: u32, radius: f32, z: f32| radius * Vec3::new(angle(at).cos(), angle(at).sin(), 0.0) - center + Vec3::Z * z;
        let ends = [number, number + 1].into_iter().flat_map(|at| [2.0, 2.6].map(|radius| (at, radius)));
        let points: Vec<Vec3> = ends.flat_map(|(at, radius)| [-0.5, 0.5].map(|z| corner(at, radius, z))).collect();
        let shape = ShapeDef {
            material: surface,
            density: 2000.0,
            ..ShapeDef::new(Shape::new(Geometry::ConvexHull { points }).unwrap())
        };
        BodyDef::dynamic(Pose::at(center.as_dvec3())).with_shape(shape)
    };
    (0..11).map(|number| world.create_body(&stone(number)).unwrap()).collect()
}

fn add_floor(world: &mut World, friction: f32) {
    let surface = Material { friction, ..Material::default() };
    let floor = ShapeDef { material: surface, ..cuboid(Vec3::new(20.0, 0.5, 20.0)) };
    world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(floor)).unwrap();
}

fn arch_on(def: &WorldDef, friction: f32) -> (World, Vec<BodyId>) {
    let mut world = World::new(def).unwrap();
    add_floor(&mut world, friction);
    let stones = add_arch(&mut world, friction);
    (world, stones)
}

#[test]
fn an_arch_is_braced_until_its_keystone_goes() {
    let (mut world, stones) = arch_on(&by_thrust(), 0.6);
    run(&mut world, 120);
    let keystone = stones[5];
    assert!(stones.iter().all(|&stone| verdict(&world, stone).is_supported()));
    assert_eq!(verdict(&world, keystone), Verdict::Braced);
    assert_eq!(world.supporters(keystone).unwrap(), [stones[4], stones[6]], "both neighbours lift it");
    assert!(world.supported_by(stones[4]).unwrap().contains(&keystone));
    let path = world.path_to_ground(keystone).unwrap();
    assert!(path.len() == 7 && path[0] == keystone, "{path:?}");
    // Asleep or held it stays so, and so it does in a world restored from a snapshot.
    let before = world.supported_count().unwrap();
    run(&mut world, 300);
    assert_eq!((before, world.supported_count().unwrap()), (11, 11));
    let mut restored = World::new(&WorldDef::default()).unwrap();
    let mut bytes = Vec::new();
    world.save(&mut bytes);
    restored.restore(&bytes).unwrap();
    let braced = |world: &World| world.bodies().filter(|&body| verdict(world, body) == Verdict::Braced).count();
    assert_eq!((braced(&world), braced(&restored)), (7, 7));

    let predicted = world.would_lose_support(&[keystone]).unwrap();
    assert!(predicted.contains(&stones[4]) && predicted.contains(&stones[6]) && !predicted.contains(&stones[0]), "{predicted:?}");
    world.destroy_body(keystone).unwrap();
    let mut lost = Vec::new();
    for _ in 0..2 {
        world.step(DT).unwrap();
        lost.extend(world.support_changes().unwrap().iter().filter(|change| !change.supported).map(|change| change.body));
    }
    lost.sort_unstable_by_key(|body| stones.iter().position(|stone| stone == body));
    assert_eq!(lost, predicted, "what lost support within two steps");
}

#[test]
fn an_arch_without_enough_friction_is_never_braced() {
    let (mut world, stones) = arch_on(&by_thrust(), 0.3);
    for step in 0..60 {
        world.step(DT).unwrap();
        let braced = stones.iter().filter(|&&stone| verdict(&world, stone) == Verdict::Braced).count();
        assert_eq!(braced, 0, "braced stones of a falling arch in step {step}");
    }
}

#[test]
fn projection_alone_says_nothing_of_thrust() {
    let (mut world, stones) = arch_on(&WorldDef { support: true, ..WorldDef::default() }, 0.6);
    run(&mut world, 120);
    assert_eq!(world.supported_count().unwrap(), 4);
    assert!(!verdict(&world, stones[5]).is_supported());
}

#[test]
fn what_the_host_or_balance_alone_keeps_up_is_not_braced() {
    let mut world = World::new(&by_thrust()).unwrap();
    add_floor(&mut world, 0.5);
    // One box is lifted by the host, one pressed against a wall; a ball balances on a point, which has no inside.
    let wall = BodyDef::fixed(Pose::at_xyz(-5.0, 2.0, 0.0)).with_shape(cuboid(Vec3::new(0.5, 2.0, 2.0)));
    world.create_body(&wall).unwrap();
    let add_box = |world: &mut World, x: f64, y: f64| {
        let def = BodyDef::dynamic(Pose::at_xyz(x, y, 0.0)).with_shape(cuboid(Vec3::splat(0.5))).with_mass(Mass::Total(100.0));
        world.create_body(&def).unwrap()
    };
    let lifted = add_box(&mut world, 0.0, 3.0);
    let ball = BodyDef::dynamic(Pose::at_xyz(5.0, 0.5, 0.0)).with_shape(ShapeDef::new(Shape::ball(0.5).unwrap()));
    let ball = world.create_body(&ball).unwrap();
    let pressed = add_box(&mut world, -4.0, 2.0);
    for _ in 0..30 {
        world.add_force(lifted, Vec3::Y * 981.0).unwrap();
        world.add_force(pressed, Vec3::NEG_X * 4000.0).unwrap();
        world.step(DT).unwrap();
        assert!(![lifted, ball].iter().any(|&body| verdict(&world, body).is_supported()));
        assert!(!verdict(&world, pressed).is_supported(), "the push is the host's, and nothing that the wall returns");
    }
}

//! A host can read how each island was solved, and why.

use longspan::glam::{DVec3, Vec3};
use longspan::{
    BodyDef, BodyId, DebugDraw, DrawLayers, DrawOptions, Geometry, IslandPlan, JointDef, JointKind, Mass, Pose, Shape, ShapeDef,
    Solver, World, WorldDef,
};

const RADIUS: f32 = 0.1;

fn ball(world: &mut World, x: f64, y: f64) -> BodyId {
    let shape = ShapeDef::new(Shape::new(Geometry::Ball { radius: RADIUS }).unwrap());
    let def = BodyDef { mass: Mass::Total(1.0), ..BodyDef::dynamic(Pose::at_xyz(x, y, 0.0)) };
    world.create_body(&def.with_shape(shape)).unwrap()
}

/// Holds two balls together at a point of the world; the first may be the world.
fn join(world: &mut World, ends: [BodyId; 2], at: DVec3, solver: Solver) {
    let mut def = JointDef::new(JointKind::SPHERICAL, ends[0], ends[1]);
    for (body, frame) in ends.into_iter().zip([&mut def.frame_a, &mut def.frame_b]) {
        let base = if body == BodyId::NULL { DVec3::ZERO } else { world.pose(body).unwrap().position };
        *frame = Pose::at(at - base);
    }
    def.solver = solver;
    world.create_joint(&def).unwrap();
}

/// A ball alone, a pendulum, a pendulum whose host asks for sweeps, and two balls on a joint that lie on the ground.
fn scene() -> (World, [BodyId; 3]) {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let ground = ShapeDef::new(Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap());
    world.create_body(&BodyDef::fixed(Pose::at(DVec3::ZERO)).with_shape(ground)).unwrap();
    ball(&mut world, -5.0, f64::from(RADIUS));
    let pendulum = ball(&mut world, 0.0, 3.0);
    join(&mut world, [BodyId::NULL, pendulum], DVec3::new(1.0, 3.0, 0.0), Solver::Auto);
    let swept = ball(&mut world, 5.0, 3.0);
    join(&mut world, [BodyId::NULL, swept], DVec3::new(6.0, 3.0, 0.0), Solver::GaussSeidel);
    let lying = [10.0, 10.5].map(|x| ball(&mut world, x, f64::from(RADIUS)));
    join(&mut world, lying, DVec3::new(10.25, f64::from(RADIUS), 0.0), Solver::Auto);
    world.step(1.0 / 60.0).unwrap();
    (world, [pendulum, swept, lying[0]])
}

#[test]
fn each_island_with_joints_says_how_it_was_solved() {
    let (world, [pendulum, swept, lying]) = scene();
    let found: Vec<_> = world.islands().iter().map(|island| (island.body, island.bodies, island.joints, island.plan)).collect();
    assert_eq!(found.len(), 3, "the ball alone has no joint: {found:?}");
    for expected in [(pendulum, 1, 1, IslandPlan::Apart), (swept, 1, 1, IslandPlan::Swept), (lying, 2, 1, IslandPlan::Coupled)] {
        assert!(found.contains(&expected), "{expected:?} is not among {found:?}");
    }
    assert!(world.islands().iter().all(|island| !island.given_up), "none of these is hard: {:?}", world.islands());
}

#[test]
fn plans_are_drawn_at_their_islands() {
    #[derive(Default)]
    struct Texts(Vec<(DVec3, String)>);
    impl DebugDraw for Texts {
        fn line(&mut self, _: DVec3, _: DVec3, _: longspan::Color) {}
        fn triangle(&mut self, _: [DVec3; 3], _: longspan::Color) {}
        fn text(&mut self, at: DVec3, text: &str, _: longspan::Color) {
            self.0.push((at, text.to_owned()));
        }
    }
    let (world, [_, _, lying]) = scene();
    let mut texts = Texts::default();
    world.draw(&DrawOptions { layers: DrawLayers::ISLANDS, ..DrawOptions::default() }, &mut texts).unwrap();
    let at = world.pose(lying).unwrap().position;
    let coupled: Vec<_> = texts.0.iter().filter(|(_, text)| text == "Coupled").collect();
    assert!(coupled.len() == 1 && coupled[0].0.distance(at) < 1e-6, "{:?}", texts.0);
}

/// A rope of `links` balls of a kilogram, 0.3 m apart, that hangs all but level from two points, and a ball of `mass` (kg) that lies on its middle.
fn ridden_rope(links: usize, mass: f32) -> World {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let balls: Vec<BodyId> = (0..links).map(|i| ball(&mut world, 0.3 * i as f64, 0.0)).collect();
    for pair in balls.windows(2) {
        let middle = 0.5 * (world.pose(pair[0]).unwrap().position + world.pose(pair[1]).unwrap().position);
        join(&mut world, [pair[0], pair[1]], middle, Solver::Auto);
    }
    for (end, x) in [(balls[0], -0.15), (balls[links - 1], 0.3 * links as f64 - 0.15)] {
        join(&mut world, [BodyId::NULL, end], DVec3::new(x, 0.0, 0.0), Solver::Auto);
    }
    let shape = ShapeDef::new(Shape::new(Geometry::Ball { radius: RADIUS }).unwrap());
    let at = Pose::at_xyz(0.3 * (links / 2) as f64, 2.0 * f64::from(RADIUS), 0.0);
    world.create_body(&BodyDef { mass: Mass::Total(mass), ..BodyDef::dynamic(at) }.with_shape(shape)).unwrap();
    world.step(1.0 / 60.0).unwrap();
    world
}

/// A rider is carried directly, but where it is heavy or the rope is so short that its rows are more work than the joints.
#[test]
fn points_carry_a_rider_by_a_direct_solve() {
    for (links, mass, expected) in [(30, 5.0, IslandPlan::Apart), (30, 500.0, IslandPlan::Coupled), (1, 5.0, IslandPlan::Coupled)]
    {
        let world = ridden_rope(links, mass);
        let plans: Vec<_> = world.islands().iter().map(|island| island.plan).collect();
        assert_eq!(plans, [expected], "a rope of {links} balls that carries {mass} kg");
    }
}

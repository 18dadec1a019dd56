//! Dry pieces that lean on each other, not in a row: houses of cards, arches that share a pier, planks that lean on planks. What
//! stands by mechanics keeps its place, at any rate and size; what is hit falls.

use std::f64::consts::PI;

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Geometry, IslandPlan, Material, Pose, Shape, ShapeDef, SleepSettings, World, WorldDef};

/// A world without sleep, and all that stands in it, with where it was made.
struct Structure {
    world: World,
    size: f64,
    friction: f32,
    ground: BodyId,
    pieces: Vec<(BodyId, DVec3)>,
}

impl Structure {
    fn new(size: f64, friction: f32) -> Self {
        let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
        let world = World::new(&WorldDef { sleep, ..WorldDef::default() }).unwrap();
        let mut made = Self { world, size, friction, ground: BodyId::NULL, pieces: Vec::new() };
        let plane = made.shape(Geometry::HalfSpace { normal: Vec3::Y });
        made.ground = made.world.create_body(&BodyDef::fixed(Pose::default()).with_shape(plane)).unwrap();
        made
    }

    fn shape(&self, geometry: Geometry) -> ShapeDef {
        let material = Material { friction: self.friction, ..Material::default() };
        ShapeDef { material, ..ShapeDef::new(Shape::new(geometry).unwrap()) }
    }

    fn add(&mut self, geometry: Geometry, x: f64, y: f64, lean: f64) {
        let position = DVec3::new(x, y, 0.0) * self.size;
        let pose = Pose { position, rotation: Quat::from_rotation_z(lean as f32) };
        let body = BodyDef::dynamic(pose).with_shape(self.shape(geometry));
        self.pieces.push((self.world.create_body(&body).unwrap(), position));
    }

    /// A box of these half extents, in sizes.
    fn add_box(&mut self, half: [f64; 3], x: f64, y: f64, lean: f64) {
        let half_extents = (DVec3::from_array(half) * self.size).as_vec3();
        self.add(Geometry::Box { half_extents }, x, y, lean);
    }

    /// Pairs of cards of 1 m by 0.6 m by 2 cm that lean by 20°, so many at the bottom, one less on each level, on lying cards.
    fn card_house(levels: usize, size: f64, friction: f32) -> Self {
        let mut made = Self::new(size, friction);
        let ([thick, half, wide], lean) = ([0.01, 0.5, 0.3], 20.0 * PI / 180.0);
        let (sin, cos) = lean.sin_cos();
        let (half_width, half_height) = (thick * cos + half * sin, thick * sin + half * cos);
        let (pitch, overhang) = (4.0 * half_width + 0.005, 3.0 * thick * cos);
        let mut bottom = 0.0;
        for pairs in (1..=levels).rev() {
            let apex = |pair: usize| pitch * (pair as f64 - 0.5 * (pairs as f64 - 1.0));
            for pair in 0..pairs {
                for side in [-1.0, 1.0] {
                    made.add_box([thick, half, wide], apex(pair) + side * half_width, bottom + half_height, side * lean);
                }
            }
            bottom += 2.0 * half_height;
            for gap in 1..pairs {
                let left = apex(gap - 1) + if gap == 1 { -overhang } else { 0.0025 };
                let right = apex(gap) + if gap == pairs - 1 { overhang } else { -0.0025 };
                made.add_box([0.5 * (right - left), thick, wide], 0.5 * (left + right), bottom + thick, 0.0);
            }
            bottom += 2.0 * thick;
        }
        made
    }

    /// Two half circles of so many stones, of 1 m inside and 1.3 m outside, whose feet stand side by side on the middle one of three piers.
    fn arcade(stones: usize, size: f64, friction: f32) -> Self {
        let mut made = Self::new(size, friction);
        for side in [-1.0, 1.0] {
            for stone in 0..stones {
                let [from, to] = [0, 1].map(|end| PI * (stone + end) as f64 / stones as f64);
                let corner = |n: usize| {
                    let (angle, radius) = ([from, to][n & 1], [1.0, 1.3][n >> 1 & 1]);
                    DVec3::new(angle.cos() * radius, angle.sin() * radius, [-0.3, 0.3][n >> 2])
                };
                let center = (0..8).map(corner).sum::<DVec3>() / 8.0;
                let points = (0..8).map(|n| ((corner(n) - center) * size).as_vec3()).collect();
                made.add(Geometry::ConvexHull { points }, center.x + side * 1.3, center.y + 1.0, 0.0);
            }
        }
        for (middle, half) in [(-2.6, 0.8), (0.0, 0.5), (2.6, 0.8)] {
            made.add_box([half, 0.5, 0.3], middle, 0.5, 0.0);
        }
        made
    }

    /// So many planks of 1.6 m that lean by 25°, each on the next, the last one on a wall.
    fn leaning_planks(planks: usize, size: f64, friction: f32) -> Self {
        let mut made = Self::new(size, friction);
        let (thick, half, lean) = (0.03, 0.8, 25.0 * PI / 180.0);
        let (sin, cos) = lean.sin_cos();
        for plank in 0..planks {
            let x = -(thick * cos + half * sin) - 2.0 * plank as f64 * thick / cos;
            made.add_box([thick, half, 0.2], x, thick * sin + half * cos, -lean);
        }
        let wall = made.shape(Geometry::Box { half_extents: Vec3::new(0.5, 3.0, 2.0) * size as f32 });
        let pose = Pose::at(DVec3::new(0.5, 3.0, 0.0) * size);
        made.world.create_body(&BodyDef::fixed(pose).with_shape(wall)).unwrap();
        made
    }

    /// Greatest way of any piece from where it was made, over the size, after so many seconds; and the plan of each island in the first step.
    fn keeps(mut self, seconds: f32, rate: f32) -> (f64, Vec<IslandPlan>) {
        self.world.step(1.0 / rate).unwrap();
        let plans = self.world.islands().iter().map(|island| island.plan).collect();
        for _ in 1..(seconds * rate) as usize {
            self.world.step(1.0 / rate).unwrap();
        }
        let way = |&(body, made): &(BodyId, DVec3)| self.world.pose(body).unwrap().position.distance(made);
        (self.pieces.iter().map(way).fold(0.0, f64::max) / self.size, plans)
    }
}

/// Swept, three levels slid by 3 mm at 60 Hz, four by 7, and five and seven fell.
#[test]
fn a_house_of_cards_of_any_size_stands() {
    for (levels, size, rate, friction) in [
        (3, 1.0, 30.0, 0.6),
        (5, 1.0, 60.0, 0.6),
        (7, 1.0, 60.0, 0.6),
        (5, 0.1, 60.0, 0.4),
        (5, 10.0, 30.0, 0.6),
        (4, 1.0, 240.0, 0.4),
    ] {
        let (way, plans) = Structure::card_house(levels, size, friction).keeps(2.0, rate);
        assert_eq!(plans, [IslandPlan::Coupled], "{levels} levels, {size} m, {rate} Hz: it is one problem");
        assert!(
            way < 1.0e-5,
            "{levels} levels, {size} m, {rate} Hz, friction {friction}: moved by {way} of its size, bound 1e-5"
        );
    }
}

/// Swept, stones of two arches moved by 1.6 mm at 30 Hz.
#[test]
fn arches_on_one_pier_keep_their_place() {
    for (stones, size, rate) in [(5, 1.0, 30.0), (7, 0.1, 60.0), (3, 10.0, 60.0), (5, 1.0, 240.0)] {
        let (way, _) = Structure::arcade(stones, size, 0.7).keeps(2.0, rate);
        assert!(way < 1.0e-5, "{stones} stones, {size} m, {rate} Hz: moved by {way} of its size, bound 1e-5");
    }
}

/// Swept, they slid by 0.2 mm at 30 Hz.
#[test]
fn planks_that_lean_on_planks_keep_their_place() {
    for (planks, size, rate) in [(4, 1.0, 30.0), (3, 0.1, 60.0), (6, 10.0, 120.0)] {
        let (way, _) = Structure::leaning_planks(planks, size, 0.7).keeps(2.0, rate);
        assert!(way < 1.0e-5, "{planks} planks, {size} m, {rate} Hz: moved by {way} of its size, bound 1e-5");
    }
}

/// A house of cards on a platform that goes up and down by half a metre in four seconds moves as the platform does.
#[test]
fn a_house_of_cards_rides_on_a_platform() {
    for rate in [30.0, 60.0, 120.0] {
        let mut house = Structure::card_house(4, 1.0, 0.6);
        house.world.destroy_body(house.ground).unwrap();
        let deck = house.shape(Geometry::Box { half_extents: Vec3::new(3.0, 0.1, 1.0) });
        let at = |time: f64| DVec3::Y * (-0.1 + 0.25 * (1.0 - (0.5 * PI * time).cos()));
        let deck = house.world.create_body(&BodyDef::kinematic(Pose::at(at(0.0))).with_shape(deck)).unwrap();
        let steps = (8.0 * rate) as usize;
        for step in 1..=steps {
            house.world.move_to(deck, Pose::at(at(step as f64 / rate))).unwrap();
            house.world.step(1.0 / rate as f32).unwrap();
        }
        let way = |&(body, made): &(BodyId, DVec3)| house.world.pose(body).unwrap().position.distance(made);
        let way = house.pieces.iter().map(way).fold(0.0, f64::max);
        assert!(way < 1.0e-4, "{rate} Hz: a card is {way} m from its place on the platform, bound 1e-4");
    }
}

/// Beyond what friction holds, tan 20° = 0.36 of cards, nothing is held up; nor is a house that a ball hits.
#[test]
fn what_does_not_stand_by_mechanics_falls() {
    let (way, _) = Structure::card_house(3, 1.0, 0.3).keeps(2.0, 60.0);
    assert!(way > 0.1, "too smooth cards lie {way} m from where they stood, at least 0.1");
    let mut house = Structure::card_house(4, 1.0, 0.6);
    let ball = ShapeDef::new(Shape::new(Geometry::Ball { radius: 0.1 }).unwrap());
    let thrown = BodyDef { linear_velocity: Vec3::X * 8.0, ..BodyDef::dynamic(Pose::at(DVec3::new(-4.0, 0.6, 0.0))) };
    house.world.create_body(&thrown.with_shape(ball)).unwrap();
    let (way, _) = house.keeps(3.0, 60.0);
    assert!(way > 0.5, "a card of a house that a ball hits lies {way} m from where it stood, at least 0.5");
}

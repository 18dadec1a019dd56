//! Random solids that an oracle knows by what is inside them and by their farthest points; cases of each pair of them.
//!
//! LONGSPAN_QUERY_CASES sets the number of random cases of each pair at each scale (10 by default; by hand, 10000).
//! LONGSPAN_QUERY_SCALES=first..last and LONGSPAN_QUERY_TARGETS=first..last take some of the scales and of the kinds of target,
//! to split a long run; LONGSPAN_QUERY_SEED takes other cases. Ten thousand took 15 to 135 s of one processor for each kind of target, optimised:
//! of 4.9 million cases of solids and 200,000 grounds none was wrong on 27 November 2026.
#![allow(dead_code, reason = "each test program uses a part of this")]

use longspan::glam::{DQuat, DVec3, Quat, Vec3};
use longspan::{BodyDef, Geometry, Pose, QueryFilter, Shape, ShapeDef, ShapeId, World, WorldDef};

const SCALES: [f64; 5] = [1.0e-3, 0.03, 1.0, 50.0, 1.0e4];

/// Error that is allowed, over the smaller shape: what single-precision normals and witness points on needles leave.
pub const RELATIVE: f64 = 1.0e-6;

/// Error that is allowed, over the larger shape and the distance from the world's origin: rounding of doubles.
pub const ROUNDING: f64 = 1.0e-12;

fn number(name: &str, ordinary: usize) -> usize {
    std::env::var(name).map_or(ordinary, |text| text.parse().expect("a number"))
}

pub fn cases() -> usize {
    number("LONGSPAN_QUERY_CASES", 10)
}

/// The numbers that a variable of the form `first..last` chooses out of `count`.
fn chosen(name: &str, count: usize) -> std::ops::Range<usize> {
    let text = std::env::var(name).unwrap_or_else(|_| format!("0..{count}"));
    let (first, last) = text.split_once("..").expect("first..last");
    first.parse().expect("a number")..last.parse().expect("a number")
}

/// The scales to look at, each with its number.
pub fn scales() -> impl Iterator<Item = (usize, f64)> {
    chosen("LONGSPAN_QUERY_SCALES", SCALES.len()).map(|number| (number, SCALES[number]))
}

/// Random numbers for the cases of this number.
pub fn dice(number: usize) -> Dice {
    Dice((1 + number + 100_000 * self::number("LONGSPAN_QUERY_SEED", 0)) as u64)
}

/// A convex form somewhere, known by what is inside it and by its farthest points.
pub struct Solid {
    pub geometry: Geometry,
    pub pose: Pose,
    /// Planes of a hull, by brute force over its points.
    planes: Vec<(DVec3, f64)>,
}

impl Solid {
    pub fn new(geometry: Geometry, pose: Pose) -> Self {
        let planes = match &geometry {
            Geometry::ConvexHull { .. } => {
                let (points, triangles) = geometry.triangles().expect("a hull has triangles");
                let at = |index: u32| points[index as usize].as_dvec3();
                let plane = |[a, b, c]: [u32; 3]| {
                    let normal = (at(b) - at(a)).cross(at(c) - at(a)).normalize();
                    (normal, normal.dot(at(a)))
                };
                triangles.into_iter().map(plane).collect()
            }
            _ => Vec::new(),
        };
        Self { geometry, pose, planes }
    }

    pub fn rotation(&self) -> DQuat {
        self.pose.rotation.as_dquat().normalize()
    }

    /// How far a point is outside (m), negative inside; convex, and in the direction of a face or a round side exact.
    pub fn outside(&self, point: DVec3) -> f64 {
        let p = self.rotation().conjugate() * (point - self.pose.position);
        let across = p.x.hypot(p.z);
        match self.geometry {
            Geometry::Ball { radius } => p.length() - f64::from(radius),
            Geometry::Box { half_extents } => (p.abs() - half_extents.as_dvec3()).max_element(),
            Geometry::Capsule { half_height, radius } => {
                let h = f64::from(half_height);
                (p - DVec3::Y * p.y.clamp(-h, h)).length() - f64::from(radius)
            }
            Geometry::Cylinder { half_height, radius } => (p.y.abs() - f64::from(half_height)).max(across - f64::from(radius)),
            Geometry::Cone { half_height, radius } => {
                let (h, k) = (f64::from(half_height), f64::from(radius) / f64::from(2.0 * half_height));
                (-h - p.y).max((across - k * (h - p.y)) / (1.0 + k * k).sqrt())
            }
            Geometry::ConvexHull { .. } => self.planes.iter().map(|(n, d)| n.dot(p) - d).fold(f64::MIN, f64::max),
            Geometry::HalfSpace { normal } => normal.as_dvec3().normalize().dot(p),
            _ => unreachable!("not convex"),
        }
    }

    /// The greatest coordinate along a unit direction (m).
    pub fn top(&self, direction: DVec3) -> f64 {
        let d = self.rotation().conjugate() * direction;
        let across = d.x.hypot(d.z);
        let local = match &self.geometry {
            Geometry::Ball { radius } => f64::from(*radius),
            Geometry::Box { half_extents } => half_extents.as_dvec3().dot(d.abs()),
            Geometry::Capsule { half_height, radius } => f64::from(*half_height) * d.y.abs() + f64::from(*radius),
            Geometry::Cylinder { half_height, radius } => f64::from(*half_height) * d.y.abs() + f64::from(*radius) * across,
            Geometry::Cone { half_height, radius } => {
                let h = f64::from(*half_height);
                (h * d.y).max(f64::from(*radius) * across - h * d.y)
            }
            Geometry::ConvexHull { points } => points.iter().map(|p| p.as_dvec3().dot(d)).fold(f64::MIN, f64::max),
            // It has no end in any direction but its normal; the plane passes through its origin.
            Geometry::HalfSpace { .. } => 0.0,
            _ => unreachable!("not convex"),
        };
        direction.dot(self.pose.position) + local
    }

    /// How far this and another are apart along a direction from this to the other (m).
    pub fn apart(&self, other: &Self, direction: DVec3) -> f64 {
        -other.top(-direction) - self.top(direction)
    }
}

/// Random numbers (Steele, Lea and Flood 2014).
pub struct Dice(u64);

impl Dice {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::new(self.between(-size, size), self.between(-size, size), self.between(-size, size))
    }

    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector(1.0);
            if (0.1..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }

    pub fn pose(&mut self, position: DVec3) -> Pose {
        let turn = self.direction() * self.between(0.0, 3.1);
        let rotation = if self.unit() < 0.25 { Quat::IDENTITY } else { DQuat::from_scaled_axis(turn).as_quat() };
        Pose::at(position).rotated(rotation)
    }

    pub fn form(&mut self, kind: usize, scale: f64) -> Geometry {
        let mut size = || (self.between(0.2, 1.0) * scale) as f32;
        match kind {
            0 => Geometry::Ball { radius: size() },
            1 => Geometry::Box { half_extents: Vec3::new(size(), size(), size()) },
            2 => Geometry::Capsule { half_height: size(), radius: size() },
            3 => Geometry::Cylinder { half_height: size(), radius: size() },
            4 => Geometry::Cone { half_height: size(), radius: size() },
            5 => {
                let half = Vec3::new(size(), size(), size());
                let count = 8 + (self.between(0.0, 40.0) as usize);
                Geometry::ConvexHull { points: (0..count).map(|_| self.direction().as_vec3() * half).collect() }
            }
            _ => Geometry::HalfSpace { normal: self.direction().as_vec3().normalize() },
        }
    }
}

/// A world with one static shape, and the same shape as the oracle knows it.
pub struct Scene {
    pub world: World,
    pub target: Solid,
}

impl Scene {
    pub fn new(geometry: Geometry, pose: Pose) -> Self {
        let mut world = World::new(&WorldDef::default()).unwrap();
        add(&mut world, geometry.clone(), pose);
        Self { world, target: Solid::new(geometry, pose) }
    }
}

pub fn add(world: &mut World, geometry: Geometry, pose: Pose) -> ShapeId {
    let def = BodyDef::fixed(pose).with_shape(ShapeDef::new(Shape::new(geometry).expect("a form")));
    let body = world.create_body(&def).unwrap();
    world.body_shapes(body).unwrap()[0]
}

pub fn all() -> QueryFilter<'static> {
    QueryFilter::default()
}

pub const KINDS: [&str; 7] = ["ball", "box", "capsule", "cylinder", "cone", "hull", "half-space"];

/// Runs cases of each kind of target, with each kind of probe if there is one, at each scale; `case` says what is wrong.
pub fn each(probes: usize, mut case: impl FnMut(&mut Dice, (usize, usize), f64) -> Result<(), String>) {
    let (mut wrong, mut first) = (0, Vec::new());
    let mut count = 0;
    for (number, scale) in scales() {
        for target in chosen("LONGSPAN_QUERY_TARGETS", KINDS.len()) {
            for (probe, name) in KINDS.iter().enumerate().take(probes) {
                let mut dice = dice(number * 100 + target * 10 + probe);
                for round in 0..cases() {
                    count += 1;
                    if let Err(problem) = case(&mut dice, (target, probe), scale) {
                        wrong += 1;
                        first.push(format!("{} and {}, {scale} m, case {round}: {problem}", KINDS[target], name));
                    }
                }
            }
        }
    }
    println!("{count} cases, {wrong} wrong");
    first.truncate(100);
    assert!(wrong == 0, "{wrong} of {count} wrong:\n{}", first.join("\n"));
}

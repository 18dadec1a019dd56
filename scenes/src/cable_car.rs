//! A cable over two drums with a car at each end (Müller et al. 2017, Fig. 1), and a third car that the two pull up.
//!
//! Two static drums at x = ±3 m, y = 0, without friction: cylinders of 1 m, or where `sides` is set, prisms whose corners lie on
//! that circle. n capsule links (0.2 m, radius 0.02 m, 1 kg) with their joints on a path 1.03 m from the drums' axes, so that the
//! cable starts 1 cm off the drums: from the lowest point of the middle along the tangent to each drum, over it, and straight down.
//! Cars are boxes of half-extent 0.5 m and `ratio` kg, the second of `second` times that, jointed at the middle of their tops. An
//! engine without cylinders stands prisms in for them.
//!
//! Links that lie on the drum have their middles 1.02 m from its axis: 8.036 of them make a quarter turn, where the joints' path has
//! 8.077, so that cars drop by 8.1 mm as the cable comes to lie on its drums. On 32 sides, each as long as a link, it is 15.6 mm, and
//! the drums are sprockets: lifting all links over the corners at once takes 1.4 kJ, half a pitch of ten tonnes against nine gives
//! 1.0 kJ.
//!
//! Two cars of m and m′ with a cable of mass c run as an Atwood machine: |a| = g·|m − m′|/(m + m′ + c) while the parts of the cable
//! that hang differ little. With three equal cars the middle one starts 1.5 m below the drums' axes, where the cable stands steeper
//! than the 30° at which two of them hold a third, and is pulled up, by about 1.5 m before it swings back: by then height plus twice
//! the length to a drum is what it was at the start.

use std::f64::consts::FRAC_PI_2;

use longspan::glam::{DVec2, DVec3, Quat, Vec3};
use longspan::{BodyDef, Geometry, Pose};

use crate::assemble::{INTANGIBLE, rod, solid};
use crate::metrics::{JointGap, Reading, Stretch};
use crate::params::{Params, SceneError};
use crate::scene::{DT, GRAVITY, Scene, cuboid, shape, start, with_friction};

const PITCH: f64 = 0.2;
const LINK_RADIUS: f32 = 0.02;
const DRUM_X: f64 = 3.0;
const DRUM_RADIUS: f32 = 1.0;
const DRUM_HALF_LENGTH: f32 = 0.5;
/// From a drum's axis to the path of the joints (m).
const PATH_RADIUS: f64 = 1.03;
const CAR_HALF: f32 = 0.5;
/// Depth at which a third car starts (m).
const MIDDLE_DEPTH: f64 = 1.5;
/// Errors count over the last two seconds.
const LAST: u32 = 120;
/// When the speed of the cars is read (s).
const SPEED_AFTER: f64 = 1.5;

/// The right half of the path: a straight from the middle to the drum, an arc over it, and straight down.
struct HalfPath {
    middle: DVec2,
    /// Where the straight meets the arc, as an angle about the drum's axis from x (rad).
    touch: f64,
}

impl HalfPath {
    /// The tangent from the middle point touches the upper left of the circle: at the angle of the middle as seen from the drum's
    /// axis, less the angle whose cosine is radius over distance.
    fn new(height: f64) -> Self {
        let middle = DVec2::new(0.0, height);
        let to_middle = middle - DVec2::new(DRUM_X, 0.0);
        let seen_at = libm::atan2(to_middle.y, to_middle.x).rem_euclid(std::f64::consts::TAU);
        Self { middle, touch: seen_at - libm::acos(PATH_RADIUS / to_middle.length()) }
    }

    fn on_arc(angle: f64) -> DVec2 {
        DVec2::new(DRUM_X, 0.0) + PATH_RADIUS * DVec2::from_angle(angle)
    }

    /// The point at this arc length from the middle.
    fn at(&self, way: f64) -> DVec2 {
        let touch = Self::on_arc(self.touch);
        let straight = touch.distance(self.middle);
        let arc = PATH_RADIUS * self.touch;
        if way < straight {
            self.middle.lerp(touch, way / straight)
        } else if way < straight + arc {
            Self::on_arc(self.touch - (way - straight) / PATH_RADIUS)
        } else {
            Self::on_arc(0.0) - DVec2::Y * (way - straight - arc)
        }
    }

    /// The arc length at which the path is `chord` away from `from`, which it passed at arc length `way`.
    fn step(&self, way: f64, from: DVec2, chord: f64) -> f64 {
        // On a convex path an arc is never shorter than its chord nor, here, longer than half a turn about it.
        let (mut near, mut far) = (way, way + FRAC_PI_2 * chord);
        for _ in 0..80 {
            let half = 0.5 * (near + far);
            if self.at(half).distance(from) < chord { near = half } else { far = half }
        }
        0.5 * (near + far)
    }

    /// Joints on the path, `PITCH` apart, the first this far from the middle.
    fn joints(&self, first: f64, count: usize) -> Vec<DVec2> {
        let mut way = first;
        let mut points = vec![self.at(way)];
        for _ in 1..count {
            let from = points[points.len() - 1];
            way = self.step(way, from, PITCH);
            points.push(self.at(way));
        }
        points
    }
}

pub(crate) fn cable_car(params: &mut Params) -> Result<Scene, SceneError> {
    let count = params.count("n", 100, 60..=2000)?;
    let ratio = params.number("ratio", 1.0e4, 1.0e-3..=1.0e9)?;
    let cars = params.word("cars", &["2", "3"])?;
    let second = params.number("second", 1.0, 1.0e-6..=1.0e6)?;
    let sides = params.count("sides", 0, 0..=1000)?;
    // Unequal cars would run off the cable.
    let mut scene = start(params, if second == 1.0 { 10.0 } else { SPEED_AFTER })?;

    let middle_height = if cars == "3" { -MIDDLE_DEPTH } else { PATH_RADIUS };
    let path = HalfPath::new(middle_height);
    let is_even = count % 2 == 0;
    // A third car hangs from a joint, so the middle must be one.
    let count = if cars == "3" && !is_even { count + 1 } else { count };
    let points = if count % 2 == 0 {
        let right = path.joints(0.0, count / 2 + 1);
        mirrored(&right[1..]).into_iter().chain(right).collect::<Vec<_>>()
    } else {
        let right = path.joints(0.5 * PITCH, count.div_ceil(2));
        mirrored(&right).into_iter().chain(right).collect()
    };
    let points: Vec<DVec3> = points.into_iter().map(|point| point.extend(0.0)).collect();

    add_drums(&mut scene, sides)?;
    let links: Vec<usize> = points
        .windows(2)
        .map(|pair| Ok(scene.body(with_gliding(rod(pair[0], pair[1], LINK_RADIUS, 1.0)?))))
        .collect::<Result<_, SceneError>>()?;
    let mut joints: Vec<usize> = Vec::new();
    let ends = [(points[0], links[0], ratio), (points[count], links[count - 1], ratio * second)];
    let [left, right] = ends.map(|(point, link, mass)| add_car(&mut scene, point, link, mass));
    let (left, right) = (left?, right?);
    joints.push(left.1);
    for (index, pair) in links.windows(2).enumerate() {
        joints.push(scene.tie(pair[0], pair[1], points[index + 1]));
    }
    joints.push(right.1);

    scene.judge(Stretch::new(joints, count as f64 * PITCH, LAST));
    scene.judge(JointGap::over_last(LAST));
    let ends = [(left.0, scene.bodies[left.0].pose.position.y), (right.0, scene.bodies[right.0].pose.position.y)];
    scene.judge(Reading::after(scene.steps, "car_drop_m", move |view| {
        ends.iter().map(|&(car, start)| start - view.center(car).y).sum::<f64>() / 2.0
    }));
    if cars == "3" {
        let (third, _) = add_car(&mut scene, points[count / 2], links[count / 2], ratio)?;
        // It has two links at its top and a joint with one of them.
        for shape in &mut scene.bodies[third].shapes {
            shape.filter = INTANGIBLE;
        }
        let start = scene.bodies[third].pose.position.y;
        scene.judge(Reading::worst_of_last(scene.steps, "third_rise_m", move |view| view.center(third).y - start));
    }
    if second != 1.0 {
        let masses = (ratio, ratio * second);
        let pull = (masses.0 - masses.1).abs() / (masses.0 + masses.1 + count as f64);
        let expected = f64::from(GRAVITY) * pull * SPEED_AFTER;
        let after = (SPEED_AFTER / f64::from(DT)).round() as u32;
        let speed = move |view: &crate::metrics::View| {
            let of = |car: usize| f64::from(view.engine.linear_velocity(car).y);
            0.5 * (of(left.0) - of(right.0)).abs()
        };
        scene.judge(Reading::after(after, "car_speed", speed));
        scene.judge(Reading::after(after, "atwood_err_pct", move |view| 100.0 * (speed(view) - expected).abs() / expected));
    }
    Ok(scene)
}

/// The points of the other half, from its end to the middle.
fn mirrored(right: &[DVec2]) -> Vec<DVec2> {
    right.iter().rev().map(|point| DVec2::new(-point.x, point.y)).collect()
}

fn with_gliding(mut def: BodyDef) -> BodyDef {
    def.shapes = def.shapes.into_iter().map(|shape| with_friction(shape, 0.0)).collect();
    def
}

fn add_drums(scene: &mut Scene, sides: usize) -> Result<(), SceneError> {
    let form = if sides == 0 { Geometry::Cylinder { half_height: DRUM_HALF_LENGTH, radius: DRUM_RADIUS } } else { prism(sides) };
    let lying = Quat::from_rotation_x(FRAC_PI_2 as f32);
    let drum = with_friction(shape(form)?, 0.0);
    for x in [-DRUM_X, DRUM_X] {
        let mut pose = Pose::at_xyz(x, 0.0, 0.0);
        pose.rotation = lying;
        scene.body(BodyDef::fixed(pose).with_shape(drum.clone()));
    }
    Ok(())
}

/// A prism about y whose corners lie on the drum.
fn prism(sides: usize) -> Geometry {
    let corner = |index: usize, y: f32| {
        let angle = index as f64 / sides as f64 * std::f64::consts::TAU;
        let on_rim = DVec2::from_angle(angle).as_vec2() * DRUM_RADIUS;
        Vec3::new(on_rim.x, y, on_rim.y)
    };
    let points = (0..sides).flat_map(|index| [corner(index, DRUM_HALF_LENGTH), corner(index, -DRUM_HALF_LENGTH)]);
    Geometry::ConvexHull { points: points.collect() }
}

/// A car whose top hangs at `point` from `link`; returns it and its joint.
fn add_car(scene: &mut Scene, point: DVec3, link: usize, mass: f64) -> Result<(usize, usize), SceneError> {
    let pose = Pose::at(point - DVec3::Y * f64::from(CAR_HALF));
    let car = scene.body(solid(pose, cuboid(CAR_HALF, CAR_HALF, CAR_HALF)?, mass as f32));
    Ok((car, scene.tie(link, car, point)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_keeps_its_distance_from_the_drum() {
        for height in [PATH_RADIUS, -MIDDLE_DEPTH] {
            let path = HalfPath::new(height);
            let joints = path.joints(0.0, 51);
            let axis = DVec2::new(DRUM_X, 0.0);
            let nearest = joints.iter().map(|joint| joint.distance(axis)).fold(f64::INFINITY, f64::min);
            assert!((nearest - PATH_RADIUS).abs() < 1e-3, "a joint lies {nearest} m from the axis, expected {PATH_RADIUS} m");
            for pair in joints.windows(2) {
                let apart = pair[0].distance(pair[1]);
                assert!((apart - PITCH).abs() < 1e-12, "joints lie {apart} m apart, expected {PITCH} m");
            }
            assert!((joints[50].x - DRUM_X - PATH_RADIUS).abs() < 1e-12, "the cable does not hang straight down");
        }
    }
}

//! Bounds are bounds: no pose that the joints allow violates one.

use std::f64::consts::PI;

use longspan::glam::{DQuat, DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, BoundState, JointDef, JointId, JointKind, Limits, LongRangeDef, Mass, Pose, Shape, ShapeDef, Solver,
    SphericalMotor, World, WorldDef,
};
use longspan_scenes::Random;
use proptest::prelude::*;

/// How far a pose may pass a bound, as a share of the length that the bound is about.
const TOLERANCE: f64 = 1e-5;

fn between(dice: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * dice.unit()
}

/// A joint of a tree: body `i + 1` hangs on `parent`, body 0 being the world or the first body.
struct Branch {
    parent: usize,
    frames: [(Vec3, Quat); 2],
    kind: JointKind,
}

/// What a joint's coordinates may be: hinge angle, or swing, direction of swing and twist.
type Coordinates = [f64; 3];

impl Branch {
    fn draw(&self, dice: &mut Random) -> Coordinates {
        match self.kind {
            JointKind::Hinge { limits, .. } => {
                [between(dice, f64::from(limits.min).max(-PI), f64::from(limits.max).min(PI)), 0.0, 0.0]
            }
            JointKind::Spherical { swing_limit, .. } => {
                // Half of all draws lie on the limit, where extremes are.
                let swing = if dice.unit() < 0.5 { f64::from(swing_limit) } else { between(dice, 0.0, f64::from(swing_limit)) };
                [swing, between(dice, -PI, PI), between(dice, -PI, PI)]
            }
            _ => [0.0; 3],
        }
    }

    /// Coordinates a little way from these, within the limits.
    fn near(&self, [first, second, third]: Coordinates, step: f64, dice: &mut Random) -> Coordinates {
        let mut moved = |by: f64| by + between(dice, -step, step);
        match self.kind {
            JointKind::Hinge { limits, .. } => {
                [moved(first).clamp(f64::from(limits.min).max(-PI), f64::from(limits.max).min(PI)), 0.0, 0.0]
            }
            JointKind::Spherical { swing_limit, .. } => {
                [moved(first).clamp(0.0, f64::from(swing_limit)), moved(second), moved(third)]
            }
            _ => [0.0; 3],
        }
    }

    fn turn(&self, [first, second, third]: Coordinates) -> DQuat {
        match self.kind {
            JointKind::Hinge { .. } => DQuat::from_rotation_x(first),
            JointKind::Spherical { .. } => {
                let across = DVec3::new(0.0, second.cos(), second.sin());
                DQuat::from_axis_angle(across, first) * DQuat::from_rotation_x(third)
            }
            _ => DQuat::IDENTITY,
        }
    }
}

struct Tree {
    branches: Vec<Branch>,
    hangs: bool,
}

impl Tree {
    fn draw(dice: &mut Random, is_chain: bool) -> Self {
        let count = 3 + dice.index(6);
        let branches = (0..count).map(|body| {
            let parent = if is_chain { body } else { dice.index(body + 1) };
            let frames = [0; 2].map(|_| (dice.vector(0.5), dice.rotation()));
            let kind = match dice.index(5) {
                0 => JointKind::Fixed,
                1 | 2 => {
                    let (a, b) = (between(dice, -PI, PI) as f32, between(dice, -PI, PI) as f32);
                    JointKind::Hinge { limits: Limits::new(a.min(b), a.max(b)), motor: Default::default() }
                }
                3 => JointKind::SPHERICAL,
                _ => JointKind::Spherical {
                    swing_limit: between(dice, 0.05, PI) as f32,
                    twist_limits: Limits::NONE,
                    motor: SphericalMotor::Off,
                },
            };
            Branch { parent, frames, kind }
        });
        Self { branches: branches.collect(), hangs: dice.unit() < 0.5 }
    }

    /// Poses of all bodies, the root first.
    fn poses(&self, coordinates: &[Coordinates]) -> Vec<(DVec3, DQuat)> {
        let mut poses = vec![(DVec3::ZERO, DQuat::IDENTITY)];
        for (branch, &at) in self.branches.iter().zip(coordinates) {
            let (position, rotation) = poses[branch.parent];
            let [(on_parent, frame), (on_child, child_frame)] = branch.frames;
            let point = position + rotation * on_parent.as_dvec3();
            let turned = (rotation * frame.as_dquat() * branch.turn(at) * child_frame.as_dquat().conjugate()).normalize();
            poses.push((point - turned * on_child.as_dvec3(), turned));
        }
        poses
    }

    /// Where each joint is.
    fn points(&self, coordinates: &[Coordinates]) -> Vec<DVec3> {
        let poses = self.poses(coordinates);
        let point = |branch: &Branch| {
            let (position, rotation) = poses[branch.parent];
            position + rotation * branch.frames[0].0.as_dvec3()
        };
        self.branches.iter().map(point).collect()
    }

    /// The tree in a world of its own, at these coordinates, and its joints.
    fn build(&self, coordinates: &[Coordinates]) -> (World, Vec<JointId>) {
        let mut world = empty_world();
        let mut bodies = Vec::new();
        for (number, (position, rotation)) in self.poses(coordinates).into_iter().enumerate() {
            let is_world = number == 0 && self.hangs;
            bodies.push(if is_world { BodyId::NULL } else { add_body(&mut world, position, rotation) });
        }
        let joints = self.branches.iter().enumerate().map(|(number, branch)| {
            let mut def = JointDef::new(branch.kind, bodies[branch.parent], bodies[number + 1]);
            let [a, b] = branch.frames.map(|(point, frame)| Pose::at(point.as_dvec3()).rotated(frame));
            (def.frame_a, def.frame_b) = (a, b);
            world.create_joint(&def).expect("the joint is valid")
        });
        let joints = joints.collect();
        (world, joints)
    }
}

fn empty_world() -> World {
    // Bounds past fixed joints are derived only where those are joints, not parts of a union.
    let long_range = LongRangeDef { union: false, ..LongRangeDef::default() };
    let def = WorldDef { gravity: Vec3::ZERO, solver: Solver::GaussSeidel, long_range, ..WorldDef::default() };
    World::new(&def).expect("the definition is valid")
}

fn add_body(world: &mut World, position: DVec3, rotation: DQuat) -> BodyId {
    let mut shape = ShapeDef::new(Shape::ball(0.1).expect("the radius is valid"));
    shape.filter.collides_with = 0;
    let pose = Pose::at(position).rotated(rotation.as_quat());
    world.create_body(&BodyDef::dynamic(pose).with_shape(shape).with_mass(Mass::Total(1.0))).expect("the body is valid")
}

fn derived(world: &mut World) -> Vec<BoundState> {
    world.step(1e-6).expect("the step length is valid");
    world.bounds().collect()
}

/// Distances found of two joints: the greatest and the least.
struct Found {
    greatest: f64,
    least: f64,
}

/// Asserts that a bound holds what was found; returns its distance at most over the upper bound.
fn judge(bound: &BoundState, found: &Found) -> Result<f64, TestCaseError> {
    let (upper, lower) = (f64::from(bound.upper), f64::from(bound.lower));
    let slack = TOLERANCE * upper;
    prop_assert!(found.greatest <= upper + slack, "reaches {} m, upper bound {upper} m: {bound:?}", found.greatest);
    prop_assert!(found.least >= lower - slack, "comes as close as {} m, lower bound {lower} m: {bound:?}", found.least);
    Ok(found.greatest / upper)
}

/// Draws poses `draws` times, and climbs from the best towards both extremes `steps` times by ever smaller steps.
fn search(tree: &Tree, ends: [usize; 2], start: &[Coordinates], [draws, steps]: [u32; 2], dice: &mut Random) -> Found {
    let distance = |at: &[Coordinates]| {
        let points = tree.points(at);
        points[ends[0]].distance(points[ends[1]])
    };
    let climb = |sign: f64, dice: &mut Random| {
        let (mut best, mut value) = (start.to_vec(), sign * distance(start));
        for number in 0..draws + steps {
            let mut next = best.clone();
            if number >= draws {
                let changed = dice.index(next.len());
                next[changed] = tree.branches[changed].near(
                    next[changed],
                    (-10.0 * f64::from(number - draws) / f64::from(steps)).exp2(),
                    dice,
                );
            } else if dice.unit() < 0.3 {
                next = tree.branches.iter().map(|branch| branch.draw(dice)).collect();
            } else {
                let changed = dice.index(next.len());
                next[changed] = tree.branches[changed].draw(dice);
            }
            let reached = sign * distance(&next);
            if reached > value {
                (best, value) = (next, reached);
            }
        }
        sign * value
    };
    Found { greatest: climb(1.0, dice), least: climb(-1.0, dice) }
}

fn no_pose_of_a_tree_violates_a_bound(seed: u64, is_chain: bool) -> Result<(), TestCaseError> {
    let mut dice = Random::new(seed);
    let tree = Tree::draw(&mut dice, is_chain);
    let start: Vec<Coordinates> = tree.branches.iter().map(|branch| branch.draw(&mut dice)).collect();
    let (mut world, joints) = tree.build(&start);
    let bounds = derived(&mut world);
    prop_assert!(!bounds.is_empty() || tree.branches.len() < 4 || !is_chain, "a chain of {} has no bound", tree.branches.len());
    for bound in &bounds {
        let place = |joint: JointId| joints.iter().position(|&other| other == joint).expect("a bound is between joints");
        let found = search(&tree, [place(bound.near), place(bound.far)], &start, [60, 0], &mut dice);
        judge(bound, &found)?;
    }
    Ok(())
}

/// A ring of bodies with ball joints in a world of its own: its joint points, and the bounds between them.
fn ring(dice: &mut Random) -> (Vec<DVec3>, Vec<(BoundState, [usize; 2])>) {
    let count = 4 + dice.index(9);
    let points: Vec<DVec3> = (0..count).map(|_| dice.vector(0.5).as_dvec3() * 2.0).collect();
    let mut world = empty_world();
    let middle = |i: usize| (points[i] + points[(i + 1) % count]) * 0.5;
    let bodies: Vec<BodyId> = (0..count).map(|i| add_body(&mut world, middle(i), DQuat::IDENTITY)).collect();
    let joints: Vec<JointId> = (0..count)
        .map(|i| {
            let before = (i + count - 1) % count;
            let on = |body: usize| (points[i] - middle(body)).as_vec3();
            let def = JointDef::new(JointKind::SPHERICAL, bodies[before], bodies[i]).at(on(before), on(i));
            world.create_joint(&def).expect("the joint is valid")
        })
        .collect();
    let place = |joint: JointId| joints.iter().position(|&other| other == joint).expect("a bound is between joints");
    let bounds = derived(&mut world).into_iter().map(|bound| (bound, [place(bound.near), place(bound.far)])).collect();
    (points, bounds)
}

/// Turns an arc of a ring about the line between its ends, which keeps it closed.
fn turn_arc(points: &mut [DVec3], most: f64, dice: &mut Random) {
    let count = points.len();
    let (from, to) = (dice.index(count), dice.index(count));
    let Some(axis) = (points[to] - points[from]).try_normalize() else { return };
    let turn = DQuat::from_axis_angle(axis, between(dice, -most, most));
    let pivot = points[from];
    let mut at = (from + 1) % count;
    while at != to && from != to {
        points[at] = pivot + turn * (points[at] - pivot);
        at = (at + 1) % count;
    }
}

/// A ring of bodies with ball joints, bent by turning one arc after another about the line between its ends: that keeps it closed.
fn no_pose_of_a_loop_violates_a_bound(seed: u64) -> Result<(), TestCaseError> {
    let mut dice = Random::new(seed);
    let (mut points, bounds) = ring(&mut dice);
    prop_assert!(!bounds.is_empty(), "a ring of {} has no bound", points.len());
    let mut found: Vec<Found> = bounds.iter().map(|_| Found { greatest: 0.0, least: f64::INFINITY }).collect();
    for _ in 0..200 {
        for ((_, [near, far]), found) in bounds.iter().zip(&mut found) {
            let distance = points[*near].distance(points[*far]);
            (found.greatest, found.least) = (found.greatest.max(distance), found.least.min(distance));
        }
        turn_arc(&mut points, PI, &mut dice);
    }
    for ((bound, _), found) in bounds.iter().zip(&found) {
        judge(bound, found)?;
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_reachable_pose_of_a_chain_violates_a_bound(seed in any::<u64>()) {
        no_pose_of_a_tree_violates_a_bound(seed, true)?;
    }

    #[test]
    fn no_reachable_pose_of_a_branching_structure_violates_a_bound(seed in any::<u64>()) {
        no_pose_of_a_tree_violates_a_bound(seed, false)?;
    }

    #[test]
    fn no_reachable_pose_of_a_ring_violates_a_bound(seed in any::<u64>()) {
        no_pose_of_a_loop_violates_a_bound(seed)?;
    }
}

/// What bounds leave, as shares of the upper one: of upper bounds beyond the greatest distance found, and of lower ones short of the
/// least, where there is a lower one.
#[derive(Default)]
struct Left {
    upper: Vec<f64>,
    lower: Vec<f64>,
}

impl Left {
    fn note(&mut self, bound: &BoundState, found: &Found) {
        let (upper, lower) = (f64::from(bound.upper), f64::from(bound.lower));
        self.upper.push((upper - found.greatest) / upper);
        if lower > 0.0 {
            self.lower.push((found.least - lower) / upper);
        }
    }

    /// Prints its row of the table in docs/lab/long-range.md; returns the median of upper bounds.
    fn print(mut self, name: &str) -> f64 {
        let at = |left: &mut Vec<f64>, share: f64| {
            left.sort_unstable_by(f64::total_cmp);
            left.get((share * left.len() as f64) as usize).map(|left| 100.0 * left)
        };
        let told =
            |left: &mut Vec<f64>| [0.5, 0.9].map(|share| at(left, share).map_or(String::new(), |left| format!("{left:.2} %")));
        let counts = [self.upper.len(), self.lower.len()];
        let ([upper_half, upper_most], [lower_half, lower_most]) = (told(&mut self.upper), told(&mut self.lower));
        println!("| {name} | {} | {upper_half} | {upper_most} | {} | {lower_half} | {lower_most} |", counts[0], counts[1]);
        at(&mut self.upper, 0.5).unwrap_or(f64::INFINITY)
    }
}

/// Structures of each kind whose bounds are looked at for how tight they are.
const LOOKED_AT: u64 = 750;

fn left_by_trees(is_chain: bool) -> Left {
    let mut left = Left::default();
    for seed in 0..LOOKED_AT {
        let mut dice = Random::new(seed);
        let tree = Tree::draw(&mut dice, is_chain);
        let start: Vec<Coordinates> = tree.branches.iter().map(|branch| branch.draw(&mut dice)).collect();
        let (mut world, joints) = tree.build(&start);
        for bound in derived(&mut world) {
            let ends = [bound.near, bound.far]
                .map(|end| joints.iter().position(|&joint| joint == end).expect("a bound is between joints"));
            left.note(&bound, &search(&tree, ends, &start, [60, 300], &mut dice));
        }
    }
    left
}

fn left_by_rings() -> Left {
    let mut left = Left::default();
    for seed in 0..LOOKED_AT {
        let mut dice = Random::new(seed);
        let (start, bounds) = ring(&mut dice);
        let around: f64 = (0..start.len()).map(|i| start[i].distance(start[(i + 1) % start.len()])).sum();
        // The longer way round says nothing that the shorter one does not say.
        for (bound, [near, far]) in bounds.into_iter().filter(|(bound, _)| 2.0 * f64::from(bound.upper) <= around) {
            let mut climb = |sign: f64| {
                let (mut best, mut value) = (start.clone(), sign * start[near].distance(start[far]));
                for step in 0..300 {
                    let mut next = best.clone();
                    turn_arc(&mut next, PI * (-10.0 * f64::from(step) / 300.0).exp2(), &mut dice);
                    let reached = sign * next[near].distance(next[far]);
                    if reached > value {
                        (best, value) = (next, reached);
                    }
                }
                sign * value
            };
            left.note(&bound, &Found { greatest: climb(1.0), least: climb(-1.0) });
        }
    }
    left
}

#[test]
fn upper_bounds_are_tight() {
    println!(
        "| {LOOKED_AT} of each | upper bounds | median | 90 % | lower bounds | median | 90 % |\n|---|---|---|---|---|---|---|"
    );
    let medians = [("chains", left_by_trees(true)), ("trees", left_by_trees(false)), ("rings", left_by_rings())]
        .map(|(name, left)| left.print(name));
    assert!(medians.iter().all(|&left| left <= 1.0), "half of the upper bounds leave more than {medians:?} %, bound 1 %");
}

/// A chain of unit segments along x that hangs on the world, whose hinges about z may turn by at most `limits` (rad).
fn unit_chain(limits: &[f32]) -> Vec<BoundState> {
    let mut world = empty_world();
    let mut above = (BodyId::NULL, Vec3::ZERO);
    let about_z = Quat::from_rotation_arc(Vec3::X, Vec3::Z);
    for body in 0..=limits.len() {
        let id = add_body(&mut world, DVec3::new(body as f64 + 0.5, 0.0, 0.0), DQuat::IDENTITY);
        let limit = if body == 0 { f32::INFINITY } else { limits[body - 1] };
        let kind = JointKind::Hinge { limits: Limits::new(-limit, limit), motor: Default::default() };
        let mut def = JointDef::new(kind, above.0, id).at(above.1, Vec3::new(-0.5, 0.0, 0.0));
        (def.frame_a.rotation, def.frame_b.rotation) = (about_z, about_z);
        world.create_joint(&def).expect("the joint is valid");
        above = (id, Vec3::new(0.5, 0.0, 0.0));
    }
    derived(&mut world)
}

#[test]
fn ends_that_can_meet_have_no_lower_bound() {
    // Four segments that may turn by 135° at each joint; the joints are at 1, 2, 3 and 4 m.
    let lower: Vec<f32> = unit_chain(&[135.0_f32.to_radians(); 4]).iter().map(|bound| bound.lower).collect();
    assert!((lower[1] - 0.7654).abs() < 1e-4, "two segments: {} m, 0.7654 m by hand", lower[1]);
    assert!(lower[2] == 0.0 && lower[3] == 0.0, "three and four segments can close: {lower:?} m");
}

#[test]
fn a_chain_that_may_hardly_bend_keeps_its_arc() {
    let lower = unit_chain(&[20.0_f32.to_radians(); 4])[3].lower;
    // Four segments on a circle, each turned by 20°: 2 r sin 40° with r = 0.5 / sin 10°.
    let chord = 40.0_f64.to_radians().sin() / 10.0_f64.to_radians().sin();
    assert!((f64::from(lower) - chord).abs() < 1e-4, "{lower} m, the chord of the arc is {chord} m");
}

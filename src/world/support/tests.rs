use glam::{Quat, Vec2, Vec3};

use super::SupportState;
use super::record::Seen;
use crate::joint_graph::support::{NodeKind, SupportGraph, SupportNode, hull};
use crate::{BodyDef, BodyId, JointDef, JointKind, Pose, Shape, ShapeDef, World, WorldDef};

/// A small generator for tests: numbers in 0…1 (xorshift).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f32) as usize).min(n - 1)
    }

    fn between(&mut self, from: f32, to: f32) -> f32 {
        from + (to - from) * self.unit()
    }
}

fn add_box(world: &mut World, random: &mut Random) -> BodyId {
    let half = Vec3::new(random.between(0.2, 0.6), random.between(0.1, 0.4), random.between(0.2, 0.6));
    let place = Pose::at_xyz(random.between(-1.5, 1.5).into(), random.between(0.1, 3.0).into(), random.between(-1.5, 1.5).into());
    let shape = ShapeDef::new(Shape::cuboid(half).unwrap());
    world.create_body(&BodyDef::dynamic(place).with_shape(shape)).unwrap()
}

fn a_random_edit(world: &mut World, bodies: &mut Vec<BodyId>, random: &mut Random) {
    let chosen = random.below(bodies.len().max(1));
    match random.below(8) {
        0 | 1 => bodies.push(add_box(world, random)),
        2 if bodies.len() > 4 => world.destroy_body(bodies.swap_remove(chosen)).unwrap(),
        3 if !bodies.is_empty() => {
            let push = Vec3::new(random.between(-300.0, 300.0), 0.0, random.between(-300.0, 300.0));
            world.add_impulse(bodies[chosen], push).unwrap();
        }
        4 if random.below(4) == 0 => {
            let gravity = Vec3::new(random.between(-4.0, 4.0), -9.0, random.between(-4.0, 4.0));
            world.set_gravity(if random.below(8) == 0 { Vec3::ZERO } else { gravity }).unwrap();
        }
        5 if bodies.len() > 2 => {
            let other = bodies[(chosen + 1) % bodies.len()];
            world
                .create_joint(&JointDef::new(JointKind::SPHERICAL, bodies[chosen], other).at(Vec3::X * 0.6, Vec3::NEG_X * 0.6))
                .unwrap();
        }
        6 => {
            let joint = world.joints().next();
            if let Some(joint) = joint {
                world.destroy_joint(joint).unwrap();
            }
        }
        _ => {}
    }
}

/// Worlds that judge by thrust too.
fn by_thrust() -> WorldDef {
    WorldDef { support: true, support_by_thrust: true, ..WorldDef::default() }
}

/// The analysis made anew from the world as it is, with the words on what slides that the kept one has.
fn made_anew(world: &World) -> SupportState {
    let kept = world.support.as_ref().unwrap();
    let mut fresh = SupportState::new(world.bodies.slot_count(), world.def.support_by_thrust);
    fresh.turn_to(world.def.gravity);
    fresh.records.resize_with(kept.records.len(), Default::default);
    for (record, kept) in fresh.records.iter_mut().zip(&kept.records) {
        record.manifolds.extend(kept.manifolds.iter().map(|&seen| Seen { link: None, ..seen }));
    }
    world.sync_bodies(&mut fresh);
    if let Some(frame) = fresh.frame {
        world.sync_all(&mut fresh, &frame);
        let (ties, anchors) = world.ties(|_| true);
        fresh.graph.set_joints(&ties, &anchors);
        fresh.graph.update();
        if fresh.by_thrust {
            world.judge_thrust(&mut fresh, &frame, true);
        }
    }
    fresh
}

/// How near to the edge of what a body stands on links that are kept may say the other thing than those made anew (m).
fn close_to(node: &SupportNode) -> f32 {
    2e-2 * hull::reach(node.hull()).max(0.1)
}

/// Whether a body below stands on the edge itself, or a point that the body stands on is at the edge of where the one below can carry, or
/// either is so of a body that this one stands on in turn, as many bodies down as `depth` says.
fn stands_on_an_edge(graph: &SupportGraph, node: &SupportNode, depth: u32) -> bool {
    node.below.iter().map(|&link| graph.link(link)).any(|link| {
        let lower = graph.node(link.lower).filter(|lower| lower.kind == NodeKind::Body);
        lower.is_some_and(|lower| {
            let is_near = |&point: &Vec2| hull::margin(lower.hull(), point).abs() < close_to(lower);
            lower.margin.abs() < close_to(lower)
                || link.points[..usize::from(link.count)].iter().any(is_near)
                || (depth > 1 && stands_on_an_edge(graph, lower, depth - 1))
        })
    })
}

/// What a comparison of kept analyses with ones made anew has seen.
#[derive(Debug, Default)]
struct Tally {
    judged: usize,
    supported: usize,
    braced: usize,
    at_rest: usize,
    /// Bodies of which the verdict hung on the last milliradian, and those of which the word on thrust did.
    close: usize,
    close_by_thrust: usize,
}

impl Tally {
    fn compare(&mut self, world: &World, bodies: &[BodyId], context: &str) {
        let anew = made_anew(world);
        let state = world.support.as_ref().unwrap();
        let indices: Vec<u32> = bodies.iter().map(|&body| world.bodies.find(body).unwrap()).collect();
        let mut hulls_agree = true;
        for &index in &indices {
            let (Some(kept), Some(fresh)) = (state.graph.node(index), anew.graph.node(index)) else { continue };
            self.judged += 1;
            self.supported += usize::from(kept.is_supported());
            if kept.is_supported() != fresh.is_supported() {
                // Links follow a body in steps of a milliradian, and of a thousandth of its extent: on the edge that tells.
                let near = |node: &SupportNode| node.margin.abs() < close_to(node);
                let on_edge = |graph: &SupportGraph, unit: u32| {
                    let mut mates = indices.iter().filter_map(|&mate| graph.node(mate)).filter(|mate| mate.unit == unit);
                    mates.any(|mate| near(mate) || stands_on_an_edge(graph, mate, 3))
                };
                let is_close = on_edge(&state.graph, kept.unit) || on_edge(&anew.graph, fresh.unit);
                assert!(is_close, "{context}, body {index}: {kept:?} against {fresh:?}");
                self.close += 1;
                hulls_agree = false;
            }
        }
        for &index in &indices {
            let body = &world.bodies[index];
            let (kept, fresh) = (state.thrust.braces(index), anew.thrust.braces(index));
            self.braced += usize::from(kept);
            self.at_rest += usize::from(kept && (body.held || !body.is_awake()));
            assert!(kept == fresh || !hulls_agree, "{context}, body {index}: braced {kept}, made anew {fresh}");
            self.close_by_thrust += usize::from(kept != fresh);
        }
    }

    fn check(&self) {
        assert!(self.close * 1000 < self.judged && self.close_by_thrust * 1000 < self.judged, "{self:?}");
    }
}

/// A world with ground from −5 m to 5 m at a height of zero.
fn world_on_ground(def: &WorldDef) -> World {
    let mut world = World::new(def).unwrap();
    let ground = Shape::cuboid(Vec3::new(5.0, 0.5, 5.0)).unwrap();
    world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(ShapeDef::new(ground))).unwrap();
    world
}

/// Makes a thousand worlds of boxes, edits them at random, and compares after every few steps.
fn compare_over_edits_of_boxes(def: &WorldDef) -> Tally {
    let mut tally = Tally::default();
    for sequence in 0..1000_u64 {
        let mut random = Random(0x9E37_79B9_7F4A_7C15 ^ ((sequence + 1) * 104_729));
        let mut world = world_on_ground(def);
        let mut bodies = Vec::new();
        (0..5).for_each(|_| bodies.push(add_box(&mut world, &mut random)));
        for _ in 0..12 {
            a_random_edit(&mut world, &mut bodies, &mut random);
            for _ in 0..1 + random.below(12) {
                world.step(1.0 / 60.0).unwrap();
            }
            tally.compare(&world, &bodies, &format!("sequence {sequence}"));
        }
    }
    tally.check();
    let Tally { judged, supported, .. } = tally;
    assert!(judged > 50_000 && supported > judged / 6, "{supported} of {judged} verdicts were for support");
    tally
}

#[test]
fn the_kept_analysis_equals_one_made_anew_over_a_thousand_edit_sequences_of_a_world() {
    let tally = compare_over_edits_of_boxes(&WorldDef { support: true, ..WorldDef::default() });
    assert_eq!(tally.braced, 0);
}

#[test]
fn with_thrust_the_kept_analysis_equals_one_made_anew_over_the_same_sequences() {
    let tally = compare_over_edits_of_boxes(&by_thrust());
    assert!(tally.braced > 10, "{tally:?}");
}

/// Makes pairs of leaning cards, which stand by thrust alone.
fn add_cards(world: &mut World, random: &mut Random) -> Vec<BodyId> {
    let half = Vec3::new(0.05, 0.5, 0.3);
    let mut add = |apex: f32, side: f32| {
        let (sin, cos) = random.between(0.1, 0.35).sin_cos();
        let center = Vec3::new(apex + side * (half.x * cos + half.y * sin), half.x * sin + half.y * cos, 0.0);
        let pose = Pose::at(center.as_dvec3()).rotated(Quat::from_rotation_z(side * sin.asin()));
        world.create_body(&BodyDef::dynamic(pose).with_shape(ShapeDef::new(Shape::cuboid(half).unwrap()))).unwrap()
    };
    [-2.0, 0.0, 2.0].into_iter().flat_map(|apex| [add(apex, -1.0), add(apex, 1.0)]).collect()
}

#[test]
fn the_kept_words_on_leaning_cards_equal_those_made_anew_over_a_thousand_edit_sequences() {
    let mut tally = Tally::default();
    for sequence in 0..1000_u64 {
        let mut random = Random(0x9E37_79B9_7F4A_7C15 ^ ((sequence + 1) * 15_485_863));
        let mut world = world_on_ground(&by_thrust());
        let mut bodies = add_cards(&mut world, &mut random);
        for _ in 0..12 {
            // At times for long enough that cards are held, and fall asleep.
            let longest = if random.below(4) == 0 { 100 } else { 20 };
            for _ in 0..1 + random.below(longest) {
                world.step(1.0 / 60.0).unwrap();
            }
            tally.compare(&world, &bodies, &format!("sequence {sequence}"));
            match random.below(9) {
                0..3 => a_random_edit(&mut world, &mut bodies, &mut random),
                3 if !bodies.is_empty() => {
                    let chosen = bodies[random.below(bodies.len())];
                    world.put_to_sleep(chosen).unwrap();
                }
                4 if !bodies.is_empty() => world.wake(bodies[random.below(bodies.len())]).unwrap(),
                _ => {}
            }
        }
    }
    tally.check();
    assert!(tally.braced > tally.judged / 10 && tally.at_rest > tally.braced / 10, "{tally:?}");
}

#[test]
fn a_world_without_static_contacts_is_not_looked_at() {
    let mut world = world_on_ground(&WorldDef { support: true, ..WorldDef::default() });
    let add = |world: &mut World, y: f64| {
        let shape = ShapeDef::new(Shape::cuboid(Vec3::splat(0.5)).unwrap());
        world.create_body(&BodyDef::dynamic(Pose::at_xyz(0.0, y, 0.0)).with_shape(shape)).unwrap()
    };
    let (lower, upper) = (add(&mut world, 4.0), add(&mut world, 5.0));
    // The lower one is braked, so that the upper one presses it all the way down, for half a second.
    let mut looked_at = None;
    for _ in 0..30 {
        world.add_force(lower, Vec3::Y * 500.0).unwrap();
        world.step(1.0 / 60.0).unwrap();
        let now = world.support.as_ref().unwrap().looked_at;
        assert_eq!(*looked_at.get_or_insert(now), now, "pairs looked at after the first step");
    }
    assert_eq!(world.support(lower).unwrap().verdict, crate::Verdict::NoContact);
    assert_eq!(world.support(upper).unwrap().verdict, crate::Verdict::OnUnsupported);
    let load = world.load_on(lower).unwrap();
    assert!(load > 0.0, "{load} N on the lower box, which is braked");
    for _ in 0..90 {
        world.step(1.0 / 60.0).unwrap();
    }
    assert!(world.support.as_ref().unwrap().looked_at > looked_at.unwrap());
    assert_eq!(world.supported_count().unwrap(), 2, "both have landed");
    assert_eq!(world.support(upper).unwrap().verdict, crate::Verdict::Supported);
}

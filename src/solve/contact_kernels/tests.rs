//! All registers give the same bits.

use glam::{Quat, Vec3};
use proptest::prelude::*;

use super::super::contact::{ContactImpulses, ContactInput, LANES};
use super::super::state::{MotionKind, Symmetric};
use super::*;
use crate::material::PairMaterial;
use crate::platform::with_baseline;

/// Everything that a kernel reads or writes.
#[derive(Debug, Clone)]
struct Scene {
    contacts: ContactBlocks,
    velocities: Vec<BodyVelocity>,
    motions: Vec<BodyMotion>,
}

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from_array)
}

fn body() -> impl Strategy<Value = (BodyVelocity, BodyMotion)> {
    (vector(3.0), vector(5.0), vector(0.01), vector(0.02), 0.01..100.0_f32, 0.01..10.0_f32).prop_map(
        |(linear, angular, displacement, turn, mass, girth)| {
            let rotation = Quat::from_scaled_axis(angular);
            let inertia = crate::shape::inertia_tensor(Vec3::new(1.0, girth, 2.0) / mass, rotation);
            let mass = BodyVelocity::new(Vec3::splat(1.0 / mass), Symmetric::from_mat3(inertia));
            let velocity = BodyVelocity { linear, angular, ..mass };
            (velocity, BodyMotion { displacement, turn, kind: MotionKind::Tumbling, ..BodyMotion::FIXED })
        },
    )
}

fn manifold() -> impl Strategy<Value = ContactInput> {
    let points = prop::array::uniform4((vector(1.0), vector(1.0), -0.01..0.01_f32, -1.0..2.0_f32));
    (vector(1.0), points, 1..=4_usize, 0.0..1.0_f32, 0.0..0.1_f32, 0.0..1.0_f32, vector(1.0)).prop_map(
        |(normal, points, count, friction, rolling, restitution, tangential)| ContactInput {
            a: 0,
            b: 0,
            normal: normal.try_normalize().unwrap_or(Vec3::Y),
            lever_a: points.map(|point| point.0),
            lever_b: points.map(|point| point.1),
            separation: points.map(|point| point.2),
            touching: 1.0e-3,
            count,
            material: PairMaterial { friction, restitution, rolling, spinning: if rolling > 0.05 { 0.01 } else { 0.0 } },
            impulses: ContactImpulses {
                normal: points.map(|point| point.3.max(0.0)),
                friction: tangential,
                twist: 0.1,
                rolling: tangential * 0.1,
            },
        },
    )
}

type Body = (BodyVelocity, BodyMotion);

/// What may lie in a lane: a manifold, its bodies, and whether the first of these is the world.
fn lane() -> impl Strategy<Value = (ContactInput, Body, Body, bool)> {
    (manifold(), body(), body(), any::<bool>())
}

/// A block in which some lanes are empty or stand on the world; half of them of materials that need nothing beside it.
fn scene() -> impl Strategy<Value = Scene> {
    let lanes = prop::collection::vec(lane(), 0..=LANES);
    (lanes, any::<bool>(), any::<bool>()).prop_map(|(mut lanes, single, plain)| {
        for (input, ..) in lanes.iter_mut().filter(|_| plain) {
            input.material = PairMaterial { restitution: 0.0, rolling: 0.0, spinning: 0.0, ..input.material };
        }
        let mut contacts = ContactBlocks::default();
        contacts.begin(1, usize::from(!single));
        contacts.lay_out(0..1, 0, !single, 0);
        contacts.add_extras(lanes.iter().filter(|(input, ..)| !input.is_plain()).map(|_| 0));
        let (mut velocities, mut motions) = (vec![BodyVelocity::FIXED], vec![BodyMotion::FIXED]);
        for (l, (mut input, a, b, on_world)) in lanes.into_iter().enumerate() {
            let mut enlist = |(velocity, motion)| {
                velocities.push(velocity);
                motions.push(motion);
                velocities.len() as u32 - 1
            };
            input.a = if on_world { 0 } else { enlist(a) };
            input.b = enlist(b);
            input.count = if single { 1 } else { input.count };
            contacts.whole(0).set_lane(l, &input, 1.0e-3);
        }
        Scene { contacts, velocities, motions }
    })
}

fn numbers(bodies: &[BodyVelocity]) -> Vec<[[u32; 8]; 2]> {
    bodies.iter().map(|body| body.halves().map(|half| half.map(f32::to_bits))).collect()
}

fn run(scene: &Scene) -> Vec<u32> {
    let Scene { mut contacts, mut velocities, motions } = scene.clone();
    let moving = velocities.len() - 1;
    set_masses(&mut contacts.whole(0), &velocities);
    warm_start(&mut contacts.all(), &mut DisjointMut::alone(&mut velocities, moving), &motions, 0.004, 0.006);
    let mut anew = (contacts.clone(), velocities.clone());
    sweep(&mut contacts.all(), &mut DisjointMut::alone(&mut velocities, moving), false, false);
    if contacts.extras.is_empty() {
        (0..anew.0.room_of(0)).for_each(|i| anew.0.rows_mut(0, i).closing_speed = [9.0; LANES]);
        sweep_anew(&mut anew.0.all(), &mut DisjointMut::alone(&mut anew.1, moving), &motions, 0.004, false);
        assert_eq!(numbers(&anew.1), numbers(&velocities), "closing speeds formed in the sweep, and before it");
    }
    sweep(&mut contacts.all(), &mut DisjointMut::alone(&mut velocities, moving), true, true);
    sweep_anew(&mut contacts.all(), &mut DisjointMut::alone(&mut velocities, moving), &motions, 0.004, false);
    restitute(&mut contacts, &mut velocities, 0.1);
    let mut at_once = (contacts.clone(), velocities.iter().map(BodyVelocity::at_rest).collect::<Vec<_>>());
    let worst = end_step(&mut contacts.all(), &motions);
    let mut pushes: Vec<_> = velocities.iter().map(BodyVelocity::at_rest).collect();
    recover(&mut contacts.all(), &mut DisjointMut::alone(&mut pushes, moving), 0.016);
    let deepest = begin_recovery(&mut at_once.0.all(), &motions, &mut DisjointMut::alone(&mut at_once.1, moving), 0.016);
    assert_eq!((deepest.to_bits(), numbers(&at_once.1)), (worst.to_bits(), numbers(&pushes)), "at once, and one after the other");
    let limits = StatusThresholds { up: Vec3::Y, rise: 0.3, slips: [0.5, 1.0], speeds: [1.0, 3.0], reserve: 0.9 };
    let mut told = Vec::new();
    tell(&mut contacts, &velocities, &limits, &mut told);

    let block = &contacts.blocks[0];
    let points = (0..contacts.room_of(0)).map(|i| contacts.rows(0, i));
    let points = points.flat_map(|rows| [&rows.lambda, &rows.closing_speed, &rows.inverse_diagonal]);
    let faces = contacts.faces.iter().flat_map(|face| face.diagonal.iter().chain(&face.inverse).chain(&face.coupling));
    let extras = contacts.extras.iter().flat_map(|extra| extra.rolling_lambda.iter().chain(&extra.impact_speed));
    let rows = points.chain(&block.tangent_lambda).chain(extras);
    let masses = faces.chain(&block.tangent_mass);
    let worst = [worst; LANES];
    let twist = contacts.twist_of(0).into_iter().flat_map(|twist| [&twist.mass, &twist.lambda]);
    let lanes = rows.chain(masses).chain(twist).chain([&worst]).flatten();
    let bodies = velocities.iter().chain(&pushes).flat_map(|body| body.halves().into_iter().flatten());
    let told = told.iter().flatten().map(|told| u32::from(told.bits()));
    lanes.chain(bodies).map(|x| x.to_bits()).chain(told).collect()
}

proptest! {
    #[test]
    fn all_registers_give_the_same_bits(scene in scene()) {
        prop_assert_eq!(run(&scene), with_baseline(|| run(&scene)));
    }
}

proptest! {
    #[test]
    fn a_block_never_pulls_and_stays_finite(scene in scene()) {
        let Scene { mut contacts, mut velocities, motions } = scene;
        set_masses(&mut contacts.whole(0), &velocities);
        let mut hand = DisjointMut::alone(&mut velocities, motions.len() - 1);
        warm_start(&mut contacts.all(), &mut hand, &motions, 0.004, 0.002);
        sweep(&mut contacts.all(), &mut hand, false, true);
        let lambdas = (0..contacts.room_of(0)).flat_map(|i| contacts.rows(0, i).lambda);
        let least = lambdas.fold(0.0_f32, f32::min);
        prop_assert!(least >= 0.0, "a point pulls with {least} N·s");
        prop_assert!(velocities.iter().all(|body| body.linear.is_finite() && body.angular.is_finite()));
    }
}

/// Multipliers of a manifold of this material and velocities of its bodies after a sweep to and fro, with others in the block beside it.
fn swept_beside(own: &(ContactInput, Body, Body, bool), others: &[(ContactInput, Body, Body, bool)]) -> Vec<u32> {
    let mut contacts = ContactBlocks::default();
    contacts.begin(1, 1);
    contacts.lay_out(0..1, 0, true, 0);
    let (mut velocities, mut motions) = (vec![BodyVelocity::FIXED], vec![BodyMotion::FIXED]);
    for (l, (input, a, b, on_world)) in std::iter::once(own).chain(others).enumerate() {
        let mut enlist = |(velocity, motion): Body| {
            velocities.push(velocity);
            motions.push(motion);
            velocities.len() as u32 - 1
        };
        let slots = [if *on_world { 0 } else { enlist(*a) }, enlist(*b)];
        let material = PairMaterial { restitution: 0.0, rolling: 0.0, spinning: 0.0, ..input.material };
        contacts.whole(0).set_lane(l, &ContactInput { a: slots[0], b: slots[1], material, ..*input }, 1.0e-3);
    }
    let count = if own.3 { 2 } else { 3 };
    set_masses(&mut contacts.whole(0), &velocities);
    let mut hand = DisjointMut::alone(&mut velocities, motions.len() - 1);
    warm_start(&mut contacts.all(), &mut hand, &motions, 0.004, 0.002);
    sweep(&mut contacts.all(), &mut hand, false, false);
    sweep(&mut contacts.all(), &mut hand, true, true);
    let points = (0..contacts.room_of(0)).map(|i| contacts.rows(0, i).lambda[0]);
    let multipliers = points.chain(contacts.blocks[0].tangent_lambda.map(|lane| lane[0])).map(f32::to_bits);
    multipliers.chain(numbers(&velocities[..count]).into_iter().flatten().flatten()).collect()
}

proptest! {
    #[test]
    fn a_manifold_is_solved_to_the_same_bits_whatever_is_in_its_block(
        own in lane(), others in prop::collection::vec(lane(), 0..LANES),
    ) {
        prop_assert_eq!(swept_beside(&own, &others), swept_beside(&own, &[]));
    }
}

#[test]
fn a_box_on_an_incline_is_told_by_its_slip_its_friction_and_its_slope() {
    let limits = StatusThresholds { up: Vec3::Y, rise: 0.3, slips: [0.1, 0.5], speeds: [0.4, 2.0], reserve: 0.99 };
    let material = PairMaterial { friction: 0.5, restitution: 0.0, rolling: 0.0, spinning: 0.0 };
    let tell = |normal: Vec3, friction: f32, velocity: Vec3, angular: Vec3| {
        let tangent = crate::solve::contact::tangents(normal).0;
        let impulses =
            ContactImpulses { normal: [1.0, 1.0, 0.0, 0.0], friction: tangent * friction, ..ContactImpulses::default() };
        let input = ContactInput {
            a: 0,
            b: 1,
            normal,
            lever_a: [Vec3::ZERO; 4],
            lever_b: [normal * -0.5; 4],
            separation: [0.0; 4],
            touching: 1.0e-3,
            count: 2,
            material,
            impulses,
        };
        let mut contacts = ContactBlocks::default();
        contacts.begin(1, 1);
        contacts.lay_out(0..1, 0, true, 0);
        contacts.whole(0).set_lane(0, &input, 1.0e-3);
        let body = BodyVelocity { linear: velocity, angular, ..BodyVelocity::FIXED };
        let mut told = Vec::new();
        super::tell(&mut contacts, &[BodyVelocity::FIXED, body], &limits, &mut told);
        told[0][0]
    };
    let words =
        |told: ContactStatus| [told.slips_less(0), told.slips_less(1), told.is_slower(0), told.is_slower(1), told.has_reserve()];
    assert_eq!(words(tell(Vec3::Y, 0.9, Vec3::ZERO, Vec3::ZERO)), [true; 5], "at rest");
    assert_eq!(words(tell(Vec3::Y, 1.0, Vec3::X * 0.3, Vec3::ZERO)), [false, true, true, true, false], "slips at its limit");
    assert_eq!(words(tell(Vec3::Y, 0.9, Vec3::Y * 1.0, Vec3::ZERO)), [true, true, false, true, true], "leaves");
    // v = ω × r, with r from the contact to the centre.
    assert_eq!(words(tell(Vec3::Y, 0.9, Vec3::X, Vec3::Z * -2.0)), [true; 5], "rolls");
    let rise = |normal: Vec3| tell(normal, 0.0, Vec3::ZERO, Vec3::ZERO).rise();
    let steep = Vec3::new(0.98, 0.2, 0.0).normalize();
    assert!(rise(Vec3::Y) != rise(Vec3::NEG_Y) && rise(steep) == rise(-steep) && rise(steep) != rise(Vec3::Y));
}

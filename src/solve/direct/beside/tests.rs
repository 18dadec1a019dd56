use glam::{DMat3, DVec3};

use super::*;
use crate::linalg::noise::Noise;
use crate::solve::direct::contact_rows::RowAnchor;
use crate::solve::direct::redundancy::Regularization;
use crate::solve::direct::system::{CONTACT_PASSES, System};
use crate::solve::direct::topology::Coupling;
use crate::solve::joint::rows::Rate;
use crate::solve::state::{BodyMotion, BodyVelocity, MotionKind};

/// Bodies of a chain; one more rides on it, and a last one does not move.
const BODIES: u32 = 6;

fn vector(noise: &mut Noise) -> DVec3 {
    DVec3::new(noise.next(), noise.next(), noise.next())
}

/// Nodes that share a moving body are coupled; `count` of them are in the factor.
fn topology(nodes: &[SystemNode], count: usize) -> Topology {
    let shared = |a: usize, b: usize| {
        let sides = (0..2).flat_map(|i| (0..2).map(move |j| [i, j]));
        sides.filter(|&[i, j]| nodes[a].bodies[i] == nodes[b].bodies[j] && nodes[a].bodies[i] <= BODIES).collect::<Vec<_>>()
    };
    let all = || (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b)));
    let pairs: Vec<(u32, u32)> = all().filter(|&(a, b)| !shared(a, b).is_empty()).map(|(a, b)| (a as u32, b as u32)).collect();
    let rows: Vec<u32> = nodes[..count].iter().map(|node| node.last - node.first).collect();
    let plan = BlockLayout::new(&rows, &rows, &pairs, u64::MAX).expect("no limit is set");
    let mut couplings = Vec::new();
    for (a, b) in all() {
        for [i, j] in shared(a, b) {
            let (start, b_is_late) = plan.block(a as u32, b as u32).expect("the two are coupled");
            let ((late, late_side), (early, early_side)) = if b_is_late { ((b, j), (a, i)) } else { ((a, i), (b, j)) };
            couplings.push(Coupling {
                late: late as u32,
                early: early as u32,
                late_side: late_side as u8,
                early_side: early_side as u8,
                body: nodes[a].bodies[i],
                start,
            });
        }
    }
    Topology { plan, couplings, regularizations: Regularization::all(count, 0), loops: 0, doubled: false }
}

/// A chain that something lies on and that lies on something, with random rows, and what its bodies do.
fn chain(noise: &mut Noise, friction: f64) -> (System, Vec<DirectBody>, Vec<Rate>) {
    let (mut system, mut bodies, mut rates) = (System::default(), Vec::new(), Vec::new());
    for slot in 0..=BODIES + 1 {
        let kind = if slot <= BODIES { MotionKind::Tumbling } else { BodyMotion::FIXED.kind };
        let mut body = DirectBody::new(slot, &BodyVelocity::FIXED, &BodyMotion { kind, ..BodyMotion::FIXED });
        if slot <= BODIES {
            body.inverse_mass = DVec3::splat(0.6 + noise.next());
            body.inverse_inertia = DMat3::from_diagonal(DVec3::splat(0.7) + 0.5 * vector(noise));
        }
        bodies.push(body);
        rates.push(if slot <= BODIES {
            Rate { linear: vector(noise), angular: vector(noise) }
        } else {
            Rate { linear: DVec3::ZERO, angular: DVec3::ZERO }
        });
    }
    for number in 0..BODIES - 1 {
        let first = system.rows.len() as u32;
        for _ in 0..3 {
            let mut pair = || [vector(noise), vector(noise)];
            let (linear, angular) = (pair(), pair());
            system.rows.push(Row { linear, angular, bias: 0.1 * noise.next(), ..Row::EMPTY });
        }
        system.nodes.push(SystemNode { bodies: [number, number + 1], first, last: first + 3 });
    }
    for (own, other) in [(1, BODIES), (4, BODIES), (2, BODIES + 1)] {
        let first = system.rows.len() as u32;
        system.nodes.push(SystemNode { bodies: [own, other], first, last: first });
        system.begin_contact(friction, 0.1 * friction);
        let anchor = |noise: &mut Noise| {
            let opposite = vector(noise);
            RowAnchor { side: 0, lever: vector(noise), opposite: (other == BODIES).then_some(opposite) }
        };
        for _ in 0..3 {
            let grip = anchor(noise);
            system.add_normal(&grip, DVec3::Y, 0.1 * noise.next().max(0.0), noise.next().max(0.0));
        }
        let grip = anchor(noise);
        system.add_friction(&grip, [(DVec3::X, 0.0, 0.0), (DVec3::Z, 0.0, 0.0)], (DVec3::Y, 0.0, 0.0));
    }
    system.begin(&bodies);
    (system, bodies, rates)
}

#[test]
fn contacts_beside_a_factor_do_as_they_do_in_one() {
    let (mut settled, mut pressing, mut sliding) = (0, 0, 0);
    for seed in 1..60 {
        for friction in [0.0, 0.3, 1.0e3] {
            let [beside, inside] = [true, false].map(|is_beside| {
                let (mut system, bodies, mut rates) = chain(&mut Noise(seed), friction);
                system.beside.is_on = is_beside;
                system.settled = true;
                let count = if is_beside { BODIES as usize - 1 } else { system.nodes.len() };
                system.solve(&topology(&system.nodes, count), &bodies, &mut rates, CONTACT_PASSES);
                (system, rates)
            });
            if !(beside.0.settled && inside.0.settled) {
                continue;
            }
            settled += 1;
            let slides = |contact: &ContactRows| {
                let first = (contact.first + contact.normals) as usize;
                beside.0.rows[first..first + 3].iter().any(|row| row.state == RowState::High)
            };
            let slide = beside.0.contacts.iter().filter(|contact| slides(contact)).count();
            // Friction that slides is found to a hundredth of its cone, and its last change acts beside the factor alone; others answer to that by
            // several times as much.
            let bound = if slide > 0 && friction > 0.0 { 0.1 } else { 1.0e-6 };
            sliding += slide;
            for (row, other) in beside.0.rows.iter().zip(&inside.0.rows) {
                let apart = (row.impulse - other.impulse).abs();
                let states = [row.state, other.state];
                assert!(
                    apart < bound,
                    "seed {seed}, friction {friction}, {slide} slide: a multiplier is {} for {}, {states:?}",
                    row.impulse,
                    other.impulse
                );
                pressing += usize::from(row.is_stop() && row.impulse > 0.0);
            }
            for (body, (rate, other)) in beside.1.iter().zip(&inside.1).enumerate() {
                let apart = (rate.linear - other.linear).length().max((rate.angular - other.angular).length());
                assert!(
                    apart < bound,
                    "seed {seed}, friction {friction}: body {body} is {apart:e} m/s from where it is by one factor"
                );
            }
        }
    }
    assert!(settled > 150 && pressing > 100 && sliding > 50, "{settled} of 177 settled, {pressing} press, {sliding} slide");
}

use glam::{DMat3, DVec3};

use super::*;
use crate::id::WorldTag;
use crate::linalg::factor::BlockLayout;
use crate::solve::direct::noise::Noise;
use crate::solve::direct::project::Errors;
use crate::solve::direct::redundancy::Regularization;
use crate::solve::direct::row::RowState;
use crate::solve::direct::topology::{Coupling, SystemNode};
use crate::solve::state::{BodyMotion, MotionKind};

fn vector(noise: &mut Noise) -> DVec3 {
    DVec3::new(noise.next(), noise.next(), noise.next())
}

/// A chain of six bodies with random rows, of which some take no part.
fn articulation(noise: &mut Noise) -> Articulation {
    const COUNTS: [u32; 5] = [3, 7, 5, 1, 6];
    let mut own = Articulation::default();
    for slot in 0..6 {
        let motion = BodyMotion { kind: MotionKind::Tumbling, ..BodyMotion::FIXED };
        let mut body = DirectBody::new(slot, &BodyVelocity::FIXED, &motion);
        body.inverse_mass = DVec3::splat(0.6 + noise.next());
        body.inverse_inertia = DMat3::from_diagonal(DVec3::splat(0.7) + 0.5 * vector(noise));
        own.bodies.push(body);
        own.rates.push(Rate { linear: vector(noise), angular: vector(noise) });
    }
    for (number, count) in (0..).zip(COUNTS) {
        let first = own.system.rows.len() as u32;
        for _ in 0..count {
            let state = if noise.next() < -0.3 { RowState::Absent } else { RowState::Free };
            let (linear, angular) = ([vector(noise), vector(noise)], [vector(noise), vector(noise)]);
            own.system.rows.push(Row { linear, angular, bias: noise.next(), gamma: 0.01, state, ..Row::EMPTY });
        }
        own.system.nodes.push(SystemNode { bodies: [number, number + 1], first, last: own.system.rows.len() as u32 });
    }
    let plan = BlockLayout::new(&COUNTS, &COUNTS, &[(0, 1), (1, 2), (2, 3), (3, 4)], u64::MAX).expect("no limit is set");
    let coupling = |a: u32| {
        let (start, b_is_late) = plan.block(a, a + 1).expect("neighbours are coupled");
        let (late, early) = if b_is_late { (a + 1, a) } else { (a, a + 1) };
        let side = |node: u32| u8::from(node == a);
        Coupling { late, early, late_side: side(late), early_side: side(early), body: a + 1, start }
    };
    let couplings = (0..4).map(coupling).collect();
    own.topology = Topology { plan, couplings, regularizations: Regularization::all(2, 0), loops: 0, doubled: false };
    own.system.begin(&own.bodies);
    own
}

#[test]
fn each_lane_is_solved_as_its_member_is_alone() {
    let mut noise = Noise(5);
    let mut members: Vec<Articulation> = (0..3).map(|_| articulation(&mut noise)).collect();
    let mut group = ArticulationBatch { members: vec![0, 1, 2], ..ArticulationBatch::default() };
    let lanes = [true, true, false, false];
    group.take_in(&mut members[..], lanes);
    for (lane, own) in members.iter().enumerate() {
        for (into, rate) in group.interleaved.rates.iter_mut().zip(&own.rates) {
            let numbers = rate.linear.to_array().into_iter().chain(rate.angular.to_array());
            into.iter_mut().zip(numbers).for_each(|(into, number)| into[lane] = number);
        }
    }
    let before: Vec<Rate> = group.interleaved.rates.iter().map(|rate| rate_of(rate, 2)).collect();
    group.solve(&members[..], lanes);
    assert!(!group.is_exact[2], "who has not been solved is not known to need no refinement");
    for (lane, own) in members.iter_mut().enumerate().take(2) {
        own.system.solve(&own.topology, &own.bodies, &mut own.rates, PASSES);
        let impulses: Vec<f64> = own.system.rows.iter().map(|row| row.impulse).collect();
        group.give_impulses(lane, &mut own.system);
        for (row, impulse) in own.system.rows.iter().zip(impulses) {
            assert!((row.impulse - impulse).abs() < 1e-10, "a multiplier of lane {lane} is {} alone {impulse}", row.impulse);
        }
        for (body, rate) in own.rates.iter().enumerate() {
            let beside = rate_of(&group.interleaved.rates[body], lane);
            let apart = (beside.linear - rate.linear).length().max((beside.angular - rate.angular).length());
            assert!(apart < 1e-10, "body {body} of lane {lane} is {apart:e} from what it does alone");
        }
    }
    let after = group.interleaved.rates.iter().map(|rate| rate_of(rate, 2));
    assert!(after.zip(&before).all(|(after, before)| (after.linear, after.angular) == (before.linear, before.angular)));
}

/// Three of them with three stops each, of which some are taken to press.
fn limbs(noise: &mut Noise) -> Vec<Articulation> {
    let mut members: Vec<Articulation> = (0..3).map(|_| articulation(noise)).collect();
    for own in &mut members {
        for node in [1, 2, 4] {
            let stop = &mut own.system.rows[own.system.nodes[node].last as usize - 1];
            (stop.min, stop.gamma) = (0.0, 0.0);
            stop.state = if noise.next() < 0.0 { RowState::Low } else { RowState::Free };
        }
        own.system.begin(&own.bodies);
    }
    members
}

#[test]
fn stops_that_press_or_part_beside_a_factor_do_as_they_do_in_one() {
    let mut changes = [0; 2];
    for seed in 1..30 {
        let [mut members, mut apart] = [0; 2].map(|_| limbs(&mut Noise(seed)));
        let mut noise = Noise(seed + 100);
        let mut group = ArticulationBatch { members: vec![0, 1, 2], ..ArticulationBatch::default() };
        let lanes = [true, true, true, false];
        for (sweep, changes) in changes.iter_mut().enumerate() {
            group.take_in(&mut members[..], lanes);
            for lane in 0..3 {
                let (own, alone) = (&mut members[lane], &mut apart[lane]);
                for (body, into) in group.interleaved.rates.iter_mut().enumerate() {
                    // Contacts push between two sweeps.
                    own.rates[body].linear += vector(&mut noise);
                    alone.rates[body] = own.rates[body];
                    let rate = own.rates[body];
                    let numbers = rate.linear.to_array().into_iter().chain(rate.angular.to_array());
                    into.iter_mut().zip(numbers).for_each(|(into, number)| into[lane] = number);
                }
                match sweep {
                    0 => _ = alone.system.solve(&alone.topology, &alone.bodies, &mut alone.rates, PASSES),
                    _ => alone.system.sweep(&alone.topology, &alone.bodies, &mut alone.rates),
                }
                alone.system.has_pushed = true;
            }
            group.solve(&members[..], lanes);
            group.give_rates(&mut members[..], lanes);
            let unsettled = group.change_stops(&mut members[..], lanes);
            assert_eq!(unsettled, [false; ABREAST], "seed {seed}");
            for (lane, (own, alone)) in members.iter().zip(&apart).enumerate() {
                *changes += usize::from(!group.changed[lane].is_empty());
                for (row, other) in own.system.rows.iter().zip(&alone.system.rows) {
                    let off = (row.impulse - other.impulse).abs();
                    assert!(off < 1e-7 && row.state == other.state, "seed {seed}, sweep {sweep}, lane {lane}: {row:?} {other:?}");
                }
                for (rate, other) in own.rates.iter().zip(&alone.rates) {
                    let off = (rate.linear - other.linear).length().max((rate.angular - other.angular).length());
                    assert!(off < 1e-7, "seed {seed}, sweep {sweep}, lane {lane}: a body is {off:e} from what it does alone");
                }
            }
        }
    }
    assert!(changes.iter().all(|&changes| changes > 20), "{changes:?}");
}

#[test]
fn joints_yield_to_pushes_beside_others_as_they_do_alone() {
    let mut noise = Noise(7);
    let mut members: Vec<Articulation> = (0..3).map(|_| articulation(&mut noise)).collect();
    let mut pushes = Vec::new();
    for (number, own) in (0..).zip(&mut members) {
        own.built.resize(own.bodies.len(), glam::Vec3::ZERO);
        own.system.rows.iter_mut().for_each(|row| row.gamma = 0.0);
        for body in &mut own.bodies {
            body.slot += 6 * number;
            let (linear, angular) = match number {
                2 => Default::default(),
                _ => (vector(&mut noise).as_vec3(), vector(&mut noise).as_vec3()),
            };
            pushes.push(BodyVelocity { linear, angular, ..BodyVelocity::FIXED });
        }
    }
    let asked = pushes.clone();
    let mut group = ArticulationBatch { members: vec![0, 1, 2], ..ArticulationBatch::default() };
    group.take_in(&mut members[..], [true; ABREAST]);
    group.yield_to(&mut members[..], &mut pushes[..]);
    for own in &mut members {
        let rates = |pushes: &[BodyVelocity]| -> Vec<Rate> {
            own.bodies.iter().map(|body| Rate::of(&pushes[body.slot as usize])).collect()
        };
        let (before, after) = (rates(&asked), rates(&pushes));
        let weighed = |a: &[Rate], b: &[Rate]| -> f64 {
            let of = |body: &DirectBody, a: &Rate, b: &Rate| {
                a.linear.dot(b.linear / body.inverse_mass) + a.angular.dot(body.inverse_inertia.inverse() * b.angular)
            };
            own.bodies.iter().zip(a).zip(b).map(|((body, a), b)| of(body, a, b)).sum()
        };
        let change = |(a, b): (&Rate, &Rate)| Rate { linear: a.linear - b.linear, angular: a.angular - b.angular };
        let change: Vec<Rate> = before.iter().zip(&after).map(change).collect();
        let apart = weighed(&before, &before) - weighed(&after, &after) - weighed(&change, &change);
        assert!(apart.abs() < 1e-4, "the change is not the least in the metric of the masses: {apart:e}");
        for node in &own.system.nodes {
            let pair = node.bodies.map(|body| after[body as usize]);
            for row in own.system.rows[node.first as usize..node.last as usize].iter().filter(|row| row.state == RowState::Free) {
                assert!(row.rate(&pair).abs() < 1e-5, "a joint opens by {}", row.rate(&pair));
            }
        }
        let mut alone = asked.clone();
        own.system.is_abreast = false;
        own.system.is_factored = false;
        own.system.solve(&own.topology, &own.bodies, &mut own.rates, PASSES);
        own.yield_to(&mut alone[..]);
        for body in &own.bodies {
            let (beside, alone) = (pushes[body.slot as usize], alone[body.slot as usize]);
            let apart = (beside.linear - alone.linear).length().max((beside.angular - alone.angular).length());
            assert!(apart < 1e-6, "body {} is pushed {apart:e} from what it is alone", body.slot);
        }
    }
}

#[test]
fn who_mends_positions_between_substeps_leaves_others_their_multipliers() {
    let mut noise = Noise(6);
    let mut members: Vec<Articulation> = (0..2).map(|_| articulation(&mut noise)).collect();
    let mut group = ArticulationBatch { members: vec![0, 1], ..ArticulationBatch::default() };
    let lanes = [true, true, false, false];
    group.take_in(&mut members[..], lanes);
    group.solve(&members[..], lanes);
    let carried =
        |group: &ArticulationBatch| -> Vec<f64> { group.interleaved.impulse.iter().map(|impulse| impulse[1]).collect() };
    let before = carried(&group);
    let tag = WorldTag::acquire().expect("a test has few worlds");
    let mut settling = [Some(Settling { errors: Errors { worst: 1.0, ..Errors::NONE }, mends: true }), None, None, None];
    group.mend(&mut members[..], &Pool::new(&tag), &mut settling, false);
    assert!(settling[0].is_some_and(|settling| !settling.mends && settling.errors.worst < 1.0), "{settling:?}");
    assert!(before.iter().any(|&impulse| impulse != 0.0));
    assert_eq!(carried(&group), before, "multipliers of the one beside it");
}

//! All registers give the same bits, and lanes what bodies do that are moved one by one.

use glam::{DVec3, Quat, Vec3};
use proptest::prelude::*;

use super::*;
use crate::platform::with_baseline;
use crate::solve::state::{Constraints, Symmetric};

const H: f32 = 1.0 / 240.0;

type Bodies = (Vec<BodyVelocity>, Vec<BodyMotion>);

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from_array)
}

fn body(spin: f32) -> impl Strategy<Value = (BodyVelocity, BodyMotion)> {
    (vector(3.0), vector(spin), vector(2.0), vector(2.0), 0.1..10.0_f32, 0.1..3.0_f32, any::<bool>()).prop_map(
        |(linear, angular, turned, tilt, mass, girth, is_round)| {
            let inertia = if is_round { Vec3::ONE } else { Vec3::new(1.0, girth, 1.2) } * mass * 0.1;
            let (rotation, inertia_frame) = (Quat::from_scaled_axis(turned), Quat::from_scaled_axis(tilt));
            let inverse = crate::shape::inertia_tensor(1.0 / inertia, rotation * inertia_frame);
            let at_rest = BodyVelocity::new(Vec3::splat(1.0 / mass), Symmetric::from_mat3(inverse));
            let motion = BodyMotion {
                rotation,
                inertia,
                inertia_frame,
                acceleration: linear * 3.0,
                torque: angular * 0.01,
                linear_damping: girth * 0.1,
                angular_damping: girth * 0.2,
                kind: if is_round { MotionKind::Round } else { MotionKind::Tumbling },
                jointed: true,
                constraints: Constraints::Holding,
                ..BodyMotion::FIXED
            };
            (BodyVelocity { linear, angular, ..at_rest }, motion)
        },
    )
}

fn bodies(spin: f32) -> impl Strategy<Value = Bodies> {
    prop::collection::vec(body(spin), 1..20).prop_map(|bodies| {
        let (mut velocities, mut motions) = (vec![BodyVelocity::FIXED], vec![BodyMotion::FIXED]);
        velocities.extend(bodies.iter().map(|body| body.0));
        motions.extend(bodies.iter().map(|body| body.1));
        (velocities, motions)
    })
}

/// Slow and fast ones: the latter turn by more than a radian in a substep.
fn any_bodies() -> impl Strategy<Value = Bodies> {
    prop_oneof![bodies(0.01), bodies(5.0), bodies(300.0)]
}

/// A substep's kernels; what they leave behind, and which bodies they refused.
fn run((velocities, motions): &Bodies) -> (Bodies, Vec<PredictedPose>, Vec<u32>) {
    let (mut velocities, mut motions, mut poses) = (velocities.clone(), motions.clone(), WideBodies::default());
    poses.lay_out(&Workers::default(), (&velocities, &mut motions), &[], H);
    poses.apply_forces(&Workers::default(), &mut velocities, &motions, H);
    poses.limit_speeds(&Workers::default(), &mut velocities);
    poses.predict(&Workers::default(), &velocities, &motions, H);
    let moving = motions.len() - 1;
    poses.advance(&Workers::default(), (&mut velocities, &mut motions, moving), H);
    ((velocities, motions), poses.predicted_poses, poses.refused)
}

fn bits(((velocities, motions), predicted_poses, refused): (Bodies, Vec<PredictedPose>, Vec<u32>)) -> Vec<u32> {
    let bodies = velocities.iter().flat_map(BodyVelocity::halves).chain(motions.iter().flat_map(BodyMotion::halves));
    bodies.chain(predicted_poses.iter().flat_map(PredictedPose::halves)).flatten().map(|x| x.to_bits()).chain(refused).collect()
}

proptest! {
    #[test]
    fn all_registers_give_the_same_bits(bodies in any_bodies()) {
        prop_assert_eq!(bits(run(&bodies)), with_baseline(|| bits(run(&bodies))));
    }
}

/// Greatest difference of two vectors as a share of the second, or where that is short, of `least`.
fn share(own: Vec3, other: Vec3, least: f32) -> f32 {
    (own - other).length() / other.length().max(least)
}

proptest! {
    #[test]
    fn lanes_do_what_bodies_do_that_are_moved_one_by_one(bodies in any_bodies()) {
        let (mut velocities, mut motions) = bodies.clone();
        let mut predicted_poses = Vec::new();
        for (velocity, motion) in velocities.iter_mut().zip(&mut motions) {
            integrate::apply_forces(velocity, motion, H);
            integrate::limit_speeds(velocity, motion);
            predicted_poses.push(PredictedPose::of(velocity, motion, H));
            integrate::advance(velocity, motion, H);
        }
        let (mut own, mut own_places) = bodies;
        // Where a light axis is smeared, lanes go by the whole turn of the body and bodies one by one by that of the axis.
        let least = |motion: &BodyMotion| motion.inertia.min_element() / motion.inertia.max_element();
        let turns = own.iter().map(|velocity| velocity.angular.length() * H);
        let is_smeared: Vec<bool> = turns.zip(&own_places).map(|(turn, motion)| turn * turn > least(motion)).collect();
        let mut poses = WideBodies::default();
        poses.lay_out(&Workers::default(), (&own, &mut own_places), &[], H);
        poses.apply_forces(&Workers::default(), &mut own, &own_places, H);
        poses.limit_speeds(&Workers::default(), &mut own);
        poses.predict(&Workers::default(), &own, &own_places, H);
        let moving = own.len() - 1;
        poses.advance(&Workers::default(), (&mut own, &mut own_places, moving), H);
        // Lanes take the midpoint rule as far as they go, off by the cube of the turn; one by one, the same turn is exact. What turns
        // further is moved one by one in both.
        let apart = |i: usize| {
            let turn = velocities[i].angular.length() * H;
            if turn > 1.1 * integrate::SAFE_TUMBLE { 0.0 } else { turn.powi(3) / 4.0 }
        };
        for (i, (own, other)) in own.iter().zip(&velocities).enumerate().filter(|&(i, _)| !is_smeared[i]) {
            let worst = share(own.linear, other.linear, 1.0).max(share(own.angular, other.angular, 1.0));
            // Rounding, times the ratio of the inertias.
            prop_assert!(worst < 1.0e-5 + apart(i), "velocities differ by {worst} of themselves");
            for (own, other) in own.inverse_inertia.entries().iter().zip(other.inverse_inertia.entries()) {
                let scale = 1.0e-5 * velocities_scale(&velocities);
                prop_assert!((own - other).abs() < scale, "inverse inertias {own} and {other} kg⁻¹m⁻²");
            }
        }
        for (i, (own, other)) in own_places.iter().zip(&motions).enumerate().filter(|&(i, _)| !is_smeared[i]) {
            let (way, turn) = ((own.displacement - other.displacement).length(), 2.0 * (own.rotation - other.rotation).length());
            let most = 2.0e-6 + apart(i);
            prop_assert!(way < 1.0e-6 && turn < most, "poses differ by {way} m and {turn} rad");
            prop_assert!((own.turn - other.turn).length() < most, "turns {} and {}", own.turn, other.turn);
        }
        let predicted = poses.predicted_poses.iter().zip(&predicted_poses).zip(&is_smeared);
        for (own, other) in predicted.filter(|(_, is_smeared)| !**is_smeared).map(|(pair, _)| pair) {
            let (way, turn) = ((own.displacement - other.displacement).length(), 2.0 * (own.rotation - other.rotation).length());
            prop_assert!(way < 1.0e-6 && turn < 2.0e-6, "predictions differ by {way} m and {turn} rad");
        }
    }
}

proptest! {
    #[test]
    fn lanes_displace_bodies_to_the_bits_of_bodies_displaced_one_by_one((velocities, mut motions) in any_bodies()) {
        let mut poses = WideBodies::default();
        poses.lay_out(&Workers::default(), (&velocities, &mut motions), &[], H);
        let mut other = motions.clone();
        other.iter_mut().zip(&velocities).for_each(|(motion, push)| motion.displace(push.linear, push.angular));
        poses.displace(&Workers::default(), &mut motions, &velocities);
        let bits = |motions: &[BodyMotion]| motions.iter().flat_map(BodyMotion::halves).flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&motions), bits(&other));
    }
}

/// Greatest entry of any inverse inertia.
fn velocities_scale(velocities: &[BodyVelocity]) -> f32 {
    velocities.iter().flat_map(|body| body.inverse_inertia.entries()).fold(0.0, |most, entry| most.max(entry.abs()))
}

#[test]
fn a_body_that_tumbles_in_lanes_keeps_its_angular_momentum() {
    let inertia = Vec3::new(1.0, 2.0, 2.8);
    let inverse = crate::shape::inertia_tensor(1.0 / inertia, Quat::IDENTITY);
    let at_rest = BodyVelocity::new(Vec3::ONE, Symmetric::from_mat3(inverse));
    let angular = Vec3::new(0.3, 6.0, 0.2);
    let mut velocities = vec![BodyVelocity::FIXED, BodyVelocity { angular, ..at_rest }];
    let kind = MotionKind::Tumbling;
    let mut motions = vec![BodyMotion::FIXED, BodyMotion { inertia, kind, jointed: true, ..BodyMotion::FIXED }];
    let momentum = |velocity: &BodyVelocity, motion: &BodyMotion| -> DVec3 {
        let (rotation, angular) = (motion.rotation.as_dquat().normalize(), velocity.angular.as_dvec3());
        rotation * (inertia.as_dvec3() * (rotation.conjugate() * angular))
    };
    let before = momentum(&velocities[1], &motions[1]);
    let mut poses = WideBodies::default();
    for _ in 0..600 {
        poses.lay_out(&Workers::default(), (&velocities, &mut motions), &[], H);
        for _ in 0..4 {
            let moving = motions.len() - 1;
            poses.advance(&Workers::default(), (&mut velocities, &mut motions, moving), H);
        }
    }
    let error = (momentum(&velocities[1], &motions[1]) - before).length() / before.length();
    // Rounding of ω, 6e-8 a substep, as likely up as down: 49 times that in 2400 of them.
    assert!(error < 2.0e-5, "angular momentum is off by {error} of itself after 10 s");
}

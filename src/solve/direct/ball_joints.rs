//! The rows of an articulation of ball joints alone, and their multipliers back in the joints.

use glam::{DVec3, Vec3};

use super::articulation::Articulation;
use super::ball_joint_system::{BallJointSystem, PointJoint, PointSolve, approach};
use crate::linalg::narrowing;
use crate::solve::joint::JointEntry;
use crate::solve::joint::rows::Phase;

impl Articulation {
    /// Finds where the joints are at the present poses, if they have moved since that was found.
    pub(super) fn find_spots(&mut self) {
        let Self { points, entries, links, local_poses, .. } = self;
        if !std::mem::replace(&mut points.is_known, true) {
            points.spots.clear();
            let spot = |(entry, [a, b]): (&JointEntry, [u32; 2])| {
                PointJoint::of(entry, &local_poses[a as usize], &local_poses[b as usize])
            };
            points.spots.extend(entries.iter().zip(links.iter().map(|link| link.bodies)).map(spot));
        }
    }

    /// Finds where the joints will be at the predicted poses; these are the present ones where nothing is predicted.
    pub(super) fn find_ends(&mut self, predicts: bool) {
        let Self { points, entries, links, predicted, .. } = self;
        points.ends.clear();
        if predicts {
            let spot =
                |(entry, [a, b]): (&JointEntry, [u32; 2])| PointJoint::of(entry, &predicted[a as usize], &predicted[b as usize]);
            points.ends.extend(entries.iter().zip(links.iter().map(|link| link.bodies)).map(spot));
        } else {
            points.ends.extend_from_slice(&points.spots);
        }
    }

    /// What the joints ask for; that of a velocity phase needs where they will be.
    pub(super) fn ask_points(&mut self, phase: Phase) {
        self.find_spots();
        let Self { points, links, entries, rates, began, predicted, implicit, topology, .. } = self;
        points.begin();
        let BallJointSystem { spots, ends, joints, .. } = points;
        for (number, link) in links.iter().enumerate() {
            let bodies = link.bodies;
            // What is held by something that stays where it is would fall away from it by h² g in a substep without joints. Halfway there, the force
            // on a taut piece points past its middle, by so much that the stiffness of its pull turns it about its own axis, ever faster.
            let own = topology.loops > 0 && link.moves != [true; 2];
            let carried = if matches!(phase, Phase::Position { .. }) { Vec3::ZERO } else { entries[number].impulses.point };
            let impulse = carried.as_dvec3();
            let (levers, bias) = match phase {
                Phase::Velocity { h } => {
                    let levers = match implicit[number] {
                        1.0 => ends[number].pushed(own),
                        0.0 => spots[number].pushed(own),
                        share => {
                            let between = |body: u32| {
                                let (from, to) = (began.local_poses[body as usize], predicted[body as usize]);
                                (from.0.lerp(to.0, share), from.1.lerp(to.1, share))
                            };
                            PointJoint::of(&entries[number], &between(bodies[0]), &between(bodies[1])).pushed(own)
                        }
                    };
                    (levers, (ends[number].gap - spots[number].gap) / h - approach(&bodies, &levers, rates))
                }
                Phase::Tangent { .. } | Phase::Leap { .. } => (spots[number].pushed(own), DVec3::ZERO),
                Phase::Position { most } => {
                    (spots[number].pushed(own), spots[number].gap.clamp(DVec3::splat(-most), DVec3::splat(most)))
                }
            };
            joints.push(PointSolve { bodies, levers, bias, impulse });
        }
        let h = match phase {
            Phase::Velocity { h } | Phase::Tangent { h } => Some(h),
            Phase::Leap { .. } | Phase::Position { .. } => None,
        };
        points.judge_rows(topology, h);
    }

    /// Worst component of any gap at the present poses (m), where one that is no number counts as the worst.
    pub(super) fn worst_gap(&mut self) -> f64 {
        self.find_spots();
        let greater = |worst: f64, gap: f64| if gap <= worst { worst } else { gap };
        let gaps = self.points.spots.iter().map(|spot| spot.gap.abs());
        gaps.fold(0.0, |worst, gap| greater(greater(greater(worst, gap.x), gap.y), gap.z))
    }

    /// As [`Articulation::keep_impulses`].
    pub(super) fn keep_point_impulses(&mut self, scale: f64) {
        let (carried, steady) = (self.order.extrapolation, self.order.steady_share);
        self.points.drop_senseless();
        for (entry, joint) in self.entries.iter_mut().zip(&self.points.joints) {
            let last = std::mem::replace(&mut entry.impulses.point, narrowing::impulse(joint.impulse * scale));
            let acted = joint.impulse + last.as_dvec3() * steady + entry.acted[0].as_dvec3() * carried;
            entry.acted[0] = narrowing::impulse(acted);
            entry.linear_sum += entry.acted[0];
        }
    }
}

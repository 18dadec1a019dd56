//! What the world keeps of a joint beyond its definition.

use glam::Vec3;

use crate::fracture::strain::Strain;
use crate::joint::{JointDef, JointKind, Limits};
use crate::joint_drive::{DriveRates, JointDrive};
use crate::joint_rebounds::Rebounds;

/// Most scalar rows of one joint: six axes, each with a lower stop, an upper stop, a motor and friction.
pub(crate) const MAX_SCALAR_ROWS: usize = 24;

/// Most that a joint is said to bear (N, N·m), so that lengths and means of loads are finite too: the weight of 10¹⁷ kg.
const MAX_LOAD: f32 = 1.0e18;

/// A load that has been found (N, N·m) as it is told: none if the solve has found none, and at most [`MAX_LOAD`] an axis.
pub(crate) fn told_load(force: Vec3, torque: Vec3) -> (Vec3, Vec3) {
    if !force.is_finite() || !torque.is_finite() {
        return (Vec3::ZERO, Vec3::ZERO);
    }
    let told = |load: Vec3| load * (MAX_LOAD / load.abs().max_element().max(MAX_LOAD));
    (told(force), told(torque))
}

/// Multipliers of a joint's rows at the end of a substep, to start the next one from (N·s, N·m·s).
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointImpulses {
    pub point: Vec3,
    pub angular: Vec3,
    pub scalar: [f32; MAX_SCALAR_ROWS],
}

impl JointImpulses {
    pub(crate) const ZERO: Self = Self { point: Vec3::ZERO, angular: Vec3::ZERO, scalar: [0.0; MAX_SCALAR_ROWS] };

    /// Scalar rows with a positive multiplier, as bits.
    pub(crate) fn pressing(&self) -> u32 {
        const { assert!(MAX_SCALAR_ROWS <= u32::BITS as usize) };
        self.scalar.iter().enumerate().fold(0, |bits, (row, &impulse)| bits | u32::from(impulse > 0.0) << row)
    }

    pub(crate) fn scaled(&self, factor: f32) -> Self {
        Self { point: self.point * factor, angular: self.angular * factor, scalar: self.scalar.map(|impulse| impulse * factor) }
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.point == Vec3::ZERO && self.angular == Vec3::ZERO && self.scalar.iter().all(|&impulse| impulse == 0.0)
    }

    pub(crate) fn is_finite(&self) -> bool {
        // All of them are looked at, which is faster side by side than one after another up to the first that is not.
        let scalars = self.scalar.iter().fold(true, |finite, impulse| finite & impulse.is_finite());
        self.point.is_finite() & self.angular.is_finite() & scalars
    }
}

/// The world's record of a joint.
#[derive(Debug, Clone)]
pub(crate) struct Joint {
    pub def: JointDef,
    /// Slots of the bodies; `None` is the world.
    pub bodies: [Option<u32>; 2],
    pub impulses: JointImpulses,
    /// Angles near those at the end of the last step, turns counted (rad): that of a hinge, the twist of a spherical joint, all three of
    /// a six-axis joint. Of those that its rotation allows, the nearest are its own.
    pub angles: [f64; 3],
    /// Force and torque on B, mean over the last step.
    pub force: Vec3,
    pub torque: Vec3,
    /// Impulse on B of the last substep, if a direct solve took it (N·s, N·m·s); what it last moved by, if a sheet did: each takes
    /// what the other left for what it is, a guess.
    pub acted: [Vec3; 2],
    /// What it has borne of late, if it can break.
    pub strain: Option<Box<Strain>>,
    /// Stops that pressed in the last step, as bits: 2 × axis, and one more for the upper one.
    pub pressed: u32,
    /// How the host moves its stops and frames, if it does.
    pub drive: Option<Box<JointDrive>>,
    /// What the motor of each axis did, mean over the last step (N, N·m).
    pub motors: [f32; 6],
    /// Axes whose motor pushed harder in the last step than in the one before, as bits.
    pub straining: u8,
    /// At which speeds stops are to be left that were met in the last substep.
    pub rebounds: Rebounds,
}

impl Joint {
    pub(crate) fn new(def: JointDef, bodies: [Option<u32>; 2]) -> Self {
        let strain = def.strength.can_break().then(Box::default);
        Self {
            def,
            bodies,
            impulses: JointImpulses::ZERO,
            angles: [0.0; 3],
            force: Vec3::ZERO,
            torque: Vec3::ZERO,
            acted: [Vec3::ZERO; 2],
            strain,
            pressed: 0,
            drive: None,
            motors: [0.0; 6],
            straining: 0,
            rebounds: Rebounds::NONE,
        }
    }

    /// Which stops scalar rows with a positive multiplier mean; the rows are given as bits by their numbers.
    pub(crate) fn stops_of(&self, rows: u32) -> u32 {
        let pressing = |row: usize| rows >> row & 1 == 1;
        let both =
            |axis: usize, row: usize| u32::from(pressing(row)) << (2 * axis) | u32::from(pressing(row + 1)) << (2 * axis + 1);
        let between = |limits: &Limits, axis: usize, row: usize| if limits.min < limits.max { both(axis, row) } else { 0 };
        match &self.def.kind {
            JointKind::Fixed => 0,
            JointKind::Hinge { limits, .. } | JointKind::Prismatic { limits, .. } | JointKind::Distance { limits, .. } => {
                between(limits, 0, 0)
            }
            // The row of the swing is its only stop, the upper one of axis 1.
            JointKind::Spherical { twist_limits, .. } => between(twist_limits, 0, 1) | u32::from(pressing(0)) << 3,
            JointKind::Generic { linear, angular } => {
                let axes = linear.iter().chain(angular).enumerate();
                axes.map(|(axis, def)| between(&def.limits, axis, 3 * axis)).fold(0, |all, one| all | one)
            }
        }
    }

    /// Axis and side of each of these stops.
    pub(crate) fn stops(bits: u32) -> impl Iterator<Item = (u8, bool)> {
        (0..12_u8).filter(move |bit| bits >> bit & 1 == 1).map(|bit| (bit / 2, bit % 2 == 1))
    }

    /// Starts the next step from nothing.
    pub(crate) fn forget_impulses(&mut self) {
        self.impulses = JointImpulses::ZERO;
        self.force = Vec3::ZERO;
        self.torque = Vec3::ZERO;
        (self.motors, self.straining) = ([0.0; 6], 0);
        self.acted = [Vec3::ZERO; 2];
        self.rebounds = Rebounds::NONE;
        if let Some(strain) = &mut self.strain {
            strain.spans = Default::default();
        }
    }

    /// Whether it bore more in the last step than the load from which on it is reported.
    pub(crate) fn is_overloaded(&self) -> bool {
        self.force.length() > self.def.break_force || self.torque.length() > self.def.break_torque
    }

    /// How fast its stops and frames move in this step, if at all.
    pub(crate) fn drive(&self) -> Option<&DriveRates> {
        self.drive.as_ref().map(|drive| &drive.solved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_that_are_told_have_a_length() {
        let usual = (Vec3::new(1.0e9, -2.5, 0.0), Vec3::new(-3.0, 0.125, 1.0e17));
        assert_eq!(told_load(usual.0, usual.1), usual);
        let (force, torque) = told_load(Vec3::new(-1.4e21, 7.0e20, 0.0), Vec3::new(0.0, f32::MAX, 1.0));
        assert!(force.length().is_finite() && torque.length().is_finite());
        assert!((force.normalize() - Vec3::new(-2.0, 1.0, 0.0).normalize()).length() < 1.0e-6);
        assert_eq!(told_load(Vec3::new(f32::INFINITY, 0.0, 0.0), Vec3::ONE), (Vec3::ZERO, Vec3::ZERO));
    }
}

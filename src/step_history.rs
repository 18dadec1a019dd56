//! What a body keeps of its last substep: `solve/direct/multistep.rs` goes on from it.

use glam::Vec3;

/// Linear and angular velocity (m/s, rad/s), or a change of it.
pub(crate) type Twist = [Vec3; 2];

/// Length of the substep where nothing is known but that the next one begins with a blow.
const JOLTED: f32 = -2.0;

/// Length of the substep where nothing is known but that the host has changed the velocity.
const STRUCK: f32 = -3.0;

/// Length of the substep where nothing is known but a lead: see `solve/velocity_half_step.rs`.
const TOLD: f32 = -1.0;

/// A body's last substep, as its record keeps it from one step to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct History {
    /// Length of the substep (s); zero where nothing is known.
    pub h: f32,
    /// Substeps that the articulation should take in the next step.
    pub substeps: u32,
    /// Further time for which its articulation's contacts are swept, as rows of the same system they did not settle (s).
    pub swept_for: f32,
    /// Displacement (m) and rotation vector (rad).
    pub(crate) displacement: Vec3,
    pub(crate) turn: Vec3,
    /// Of a fast rotor the angle about its axis (rad), which is no part of the rotation vector then; else zero.
    pub(crate) spin_turn: f32,
    /// Velocity and angular momentum at its start (m/s, N·m·s); or a lead of the velocities (m/s, rad/s).
    pub(crate) linear_before: Vec3,
    pub(crate) momentum_before: Vec3,
    /// Rates of both at its end, as the substep took them (m/s², N·m).
    pub(crate) acceleration: Vec3,
    pub(crate) torque: Vec3,
    /// Of those, what gravity and the host gave it: acceleration and torque (m/s², N·m).
    pub(crate) pushed: Twist,
    /// Second derivative of its velocity, averaged over the length of a step (m/s³); zero where nothing is known.
    pub(crate) jerk: Vec3,
    /// Velocities at its end: others mean that the body has been struck or edited since.
    pub(crate) linear: Vec3,
    pub(crate) angular: Vec3,
}

impl History {
    pub(crate) const NONE: Self = Self {
        h: 0.0,
        substeps: 0,
        swept_for: 0.0,
        displacement: Vec3::ZERO,
        turn: Vec3::ZERO,
        spin_turn: 0.0,
        linear_before: Vec3::ZERO,
        momentum_before: Vec3::ZERO,
        acceleration: Vec3::ZERO,
        torque: Vec3::ZERO,
        pushed: [Vec3::ZERO; 2],
        jerk: Vec3::ZERO,
        linear: Vec3::ZERO,
        angular: Vec3::ZERO,
    };

    /// Whether what holds the body has changed its velocity at once: neither what was before the next substep leads on from there, nor does
    /// that substep itself.
    pub(crate) fn is_jolted(&self) -> bool {
        self.h == JOLTED
    }

    /// Notes that the host has changed the body's velocity.
    pub(crate) fn strike(&mut self) {
        if self.lead().is_none() && !self.is_jolted() {
            self.h = STRUCK;
        }
    }

    /// Whether the host has changed the body's velocity, which its joints may not allow.
    pub(crate) fn is_struck(&self) -> bool {
        self.h == STRUCK
    }

    /// Of a body that sweeps have moved, and whose velocity was told with this lead.
    pub(crate) fn leading([linear, angular]: Twist) -> Self {
        Self { h: TOLD, linear_before: linear, momentum_before: angular, ..Self::NONE }
    }

    /// What its velocity was told with, if with anything.
    pub(crate) fn lead(&self) -> Option<Twist> {
        (self.h == TOLD).then_some([self.linear_before, self.momentum_before])
    }

    /// Forgets a lead: the body is at rest.
    pub(crate) fn forget_lead(&mut self) {
        if self.h == TOLD {
            *self = Self::NONE;
        }
    }
}

/// The last substep of a body, in room of its own: most bodies never have one to keep.
#[derive(Debug, Clone, Default)]
pub(crate) struct StepHistory(Option<Box<History>>);

impl StepHistory {
    pub(crate) fn new(history: History) -> Self {
        Self(Some(Box::new(history)))
    }

    pub(crate) fn get(&self) -> History {
        self.0.as_deref().copied().unwrap_or(History::NONE)
    }

    pub(crate) fn lead(&self) -> Option<Twist> {
        self.0.as_ref()?.lead()
    }

    pub(crate) fn set(&mut self, history: History) {
        match &mut self.0 {
            Some(kept) => **kept = history,
            None => self.0 = Some(Box::new(history)),
        }
    }

    pub(crate) fn set_swept_for(&mut self, time: f32) {
        self.set(History { swept_for: time, ..self.get() });
    }

    /// Brings a lead to a centre of mass that an edit has moved by `shift` (m), and forgets anything else.
    pub(crate) fn center_moved(&mut self, shift: Vec3) {
        match &mut self.0 {
            Some(kept) if kept.lead().is_some() => kept.linear_before += kept.momentum_before.cross(shift),
            _ => self.forget(),
        }
    }

    /// Forgets the last substep, but not a lead: the body weighs something else than it did in it.
    pub(crate) fn mass_changed(&mut self) {
        self.center_moved(Vec3::ZERO);
    }

    /// Forgets everything; the room is kept, for a step that is to come.
    pub(crate) fn forget(&mut self) {
        if let Some(kept) = &mut self.0 {
            **kept = History::NONE;
        }
    }

    /// Notes that what holds the body has changed its velocity at once.
    pub(crate) fn jolt(&mut self) {
        self.set(History { h: JOLTED, ..History::NONE });
    }

    /// Notes that the host has changed the body's velocity.
    pub(crate) fn strike(&mut self) {
        let mut kept = self.get();
        kept.strike();
        self.set(kept);
    }

    pub(crate) fn forget_lead(&mut self) {
        if let Some(kept) = &mut self.0 {
            kept.forget_lead();
        }
    }
}

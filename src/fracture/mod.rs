//! Fracture: measures how much load a joint bears, and reports it when it breaks.
//!
//! A joint's load is the force f and the torque τ about its point that it exerts on body B, in axes of its frame on A. With x the
//! joint axis, taken to point from A to B (of a joint that holds a distance, the line from its point on A to that on B, whatever its frame),
//!
//! ```text
//! tension      max(−f·x, 0)      B is held back from leaving along +x           (N)
//! compression  max(f·x, 0)       B is kept from coming closer                   (N)
//! shear        |f − (f·x) x|                                                    (N)
//! bending      |τ − (τ·x) x|                                                    (N·m)
//! torsion      |τ·x|                                                            (N·m)
//! ```
//!
//! each against a limit of its own; the greatest ratio is the joint's *share* of what it bears. Loads are compared as their mean
//! over a window of time, never as a peak: a blow of impulse J counts as J / window whatever the length of the step or of the
//! contact, a steady force as itself, and an error that the solver makes in one substep and mends in the next as nothing.
//!
//! The order of a step is that of Müller et al. 2017, §3.5: the solver runs with all joints, those that bear too much are taken
//! out, and the step is solved again without them, so that what they held goes its own way from that very step.

use glam::{DVec3, Vec3};

use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::id::{BodyId, JointId};

mod polyhedron;
pub(crate) mod strain;
pub(crate) mod voronoi;

/// Longest window that loads are averaged over (s).
pub const MAX_WINDOW: f32 = 10.0;

/// What a joint bears before it breaks. Infinity is never.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strength {
    /// Greatest force that pulls B away from A along the joint axis (N); of a distance joint, along the line between its points.
    pub tension: f32,
    /// Greatest force that presses B against A along the joint axis (N); of a distance joint, along the line between its points.
    pub compression: f32,
    /// Greatest force across the joint axis (N); a distance joint has none.
    pub shear: f32,
    /// Greatest torque across the joint axis (N·m).
    pub bending: f32,
    /// Greatest torque about the joint axis (N·m).
    pub torsion: f32,
    /// Time over which loads are averaged (s), above 0, at most [`MAX_WINDOW`]. A step longer than it is a window of its own.
    pub window: f32,
    /// How loads below the limits wear the joint out; `None` if they do not.
    pub damage: Option<Damage>,
}

/// How loads below the limits wear a joint out.
///
/// With s the joint's share of its limits, damage D grows by (s − from)/(1 − from) / time per second above `from` and halves every
/// `half_life`; at D = 1 the joint breaks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Damage {
    /// Share of its limits from which the joint wears, 0 to below 1.
    pub from: f32,
    /// Time after which a new joint at just its limit is worn out (s), > 0.
    pub time: f32,
    /// Time in which damage halves (s), > 0; infinity if it stays.
    pub half_life: f32,
}

impl Strength {
    /// Nothing breaks it. The window, for whoever sets limits, is a sixtieth of a second.
    pub const UNBREAKABLE: Self = Self {
        tension: f32::INFINITY,
        compression: f32::INFINITY,
        shear: f32::INFINITY,
        bending: f32::INFINITY,
        torsion: f32::INFINITY,
        window: 1.0 / 60.0,
        damage: None,
    };

    /// The limits of a bond of this area (m²) and these stresses (Pa) in tension, compression and shear.
    ///
    /// Bending and torsion are those of a round section, radius r = √(A/π), whose edge just reaches the stress: σ π r³/4 with the
    /// lesser of tension and compression, and τ π r³/2.
    pub fn of_bond(area: f32, tension: f32, compression: f32, shear: f32) -> Self {
        let radius = (area / std::f32::consts::PI).sqrt();
        Self {
            tension: tension * area,
            compression: compression * area,
            shear: shear * area,
            bending: tension.min(compression) * area * radius / 4.0,
            torsion: shear * area * radius / 2.0,
            ..Self::UNBREAKABLE
        }
    }

    /// The same with all limits multiplied by `factor`.
    #[must_use]
    pub fn scaled(self, factor: f32) -> Self {
        Self {
            tension: self.tension * factor,
            compression: self.compression * factor,
            shear: self.shear * factor,
            bending: self.bending * factor,
            torsion: self.torsion * factor,
            ..self
        }
    }

    /// Whether any limit is finite.
    pub fn can_break(&self) -> bool {
        [self.tension, self.compression, self.shear, self.bending, self.torsion].iter().any(|limit| limit.is_finite())
    }

    pub(crate) fn check(&self) -> Result<()> {
        check::bound("strength.tension", self.tension)?;
        check::bound("strength.compression", self.compression)?;
        check::bound("strength.shear", self.shear)?;
        check::bound("strength.bending", self.bending)?;
        check::bound("strength.torsion", self.torsion)?;
        if check::positive("strength.window", self.window)? > MAX_WINDOW {
            return Err(Error::new(ErrorKind::OutOfRange, "strength.window", "is longer than 10 s"));
        }
        if let Some(damage) = &self.damage {
            if check::not_negative("strength.damage.from", damage.from)? >= 1.0 {
                return Err(Error::new(ErrorKind::OutOfRange, "strength.damage.from", "must be below 1"));
            }
            check::positive("strength.damage.time", damage.time)?;
            if check::bound("strength.damage.half_life", damage.half_life)? == 0.0 {
                return Err(Error::new(ErrorKind::OutOfRange, "strength.damage.half_life", "must be greater than zero"));
            }
        }
        Ok(())
    }

    /// The greatest of the ratios of load to limit, and which it is.
    pub(crate) fn share(&self, load: &JointLoad) -> (f32, BreakLimit) {
        let ratio = |load: f32, limit: f32| if load > 0.0 { load / limit } else { 0.0 };
        let (force, torque) = (load.force, load.torque);
        let ratios = [
            (ratio(-force.x, self.tension), BreakLimit::Tension),
            (ratio(force.x, self.compression), BreakLimit::Compression),
            (ratio(force.truncate_x().length(), self.shear), BreakLimit::Shear),
            (ratio(torque.truncate_x().length(), self.bending), BreakLimit::Bending),
            (ratio(torque.x.abs(), self.torsion), BreakLimit::Torsion),
        ];
        ratios.into_iter().fold((0.0, BreakLimit::Tension), |most, next| if next.0 > most.0 { next } else { most })
    }
}

impl Default for Strength {
    fn default() -> Self {
        Self::UNBREAKABLE
    }
}

trait AcrossX {
    fn truncate_x(self) -> glam::Vec2;
}

impl AcrossX for Vec3 {
    fn truncate_x(self) -> glam::Vec2 {
        glam::Vec2::new(self.y, self.z)
    }
}

/// Force (N) and torque about the joint's point (N·m) that a joint exerts on body B, in axes of its frame on A; of a distance joint, turned so
/// that x is the line from its point on A to that on B.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointLoad {
    /// Force on B (N).
    pub force: Vec3,
    /// Torque on B about the joint's point (N·m).
    pub torque: Vec3,
}

/// One of the five limits of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BreakLimit {
    /// Pulled apart along the axis.
    Tension,
    /// Pressed together along the axis.
    Compression,
    /// Pushed across the axis.
    Shear,
    /// Bent across the axis.
    Bending,
    /// Twisted about the axis.
    Torsion,
}

/// Why a joint broke.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BreakCause {
    /// Its mean load passed a limit.
    Load,
    /// It was worn out.
    Damage,
    /// It was on the list given to `apply_fractures`, and had not passed a limit here.
    Applied,
}

/// Whether and how fast joints break.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FractureSettings {
    /// Whether joints break by their own load. If not, only what is given to `apply_fractures` breaks: so a client follows its
    /// server.
    pub by_load: bool,
    /// Most joints that break in a step, ≥ 1; the rest do in the steps after, in order of their handles.
    pub most: u32,
}

impl Default for FractureSettings {
    fn default() -> Self {
        Self { by_load: true, most: 4096 }
    }
}

impl FractureSettings {
    pub(crate) fn check(&self) -> Result<()> {
        if self.most == 0 {
            return Err(Error::new(ErrorKind::OutOfRange, "fracture.most", "must be at least 1"));
        }
        Ok(())
    }
}

/// What a joint bears at present.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointStress {
    /// Mean load over the joint's window.
    pub load: JointLoad,
    /// Its share of the limit that is nearest: 1 breaks.
    pub share: f32,
    /// That limit.
    pub limit: BreakLimit,
    /// How worn it is, 0 to 1.
    pub damage: f32,
}

/// A joint that broke in the last step. The joint is gone: its handle is stale, and here for whoever kept it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointBreak {
    /// The joint.
    pub joint: JointId,
    /// The host's word on it.
    pub user_word: u64,
    /// Its bodies; null is the world.
    pub bodies: [BodyId; 2],
    /// Where it was (m).
    pub point: DVec3,
    /// Mean force on B over its window, world axes (N).
    pub force: Vec3,
    /// Mean torque on B about its point, world axes (N·m).
    pub torque: Vec3,
    /// Its share of the limit it broke at: above 1 if by load.
    pub share: f32,
    /// That limit.
    pub limit: BreakLimit,
    /// Why it broke.
    pub cause: BreakCause,
    /// Number of the step.
    pub step: u64,
}

/// A rigid union that fell into pieces in the last step.
///
/// A union is the set of dynamic bodies that fixed joints connect; what is static or kinematic anchors it and is not a member.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Split {
    /// Its member of the lowest slot, which is in the first piece too.
    pub first_body: BodyId,
    /// Number of its members.
    pub body_count: u32,
    /// Its mass (kg).
    pub mass: f32,
    /// Its centre of mass at the end of the step (m).
    pub center: DVec3,
    /// Velocity of its centre of mass (m/s).
    pub linear_velocity: Vec3,
    /// Whether a fixed joint tied it to the world, or to a body that is not dynamic.
    pub anchored: bool,
    /// Its pieces, as a range in the list of pieces.
    pub pieces: (u32, u32),
    /// Number of the step.
    pub step: u64,
}

/// What is left of a union: a smaller union, or a single body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Its member of the lowest slot.
    pub first_body: BodyId,
    /// Its members, as a range in the list of members.
    pub bodies: (u32, u32),
    /// Its mass (kg).
    pub mass: f32,
    /// Its centre of mass at the end of the step (m).
    pub center: DVec3,
    /// Velocity of its centre of mass (m/s).
    pub linear_velocity: Vec3,
    /// Angular velocity: that of a rigid body with its angular momentum (rad/s).
    pub angular_velocity: Vec3,
    /// Whether a fixed joint still ties it to the world, or to a body that is not dynamic.
    pub anchored: bool,
    /// Whether it has lost its anchor: the union had one, it has none.
    pub cut_loose: bool,
}

//! What joints bear, as C describes it.

use ls_core::{BondMaterial, BreakCause, BreakLimit, Damage, FractureSettings, Strength};

/// Limit of a joint: pulled apart along its axis; a distance joint, along the line between its points.
pub const LS_STRENGTH_TENSION: i32 = 0;
/// Limit of a joint: pressed together along its axis; a distance joint, along the line between its points.
pub const LS_STRENGTH_COMPRESSION: i32 = 1;
/// Limit of a joint: pushed across its axis; never a distance joint, whose force is along its line.
pub const LS_STRENGTH_SHEAR: i32 = 2;
/// Limit of a joint: bent across its axis.
pub const LS_STRENGTH_BENDING: i32 = 3;
/// Limit of a joint: twisted about its axis.
pub const LS_STRENGTH_TORSION: i32 = 4;

/// Cause of a break: the mean load passed a limit.
pub const LS_BREAK_LOAD: i32 = 0;
/// Cause of a break: the joint was worn out.
pub const LS_BREAK_DAMAGE: i32 = 1;
/// Cause of a break: ls_world_fractures_apply named the joint, and it had not passed a limit.
pub const LS_BREAK_APPLIED: i32 = 2;

/// What a joint bears before it breaks. Loads are those on body B in axes of the joint's frame on A, whose x axis is taken to
/// point from A to B; INFINITY is never. The layout of this struct never changes.
///
/// The x axis of a distance joint, be it a rope, a rod or a spring, is the line from its point on A to that on B, whatever its frames: all of
/// its force is tension or compression, and none of it shear.
///
/// Loads are compared as their mean over the window: an impulse J counts as J / window whatever the length of the step, a steady
/// load as itself. Damage grows by (share - damage_from) / (1 - damage_from) / damage_time a second while the joint bears more
/// than damage_from of a limit, and halves every damage_half_life; at 1 the joint breaks.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsStrength {
    /// Greatest force that pulls B away from A along the axis (N), >= 0; default INFINITY.
    pub tension: f32,
    /// Greatest force that presses B against A along the axis (N), >= 0; default INFINITY.
    pub compression: f32,
    /// Greatest force across the axis (N), >= 0; default INFINITY.
    pub shear: f32,
    /// Greatest torque across the axis (N m), >= 0; default INFINITY.
    pub bending: f32,
    /// Greatest torque about the axis (N m), >= 0; default INFINITY.
    pub torsion: f32,
    /// Time over which loads are averaged (s), above 0, at most 10; default 1/60. A longer step is a window of its own.
    pub window: f32,
    /// Not 0: loads below the limits wear the joint out; default 0.
    pub wears: u32,
    /// Fraction of a limit from which it wears, 0 to below 1; read if wears; default 0.5.
    pub damage_from: f32,
    /// Time after which a new joint at its limit is worn out (s), > 0; read if wears; default 1.
    pub damage_time: f32,
    /// Time in which damage halves (s), > 0, INFINITY if it stays; read if wears; default INFINITY.
    pub damage_half_life: f32,
}

/// What bonds the cells of a solid. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsBondMaterial {
    /// Greatest tensile stress (N/m^2, which is Pa), >= 0.
    pub tension: f32,
    /// Greatest compressive stress (N/m^2, which is Pa), >= 0.
    pub compression: f32,
    /// Greatest shear stress (N/m^2, which is Pa), >= 0.
    pub shear: f32,
    /// Time over which loads are averaged (s), above 0, at most 10.
    pub window: f32,
    /// Not 0: loads below the limits wear bonds out, as in LsStrength.
    pub wears: u32,
    /// Fraction of a limit from which a bond wears, 0 to below 1; read if wears.
    pub damage_from: f32,
    /// Time after which a new bond at its limit is worn out (s), > 0; read if wears.
    pub damage_time: f32,
    /// Time in which damage halves (s), > 0, INFINITY if it stays; read if wears.
    pub damage_half_life: f32,
}

/// Whether and how fast joints break. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsFractureSettings {
    /// Not 0: joints break by their own load; default 1. If 0, only what ls_world_fractures_apply names does, as on a client.
    pub by_load: u32,
    /// Most joints that break in a step, >= 1; the rest do in the steps after, in order of their handles; default 4096.
    pub most: u32,
}

const DEFAULT_DAMAGE: Damage = Damage { from: 0.5, time: 1.0, half_life: f32::INFINITY };

fn damage(wears: u32, from: f32, time: f32, half_life: f32) -> Option<Damage> {
    (wears != 0).then_some(Damage { from, time, half_life })
}

impl From<LsStrength> for Strength {
    fn from(strength: LsStrength) -> Self {
        let LsStrength { tension, compression, shear, bending, torsion, window, wears, .. } = strength;
        let damage = damage(wears, strength.damage_from, strength.damage_time, strength.damage_half_life);
        Self { tension, compression, shear, bending, torsion, window, damage }
    }
}

impl From<Strength> for LsStrength {
    fn from(strength: Strength) -> Self {
        let Strength { tension, compression, shear, bending, torsion, window, damage } = strength;
        let Damage { from, time, half_life } = damage.unwrap_or(DEFAULT_DAMAGE);
        Self {
            tension,
            compression,
            shear,
            bending,
            torsion,
            window,
            wears: damage.is_some().into(),
            damage_from: from,
            damage_time: time,
            damage_half_life: half_life,
        }
    }
}

impl From<LsBondMaterial> for BondMaterial {
    fn from(material: LsBondMaterial) -> Self {
        let LsBondMaterial { tension, compression, shear, window, wears, .. } = material;
        let damage = damage(wears, material.damage_from, material.damage_time, material.damage_half_life);
        Self { tension, compression, shear, window, damage }
    }
}

impl From<LsFractureSettings> for FractureSettings {
    fn from(settings: LsFractureSettings) -> Self {
        Self { by_load: settings.by_load != 0, most: settings.most }
    }
}

impl From<FractureSettings> for LsFractureSettings {
    fn from(settings: FractureSettings) -> Self {
        Self { by_load: settings.by_load.into(), most: settings.most }
    }
}

pub(crate) fn from_limit(limit: BreakLimit) -> i32 {
    match limit {
        BreakLimit::Tension => LS_STRENGTH_TENSION,
        BreakLimit::Compression => LS_STRENGTH_COMPRESSION,
        BreakLimit::Shear => LS_STRENGTH_SHEAR,
        BreakLimit::Bending => LS_STRENGTH_BENDING,
        BreakLimit::Torsion => LS_STRENGTH_TORSION,
    }
}

pub(crate) fn from_cause(cause: BreakCause) -> i32 {
    match cause {
        BreakCause::Load => LS_BREAK_LOAD,
        BreakCause::Damage => LS_BREAK_DAMAGE,
        BreakCause::Applied => LS_BREAK_APPLIED,
    }
}

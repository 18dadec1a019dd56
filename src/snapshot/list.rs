//! The list of everything that a snapshot holds.
//!
//! Whoever adds a field to one of these types is stopped here by the compiler, and lists it: as stored, or as made anew with the
//! value that it then gets. The fields of `World` itself are listed in the same way in `world/snapshot.rs`.

use glam::{DVec3, Quat};
use parry3d::bounding_volume::Aabb;

use super::carried::{AskedBound, CarriedBound, CarriedUnion, HeldBody, HeldUnit};
use super::contacts::{FarPose, ManifoldRow, PairRow, PointRow};
use super::stored::{Reader, Stored, Writer, stored, stored_enum};
use crate::body::{Anchored, Body, BodyDef, BodyKind, BodySettings, BodyTimes, Drift, KinematicState, LockedAxes, SleepState};
use crate::collide::collider::Collider;
use crate::collide::pairs::PairKey;
use crate::dwell_time::{DwellTime, Settling};
use crate::fracture::strain::{ImpulseSpan, Strain};
use crate::fracture::{Damage, FractureSettings, Strength};
use crate::id::{JointId, Slot};
use crate::joint::{Axis, Drive, ForceSide, JointDef, JointKind, Limits, Motor, Softness, SphericalMotor};
use crate::joint_drive::{DriveRates, JointDrive};
use crate::joint_graph::union::UnionMotion;
use crate::joint_rebounds::Rebounds;
use crate::joint_record::{Joint, JointImpulses};
use crate::kinematic_path::KinematicPath;
use crate::long_range::{BoundKind, BoundKindDef, LongRangeDef, SoftBound};
use crate::mass::{Mass, MassProperties};
use crate::material::{CombineRule, Material};
use crate::pose::Pose;
use crate::report::ContactPair;
use crate::settings::{ArticulationSettings, SleepSettings, Solver, WorldDef};
use crate::shape::{CollisionFilter, ShapeDef};
use crate::step_history::{History, StepHistory};

/// What a world has besides its tables.
#[derive(Debug)]
pub(crate) struct WorldRow {
    pub def: WorldDef,
    pub step: u64,
    pub time: f64,
    pub last_substep: f32,
    pub last_dt: f32,
    pub movers: Runs,
    pub movers_sorted: bool,
    /// Shapes whose neighbours are to be looked for.
    pub changed: Runs,
    pub ended_by_edits: Vec<ContactPair>,
    /// What sensors overlap, the sensor first.
    pub sensed: Vec<ContactPair>,
    /// Bodies of which it was said that they are supported, and those of which something else may be said soon.
    pub said_supported: Runs,
    pub watched: Vec<(u32, DwellTime)>,
    /// Whether long-range bounds are to be derived anew.
    pub bounds_stale: bool,
    /// Bodies whose unions are to be made anew.
    pub stale_unions: Runs,
    /// Anchored bodies pushed since the last step.
    pub pushed: Runs,
    /// Soft bounds that the host asked for.
    pub asked_bounds: Vec<AskedBound>,
    /// Joints that are to break in the next step because the host says so.
    pub asked_fractures: Vec<JointId>,
    /// Units that are held among others that move.
    pub held_units: Vec<HeldUnit>,
    pub free: FreeSlots,
}

/// Slots that have been given back and are to be taken next, the last first.
#[derive(Debug)]
pub(crate) struct FreeSlots {
    pub bodies: Runs,
    pub shapes: Runs,
    pub joints: Runs,
    pub islands: Runs,
}

/// A shape that is not quite where its body's pose of now would put it, as after its body's mass has changed.
#[derive(Debug)]
pub(crate) struct Displaced {
    pub shape: u32,
    pub place: (DVec3, Quat),
}

/// The box that a shape could not leave when its body last moved, where that is not the one it has by itself.
#[derive(Debug)]
pub(crate) struct LastBox {
    pub shape: u32,
    pub tight_box: Aabb,
}

/// A sleeping island; its pairs are the next so many of the table of pairs that sleep.
#[derive(Debug)]
pub(crate) struct IslandRow {
    pub bodies: Runs,
    pub pairs: u32,
}

stored!(WorldRow {
    def,
    step,
    time,
    last_substep,
    last_dt,
    movers,
    movers_sorted,
    changed,
    ended_by_edits,
    sensed,
    said_supported,
    watched,
    bounds_stale,
    stale_unions,
    pushed,
    asked_bounds,
    asked_fractures,
    held_units,
    free,
});
stored!(FreeSlots { bodies, shapes, joints, islands });
stored!(HeldUnit { bodies });
stored!(HeldBody { body, load });
stored!(WorldDef {
    gravity,
    substeps,
    iterations,
    solver,
    threads,
    sleep,
    restitution_threshold,
    hit_threshold,
    body_capacity,
    joint_capacity,
    support,
    support_by_thrust,
    hold,
    long_range,
    articulations,
    fracture,
});
stored!(ArticulationSettings { error_target, most_substeps, halving_budget });
stored!(FractureSettings { by_load, most });
stored!(LongRangeDef { enabled, attachment, hierarchy, soft, union, plane_position, plane_axis, levels });
stored!(UnionMotion { center, rotation, linear, angular });
stored!(CarriedUnion { lead, motion, before });
stored!(AskedBound { joints, bound });
stored!(SoftBound { share, softness });
stored!(BoundKindDef { enabled, upper, lower });
stored!(CarriedBound { kind, level, upper, lower, ends, impulses, far_force, active });
stored!(SleepSettings { enabled, linear_speed, angular_speed, time });
stored!(ContactPair { shape_a, shape_b, body_a, body_b });
stored!(Displaced { shape, place });
stored!(fixed LastBox { shape, tight_box });
stored!(IslandRow { bodies, pairs });

stored!(Body {
    kind,
    center,
    rotation,
    linear_velocity,
    angular_velocity,
    force,
    torque,
    mass,
    local_center,
    settings,
    kinematic,
    shapes,
    joints,
    sleep,
    quarantined,
    history,
    times,
    held,
    woke,
    anchored,
});
stored!(BodySettings { mass_source, locked_axes, linear_damping, angular_damping, gravity_scale, can_sleep, fast, user_word });
stored!(KinematicState { driven, path });
stored!(BodyTimes { settling, calm_for, smooth_for });
stored!(BodyDef {
    kind,
    pose,
    linear_velocity,
    angular_velocity,
    mass,
    locked_axes,
    linear_damping,
    angular_damping,
    gravity_scale,
    can_sleep,
    fast,
    user_word,
    shapes,
});
stored!(ShapeDef { shape, local_pose, material, density, filter, user_word, sensor });
stored!(LockedAxes { translation, rotation });
stored!(MassProperties { mass, center_of_mass, principal_inertia, inertia_frame });
stored!(Pose { position, rotation });

stored!(Collider {
    body, shape, local_pose, material, density, filter, user_word, sensor, reach, least_extent, fat_box,
} anew {
    // Of a shape at rest, but for those that are listed; of one that moves, the next step makes it anew.
    tight_box: Aabb::new_invalid(),
    // Follows its body, but for what is displaced.
    place: (DVec3::ZERO, Quat::IDENTITY),
});
stored!(Material { friction, restitution, rolling_friction, spinning_friction, friction_rule, restitution_rule });
stored!(CollisionFilter { member_of, collides_with });

stored!(History {
    h,
    substeps,
    swept_for,
    displacement,
    turn,
    spin_turn,
    linear_before,
    momentum_before,
    acceleration,
    torque,
    pushed,
    jerk,
    linear,
    angular
});

impl Stored for StepHistory {
    fn put(&self, out: &mut Writer) {
        self.get().put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        let before = input.words;
        let history = History::take(input)?;
        let is_known = before[..before.len() - input.words.len()].iter().any(|&word| word != 0);
        Some(if is_known { Self::new(history) } else { Self::default() })
    }
}

stored!(Joint { def, bodies, impulses, angles, force, torque, acted, strain, pressed, drive, motors, straining, rebounds });
stored!(Rebounds { rows, speeds });
stored!(KinematicPath { target, step, dt, velocity, change, slope });
stored!(JointDrive { stops, frames, found, since, carried, solved });
stored!(DriveRates { stops, frames, behind });
stored!(Strain { spans, damage, condemned });
stored!(ImpulseSpan { time, linear, angular });
stored!(Strength { tension, compression, shear, bending, torsion, window, damage });
stored!(Damage { from, time, half_life });
stored!(JointDef {
    kind,
    body_a,
    body_b,
    frame_a,
    frame_b,
    linear,
    angular,
    limit,
    friction,
    axis_friction,
    restitution,
    break_force,
    break_torque,
    strength,
    collide_connected,
    long_range,
    solver,
    user_word,
});
stored!(JointImpulses { point, angular, scalar });
stored!(Softness { compliance, damping });
stored!(Limits { min, max });
stored!(Axis { limits, motor });

stored_enum!(BoundKind { 0 => Attachment {}, 1 => Hierarchy {}, 2 => Soft {} });
stored_enum!(Solver { 0 => Auto {}, 1 => GaussSeidel {}, 2 => Direct {} });
stored_enum!(Anchored { 0 => No {}, 1 => Still {}, 2 => Driven {} });
stored_enum!(BodyKind { 0 => Static {}, 1 => Kinematic {}, 2 => Dynamic {} });
stored_enum!(Mass { 0 => FromShapes {}, 1 => Total { 0: mass }, 2 => Properties { 0: properties } });
stored!(Drift { linear, angular, linear_before, angular_before });
stored_enum!(SleepState { 0 => Awake { quiet_for: quiet_for, drift: drift }, 1 => Asleep { island: island } });
stored_enum!(CombineRule { 0 => GeometricMean {}, 1 => Average {}, 2 => Minimum {}, 3 => Multiply {}, 4 => Maximum {} });
stored_enum!(Motor {
    0 => Off {},
    1 => Velocity { target: target, max_force: max_force },
    2 => Position { target: target, softness: softness, max_force: max_force },
    3 => Drive { 0: drive },
});
stored!(Drive { target, velocity, softness, max_force, max_speed, side });
stored_enum!(ForceSide { 0 => Both {}, 1 => Pull {}, 2 => Push {} });
stored_enum!(SphericalMotor {
    0 => Off {},
    1 => Velocity { target: target, max_torque: max_torque },
    2 => Position { target: target, softness: softness, max_torque: max_torque },
});
stored_enum!(JointKind {
    0 => Fixed {},
    1 => Hinge { limits: limits, motor: motor },
    2 => Spherical { swing_limit: swing_limit, twist_limits: twist_limits, motor: motor },
    3 => Distance { limits: limits, spring_length: spring_length, motor: motor },
    4 => Prismatic { limits: limits, motor: motor },
    5 => Generic { linear: linear, angular: angular },
});

/// Names of all that is stored: what a snapshot must agree on.
pub(crate) const LISTED: &[&str] = &[
    WorldRow::FIELDS,
    FreeSlots::FIELDS,
    WorldDef::FIELDS,
    HeldUnit::FIELDS,
    HeldBody::FIELDS,
    LongRangeDef::FIELDS,
    AskedBound::FIELDS,
    SoftBound::FIELDS,
    BoundKindDef::FIELDS,
    CarriedBound::FIELDS,
    CarriedUnion::FIELDS,
    UnionMotion::FIELDS,
    SleepSettings::FIELDS,
    Displaced::FIELDS,
    LastBox::FIELDS,
    IslandRow::FIELDS,
    Body::FIELDS,
    BodySettings::FIELDS,
    KinematicState::FIELDS,
    BodyTimes::FIELDS,
    History::FIELDS,
    MassProperties::FIELDS,
    Collider::FIELDS,
    Material::FIELDS,
    Joint::FIELDS,
    Strain::FIELDS,
    ImpulseSpan::FIELDS,
    Strength::FIELDS,
    Damage::FIELDS,
    FractureSettings::FIELDS,
    JointDef::FIELDS,
    JointImpulses::FIELDS,
    Drive::FIELDS,
    PairRow::FIELDS,
    FarPose::FIELDS,
    ManifoldRow::FIELDS,
    PointRow::FIELDS,
];

impl Default for Axis {
    fn default() -> Self {
        Self::FREE
    }
}

impl<T: Stored> Stored for Slot<T> {
    fn put(&self, out: &mut Writer) {
        let Self { generation, value } = self;
        generation.put(out);
        value.put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        Some(Self { generation: Stored::take(input)?, value: Stored::take(input)? })
    }
}

impl Stored for DwellTime {
    fn put(&self, out: &mut Writer) {
        self.seconds().put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        Self::from_seconds(Stored::take(input)?)
    }
}

impl Stored for Settling {
    fn put(&self, out: &mut Writer) {
        self.seconds().put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        Self::from_seconds(Stored::take(input)?)
    }
}

impl Stored for PairKey {
    fn put(&self, out: &mut Writer) {
        self.shapes().put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        let (a, b) = Stored::take(input)?;
        (a < b).then(|| Self::new(a, b))
    }
}

/// Numbers, most of which follow one another: stored as runs.
#[derive(Debug, Default)]
pub(crate) struct Runs(pub Vec<u32>);

impl Stored for Runs {
    fn put(&self, out: &mut Writer) {
        let mut runs: Vec<(u32, u32)> = Vec::new();
        for &number in &self.0 {
            match runs.last_mut() {
                Some((first, len)) if first.checked_add(*len) == Some(number) => *len += 1,
                _ => runs.push((number, 1)),
            }
        }
        runs.put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        let runs = Vec::<(u32, u32)>::take(input)?;
        let total = runs.iter().map(|&(_, len)| u64::from(len)).sum();
        *input.numbers_left = input.numbers_left.checked_sub(total)?;
        let mut numbers = Vec::new();
        for (first, len) in runs {
            numbers.extend(first..first.checked_add(len)?);
        }
        Some(Self(numbers))
    }
}

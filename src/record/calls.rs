//! Every method of a world that changes it: one table for the recorder and the player.
//!
//! Numbers stay what they are; what is new gets the next one.

use glam::{DVec3, Vec3};

use super::RecordedWorld;
use super::argument::{Answer, Argument, Pages};
use crate::body::{BodyDef, BodyKind, LockedAxes};
use crate::error::Result;
use crate::fracture::{FractureSettings, Strength};
use crate::id::{BodyId, JointId, ShapeId};
use crate::joint::{JointDef, JointKind, Softness};
use crate::long_range::{LongRangeDef, SoftBound};
use crate::mass::Mass;
use crate::material::Material;
use crate::pose::Pose;
use crate::settings::{ArticulationSettings, SleepSettings, Solver};
use crate::shape::{CollisionFilter, ShapeDef};
use crate::snapshot::stored::Stored;
use crate::world::World;

macro_rules! by {
    (type ref $type:ty) => {
        &$type
    };
    (type val $type:ty) => {
        $type
    };
    (borrow ref $name:ident) => {
        $name
    };
    (borrow val $name:ident) => {
        &$name
    };
    (pass ref $name:ident) => {
        &$name
    };
    (pass val $name:ident) => {
        $name
    };
}

macro_rules! recorded {
    ($($number:literal $method:ident($($how:ident $argument:ident: $type:ty),*) -> $answer:ty;)*) => {
        /// Methods by number, with what they take.
        pub(super) const METHODS: &[&str] = &[$(stringify!($number $method $($type)*)),*];

        impl RecordedWorld {
            $(
                #[doc = concat!("As [`World::", stringify!($method), "`].")]
                ///
                /// # Errors
                /// As there.
                pub fn $method(&mut self, $($argument: by!(type $how $type)),*) -> Result<$answer> {
                    if self.recorder.is_none() {
                        return self.world.$method($($argument),*);
                    }
                    let outcome = self.world.$method($($argument),*);
                    let arguments: &[&dyn Argument] = &[$(by!(borrow $how $argument)),*];
                    self.note($number, &outcome, |log| log.arguments(arguments), false);
                    outcome
                }
            )*
        }

        /// Name of the method with this number.
        pub(super) fn name_of(number: u64) -> Option<&'static str> {
            match number {
                super::STEP => Some("step"),
                super::RESTORE => Some("restore"),
                super::SET_SUPPORT => Some("set_support"),
                $($number => Some(stringify!($method)),)*
                _ => None,
            }
        }

        /// Makes a call again; `None` if its arguments make no sense.
        pub(super) fn play(world: &mut World, number: u64, pages: &mut Pages) -> Option<Result<u64>> {
            match number {
                $($number => {
                    let ($($argument,)*) = pages.arguments(world.tag(), |_row| Some(($(<$type as Stored>::take(_row)?,)*)))?;
                    Some(world.$method($(by!(pass $how $argument)),*).map(|answer| answer.word()))
                })*
                _ => None,
            }
        }
    };
}

recorded! {
    2 create_body(ref def: BodyDef) -> BodyId;
    3 destroy_body(val body: BodyId) -> ();
    4 set_pose(val body: BodyId, val pose: Pose) -> ();
    5 set_linear_velocity(val body: BodyId, val velocity: Vec3) -> ();
    6 set_angular_velocity(val body: BodyId, val velocity: Vec3) -> ();
    7 move_to(val body: BodyId, val target: Pose) -> ();
    8 set_mass(val body: BodyId, val mass: Mass) -> ();
    9 set_damping(val body: BodyId, val linear: f32, val angular: f32) -> ();
    10 set_gravity_scale(val body: BodyId, val scale: f32) -> ();
    11 set_locked_axes(val body: BodyId, val locked: LockedAxes) -> ();
    12 set_fast(val body: BodyId, val fast: bool) -> ();
    13 set_can_sleep(val body: BodyId, val can_sleep: bool) -> ();
    14 set_user_word(val body: BodyId, val word: u64) -> ();
    15 add_force(val body: BodyId, val force: Vec3) -> ();
    16 add_force_at(val body: BodyId, val force: Vec3, val point: DVec3) -> ();
    17 add_torque(val body: BodyId, val torque: Vec3) -> ();
    18 add_impulse(val body: BodyId, val impulse: Vec3) -> ();
    19 add_impulse_at(val body: BodyId, val impulse: Vec3, val point: DVec3) -> ();
    20 add_angular_impulse(val body: BodyId, val impulse: Vec3) -> ();
    21 create_joint(ref def: JointDef) -> JointId;
    22 destroy_joint(val joint: JointId) -> ();
    23 set_joint_kind(val joint: JointId, val kind: JointKind) -> ();
    24 set_joint_softness(val joint: JointId, val linear: Softness, val angular: Softness, val limit: Softness) -> ();
    25 set_joint_break(val joint: JointId, val force: f32, val torque: f32) -> ();
    26 set_long_range(ref def: LongRangeDef) -> ();
    27 set_soft_bound(val joint_a: JointId, val joint_b: JointId, val bound: Option<SoftBound>) -> ();
    28 set_shape_def(val shape: ShapeId, ref def: ShapeDef) -> ();
    29 set_shape_user_word(val shape: ShapeId, val word: u64) -> ();
    30 set_joint_frames(val joint: JointId, val frame_a: Pose, val frame_b: Pose) -> ();
    31 set_joint_user_word(val joint: JointId, val word: u64) -> ();
    32 set_effort(val substeps: u32, val iterations: u32) -> ();
    33 set_sleep_settings(val sleep: SleepSettings) -> ();
    34 set_restitution_threshold(val speed: f32) -> ();
    35 attach_shape(val body: BodyId, ref def: ShapeDef) -> ShapeId;
    36 destroy_shape(val shape: ShapeId) -> ();
    37 set_material(val shape: ShapeId, val material: Material) -> ();
    38 set_filter(val shape: ShapeId, val filter: CollisionFilter) -> ();
    39 wake(val body: BodyId) -> ();
    40 put_to_sleep(val body: BodyId) -> ();
    41 set_gravity(val gravity: Vec3) -> ();
    42 set_hit_threshold(val speed: f32) -> ();
    43 set_body_kind(val body: BodyId, val kind: BodyKind) -> ();
    48 set_joint_strength(val joint: JointId, val strength: Strength) -> ();
    45 set_fracture_settings(val settings: FractureSettings) -> ();
    46 apply_fractures(ref joints: Vec<JointId>) -> ();
    47 set_articulation_settings(val settings: ArticulationSettings) -> ();
    49 set_joint_long_range(val joint: JointId, val long_range: bool) -> ();
    50 set_joint_solver(val joint: JointId, val solver: Solver) -> ();
    51 set_joint_friction(val joint: JointId, val friction: f32) -> ();
    52 set_joint_axis_friction(val joint: JointId, val friction: [f32; 6]) -> ();
    53 set_joint_restitution(val joint: JointId, val restitution: f32) -> ();
}

//! What a world starts with, as C describes it.

use ls_core::glam::Vec3;
use ls_core::{ArticulationSettings, SleepSettings, WorldDef};

use crate::boundary::call;
use crate::enums;
use crate::pointer::host;
use crate::result::{Failure, LsResult, Outcome};
use crate::sized::{Definition, SizedOut, Versioned};
use crate::strength::LsFractureSettings;

/// Solver: the library chooses per group of bodies.
pub const LS_SOLVER_AUTO: i32 = 0;
/// Solver: sweeps over the constraints, with long-range constraints.
pub const LS_SOLVER_GAUSS_SEIDEL: i32 = 1;
/// Solver: direct solve of articulations; sweeps for what its matrix does not fit.
pub const LS_SOLVER_DIRECT: i32 = 2;

/// When bodies fall asleep.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsSleepSettings {
    /// Not 0: bodies may fall asleep; default 1.
    pub enabled: u32,
    /// Linear speed below which a body is quiet (m/s); default 0.05.
    pub linear_speed: f32,
    /// Angular speed below which a body is quiet (rad/s); default 0.1.
    pub angular_speed: f32,
    /// How long all bodies of a group must be quiet before it falls asleep (s); default 0.5.
    pub time: f32,
}

/// How much work articulations may take: bodies that joints connect and that are solved at once. The layout of this struct never
/// changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsArticulationSettings {
    /// How far any body of a smooth articulation may be from its exact path after about a second (m), >= 0; the engine chooses its
    /// substeps for that, up to `most_substeps`. Default 0: about a thousandth of its extent, as the mean over its mass.
    pub error_target: f32,
    /// Most substeps of a smooth articulation over those of the world, up to 64; the least is one a step. Default 0: 4, with an error
    /// target 16.
    pub most_substeps: u32,
    /// Multiplications that the factorisations of halved substeps, and of long searches for active sets, may take in a step of an
    /// articulation, in millions, 0 to 1e6; default 10. Once they are spent, joints may stay open until a later step, and contacts
    /// are swept; energy does not grow. An island of joints and contacts is solved as one problem if a few factorisations of it a
    /// substep are within this.
    pub halving_budget: f32,
}

impl From<LsArticulationSettings> for ArticulationSettings {
    fn from(settings: LsArticulationSettings) -> Self {
        Self {
            error_target: settings.error_target,
            most_substeps: settings.most_substeps,
            halving_budget: settings.halving_budget,
        }
    }
}

/// Everything a world starts with. Fill it with ls_world_def_init first.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsWorldDef {
    /// Size of this struct in the host, set by ls_world_def_init.
    pub struct_size: u32,
    /// Gravity (m/s^2); default 0, -9.81, 0.
    pub gravity: [f32; 3],
    /// Substeps a step, 1 to 256; default 4. More is more accurate and slower. Articulations that move by themselves take as many as their
    /// errors ask for, and islands in which jointed bodies carry loads smoothly half of them, from four on, where no error target is set.
    pub substeps: u32,
    /// Sweeps a substep, 1 to 256; default 2.
    pub iterations: u32,
    /// LS_SOLVER_ constant; default LS_SOLVER_AUTO.
    pub solver: i32,
    /// Threads that step the world, the calling one included, 1 to 64; default 1. Results are the same bits for any number.
    pub threads: u32,
    /// When bodies fall asleep.
    pub sleep: LsSleepSettings,
    /// Approach speed below which nothing bounces (m/s), >= 0; default 1.
    pub restitution_threshold: f32,
    /// Number of bodies, of one shape each, to reserve memory for; a hint; default 0.
    pub body_capacity: u32,
    /// Number of joints to reserve memory for; a hint; default 0.
    pub joint_capacity: u32,
    /// Not used; 0.
    pub reserved: u32,
    /// Not 0: groups that stand still on supporting contacts are held where they are until anything touches them; default 1.
    pub hold: u32,
    /// Not 0: every step ends with the support analysis, as after ls_support_enabled_set; default 0.
    pub support: u32,
    /// Approach speed above which contacts are listed by ls_world_hits_get (m/s), >= 0; default INFINITY, which is never and costs
    /// nothing.
    pub hit_threshold: f32,
    /// Whether and how fast joints break.
    pub fracture: LsFractureSettings,
    /// Not 0: the support analysis also finds what stands by thrust: arches, leaning cards, wedges; default 0.
    pub support_by_thrust: u32,
}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsWorldDef {
    const SIZES: &'static [usize] = &[64, 72, 76, 84, 88];
}

// SAFETY: begins with struct_size.
unsafe impl Definition for LsWorldDef {}

impl Default for LsWorldDef {
    fn default() -> Self {
        (&WorldDef::default()).into()
    }
}

/// Fills a world definition with defaults.
///
/// @param def   filled on LS_OK
/// @param size  sizeof *def as the host knows it
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_def_init(def: *mut LsWorldDef, size: usize) -> LsResult {
    call("ls_world_def_init", || host!(SizedOut::new, def, size).write_definition(&LsWorldDef::default()))
}

impl From<LsSleepSettings> for SleepSettings {
    fn from(settings: LsSleepSettings) -> Self {
        Self {
            enabled: settings.enabled != 0,
            linear_speed: settings.linear_speed,
            angular_speed: settings.angular_speed,
            time: settings.time,
        }
    }
}

impl TryFrom<LsWorldDef> for WorldDef {
    type Error = Failure;
    fn try_from(def: LsWorldDef) -> Outcome<Self> {
        Ok(Self {
            gravity: Vec3::from_array(def.gravity),
            substeps: def.substeps,
            iterations: def.iterations,
            solver: enums::solver(def.solver)?,
            threads: def.threads,
            sleep: def.sleep.into(),
            restitution_threshold: def.restitution_threshold,
            hit_threshold: def.hit_threshold,
            hold: def.hold != 0,
            support: def.support != 0,
            body_capacity: def.body_capacity,
            joint_capacity: def.joint_capacity,
            fracture: def.fracture.into(),
            support_by_thrust: def.support_by_thrust != 0,
            ..Self::default()
        })
    }
}

impl From<&WorldDef> for LsWorldDef {
    fn from(def: &WorldDef) -> Self {
        Self {
            struct_size: size_of::<Self>() as u32,
            gravity: def.gravity.to_array(),
            substeps: def.substeps,
            iterations: def.iterations,
            solver: enums::from_solver(def.solver),
            threads: def.threads,
            sleep: LsSleepSettings {
                enabled: def.sleep.enabled.into(),
                linear_speed: def.sleep.linear_speed,
                angular_speed: def.sleep.angular_speed,
                time: def.sleep.time,
            },
            restitution_threshold: def.restitution_threshold,
            body_capacity: def.body_capacity,
            joint_capacity: def.joint_capacity,
            reserved: 0,
            hold: def.hold.into(),
            support: def.support.into(),
            hit_threshold: def.hit_threshold,
            fracture: def.fracture.into(),
            support_by_thrust: def.support_by_thrust.into(),
        }
    }
}

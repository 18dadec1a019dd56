//! Settings of a world.

use glam::Vec3;

use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::fracture::FractureSettings;
use crate::long_range::LongRangeDef;

/// How joints are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Solver {
    /// The library's choice for each island.
    #[default]
    Auto,
    /// Sweeps over all rows.
    GaussSeidel,
    /// One sparse direct solve for each group of joints.
    Direct,
}

/// When bodies fall asleep: an island sleeps once all its bodies have been slower than this for a while and nothing in it is going anywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SleepSettings {
    /// Whether anything may sleep.
    pub enabled: bool,
    /// Linear speed below which a body is quiet (m/s), ≥ 0.
    pub linear_speed: f32,
    /// Angular speed below which a body is quiet (rad/s), ≥ 0.
    pub angular_speed: f32,
    /// How long an island must be quiet (s), ≥ 0.
    pub time: f32,
}

impl Default for SleepSettings {
    fn default() -> Self {
        Self { enabled: true, linear_speed: 0.05, angular_speed: 0.1, time: 0.5 }
    }
}

/// How much work articulations may take: bodies that joints connect and that are solved at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArticulationSettings {
    /// How far any body of a smooth articulation may be from its exact path after about a second (m), ≥ 0; the engine chooses its
    /// substeps for that, up to `most_substeps`. Zero: about a thousandth of its extent, as the mean over its mass.
    pub error_target: f32,
    /// Most substeps of a smooth articulation over those of the world, up to 64; the least is one a step. Zero: 4, with an error
    /// target 16.
    pub most_substeps: u32,
    /// Multiplications that halved substeps, and long searches for active sets, may take in a step of an articulation, in millions,
    /// 0 to 1e6. Once they are spent, joints may stay open until a later step, and contacts are swept; energy does not grow. An island of joints
    /// and contacts is solved as one problem if a few factorisations of it a substep are within this.
    pub halving_budget: f32,
}

impl Default for ArticulationSettings {
    fn default() -> Self {
        Self { error_target: 0.0, most_substeps: 0, halving_budget: 10.0 }
    }
}

impl ArticulationSettings {
    /// Most substeps of a smooth articulation over those of the world.
    pub(crate) fn ceiling(&self) -> u32 {
        match self.most_substeps {
            0 if self.error_target > 0.0 => 16,
            0 => 4,
            asked => asked,
        }
    }
}

/// Most substeps of an articulation over those of the world.
const MAX_SUBSTEPS_RANGE: u32 = 64;

/// Most millions of multiplications for halved substeps.
const MAX_HALVING_BUDGET: f32 = 1.0e6;

/// Most substeps of a step and iterations of a substep.
pub const MAX_EFFORT: u32 = 256;

/// Most threads of a world.
pub const MAX_THREADS: u32 = 64;

/// Everything a world starts with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldDef {
    /// Acceleration of free fall (m/s²).
    pub gravity: Vec3,
    /// Substeps of a step, 1 to 256. Articulations that move by themselves take as many as their errors ask for, and islands in which
    /// jointed bodies carry loads smoothly half of them, from four on, where no error target is set.
    pub substeps: u32,
    /// Sweeps over all rows in a substep, 1 to 256.
    pub iterations: u32,
    /// How joints are solved.
    pub solver: Solver,
    /// How much work articulations may take.
    pub articulations: ArticulationSettings,
    /// Threads of a step, 1 to 64, the calling one among them; results are the same bits for any number.
    pub threads: u32,
    /// When bodies fall asleep.
    pub sleep: SleepSettings,
    /// What is derived from the joints.
    pub long_range: LongRangeDef,
    /// Whether and how fast joints break.
    pub fracture: FractureSettings,
    /// Approach speed above which contacts rebound (m/s), ≥ 0.
    pub restitution_threshold: f32,
    /// Approach speed above which contacts are listed as hits (m/s), ≥ 0; infinity, the default, for never, which costs nothing.
    pub hit_threshold: f32,
    /// Whether islands that stand still on supporting contacts, and jointed bodies that lie still among others, are held where they are
    /// until anything else bears on them.
    pub hold: bool,
    /// Whether every step ends with the support analysis: which bodies are held up, and by what. Costs nothing if not.
    pub support: bool,
    /// Whether the analysis also finds what stands by thrust: arches, leaning cards, wedges. Costs nothing if not.
    pub support_by_thrust: bool,
    /// Bodies, of one shape each, to reserve memory for.
    pub body_capacity: u32,
    /// Joints to reserve memory for.
    pub joint_capacity: u32,
}

impl Default for WorldDef {
    fn default() -> Self {
        Self {
            gravity: Vec3::new(0.0, -9.81, 0.0),
            substeps: 4,
            iterations: 2,
            solver: Solver::Auto,
            articulations: ArticulationSettings::default(),
            threads: 1,
            sleep: SleepSettings::default(),
            long_range: LongRangeDef::default(),
            fracture: FractureSettings::default(),
            restitution_threshold: 1.0,
            hit_threshold: f32::INFINITY,
            hold: true,
            support: false,
            support_by_thrust: false,
            body_capacity: 0,
            joint_capacity: 0,
        }
    }
}

/// Most bodies or joints that memory is reserved for in advance.
const MAX_CAPACITY_HINT: u32 = 1 << 20;

impl WorldDef {
    pub(crate) fn check(&self) -> Result<()> {
        check::finite_vec("gravity", self.gravity)?;
        let within = |argument, value: u32, max| {
            if (1..=max).contains(&value) {
                Ok(())
            } else {
                Err(Error::new(ErrorKind::OutOfRange, argument, "is zero or too large"))
            }
        };
        within("substeps", self.substeps, MAX_EFFORT)?;
        within("iterations", self.iterations, MAX_EFFORT)?;
        within("threads", self.threads, MAX_THREADS)?;
        if self.articulations.most_substeps > MAX_SUBSTEPS_RANGE {
            return Err(Error::new(ErrorKind::OutOfRange, "articulations.most_substeps", "is above 64"));
        }
        check::not_negative("articulations.error_target", self.articulations.error_target)?;
        check::not_negative("articulations.halving_budget", self.articulations.halving_budget)?;
        if self.articulations.halving_budget > MAX_HALVING_BUDGET {
            return Err(Error::new(ErrorKind::OutOfRange, "articulations.halving_budget", "is above 1e6"));
        }
        if self.body_capacity > MAX_CAPACITY_HINT || self.joint_capacity > MAX_CAPACITY_HINT {
            return Err(Error::new(ErrorKind::OutOfRange, "body_capacity", "capacity hints go up to 1048576"));
        }
        check::not_negative("sleep.linear_speed", self.sleep.linear_speed)?;
        check::not_negative("sleep.angular_speed", self.sleep.angular_speed)?;
        check::not_negative("sleep.time", self.sleep.time)?;
        self.long_range.check()?;
        self.fracture.check()?;
        check::not_negative("restitution_threshold", self.restitution_threshold)?;
        check::bound("hit_threshold", self.hit_threshold)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ceiling_follows_from_the_error_target_unless_it_is_given() {
        let ceiling = |error_target, most_substeps| {
            ArticulationSettings { error_target, most_substeps, ..ArticulationSettings::default() }.ceiling()
        };
        assert_eq!([ceiling(0.0, 0), ceiling(1e-3, 0), ceiling(0.0, 64), ceiling(1e-3, 1)], [4, 16, 64, 1]);
        let mut def = WorldDef::default();
        def.articulations.most_substeps = 65;
        let refused = def.check().expect_err("65 is out of range");
        assert_eq!((refused.argument, refused.problem), ("articulations.most_substeps", "is above 64"));
    }
}

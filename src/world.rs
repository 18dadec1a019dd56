//! A world of bodies, and the step that moves it.
//!
//! [`World::step`] is the whole pipeline as a table of contents; each line is a stage in a file of its own under `world/`.
//! Nothing below this module knows `World`: stages hand plain arrays to `collide` and `solve` and take plain arrays back.

use std::ffi::CStr;
use std::sync::Arc;

use crate::body::Body;
use crate::check;
use crate::collide::broad::BroadPhase;
use crate::collide::cache::PairCache;
use crate::collide::collider::Collider;
use crate::collide::pairs::{PairKey, PairScratch};
use crate::error::Result;
use crate::id::{BodyId, JointId, Pool, ShapeId, WorldTag};
use crate::island::{SleepingIslands, UnionFind};
use crate::joint_record::Joint;
use crate::platform::Moment;
use crate::report::{Events, StepReport};
use crate::settings::WorldDef;
use crate::solve::batch::Batch;
use crate::solve::step::BatchStages;
use crate::workers::{ParallelFor, Workers};

mod always_overlap;
mod assign_constraints;
mod bodies;
mod body_shape_table;
mod body_summary;
pub(crate) mod cells;
mod chain;
mod contacts;
mod crowds;
mod draw;
mod drift;
mod driven_ways;
mod drives;
mod fast;
mod forces;
mod fracture;
mod getters;
mod hold;
mod idle_joints;
mod islands;
mod joints;
mod long_range;
mod pairs;
mod planes;
mod query;
mod seams;
mod sensors;
mod setters;
mod shapes;
mod sleep;
mod snapshot;
mod solve_batches;
mod step_skip;
mod substep_multiplier;
mod support;
mod surface_energy;
mod touching_pairs;
mod union_loads;
mod union_query;
mod unions;
mod wake;
#[cfg(test)]
mod warm_start_tests;
mod write_back;

pub use union_query::UnionInfo;

/// Bodies, shapes and joints that act on each other, and nothing else.
pub struct World {
    def: WorldDef,
    bodies: Pool<Body, BodyId>,
    colliders: Pool<Collider, ShapeId>,
    joints: Pool<Joint, JointId>,
    movers: Movers,
    collision: Collision,
    unions: unions::Unions,
    long_range: long_range::LongRange,
    islands: Islands,
    batches: Batches,
    rest: step_skip::StepSkip,
    fracture: fracture::Fracture,
    /// The support analysis, where the host wants it.
    support: Option<Box<support::SupportState>>,
    events: Events,
    report: StepReport,
    last: LastStep,
    scratch: StepScratch,
    threads: Workers,
    profiler: Option<Arc<dyn Profiler>>,
    /// Last, so that the world's number is free again only when everything else is gone.
    _tag: WorldTag,
}

/// What a step may move.
#[derive(Default)]
struct Movers {
    /// Bodies, by slot.
    slots: Vec<u32>,
    are_sorted: bool,
    /// Whether some of those that are sorted are kinematic: they stop being movers without a word.
    some_are_driven: bool,
    /// Bodies that moved until fixed joints came to hold them to something static in this step.
    stopped: Vec<u32>,
    /// Joints whose stops or frames the host has moved of late.
    driven_joints: Vec<u32>,
}

/// What touches what.
#[derive(Default)]
struct Collision {
    broad: BroadPhase,
    escaped: query::OutOfBoxBodies,
    pairs: PairCache,
    touches: touching_pairs::TouchingPairs,
    index: body_shape_table::BodyShapeTable,
    sensing: sensors::Sensors,
}

/// Bodies that act on each other, and which of them sleep or stand still.
#[derive(Default)]
struct Islands {
    groups: islands::IslandGroups,
    summaries: body_summary::BodySummaries,
    sleeping: SleepingIslands,
    hold: hold::Hold,
}

/// What is solved together.
#[derive(Default)]
struct Batches {
    /// Those of this step are the first `count`.
    list: Vec<Batch>,
    /// Of each batch, what the stages of its step keep.
    stages: Vec<BatchStages>,
    count: usize,
}

/// What the next step takes from the last one.
#[derive(Default)]
struct LastStep {
    /// Length of the last substep (s), for rescaling multipliers.
    substep: f32,
    dt: f32,
    /// Whether any body may have been smooth for so long that its island takes several substeps at once.
    has_smooth_bodies: bool,
    /// Bodies that this step gave a non-finite state.
    broken: Vec<u32>,
}

/// Buffers that steps reuse.
#[derive(Default)]
struct StepScratch {
    candidates: Vec<PairKey>,
    /// For each piece of the pairs.
    pairs: Vec<PairScratch>,
    /// Shapes with another kept box, for each piece of the shapes.
    reboxed: Vec<Vec<u32>>,
    sweeps: fast::Sweeps,
    driven: driven_ways::DrivenWays,
    /// Pairs of which one body moves over the other, for each piece of the pairs.
    glides: Vec<Vec<seams::Glide>>,
    seams: seams::Seams,
    /// Balls that press on surfaces of triangles, for each piece of the pairs and in order.
    found_balls: Vec<Vec<surface_energy::BallOnSurface>>,
    balls_on_surfaces: Vec<surface_energy::BallOnSurface>,
    /// Sizes and numbers of the batches that one thread each goes through, the largest first.
    batch_order: Vec<(usize, u32)>,
    /// What is noted of bodies, and of joints, for each piece of a batch.
    noted: Vec<write_back::bodies::BodyNotes>,
    noted_joints: Vec<write_back::joints::JointNotes>,
    /// Pairs whose contact may have begun or ended.
    changed: Vec<u32>,
    /// What of each part of the pairs that touch is of other batches than the largest.
    others: Vec<Vec<u32>>,
    /// How much faster each body of a crowd may become, by slot (m/s).
    blows: Vec<f32>,
    /// Forces of the manifolds of a batch.
    pulls: Vec<write_back::contacts::Pull>,
    runs: write_back::runs::Runs,
    slots: Vec<u32>,
    islands: UnionFind,
}

impl World {
    /// Makes an empty world.
    ///
    /// # Errors
    /// Names the field of `def` that is out of range; [`CapacityExceeded`](crate::ErrorKind::CapacityExceeded) when 1023 worlds are alive.
    pub fn new(def: &WorldDef) -> Result<Self> {
        def.check()?;
        let tag = WorldTag::acquire()?;
        let threads = Workers::new(def.threads)?;
        let mut world = Self {
            def: *def,
            bodies: Pool::new(&tag),
            colliders: Pool::new(&tag),
            joints: Pool::new(&tag),
            movers: Movers { are_sorted: true, ..Movers::default() },
            collision: Collision::default(),
            unions: unions::Unions::default(),
            long_range: long_range::LongRange::default(),
            islands: Islands::default(),
            batches: Batches::default(),
            rest: step_skip::StepSkip::default(),
            fracture: fracture::Fracture::default(),
            support: None,
            events: Events::default(),
            report: StepReport::default(),
            last: LastStep::default(),
            scratch: StepScratch::default(),
            threads,
            profiler: None,
            _tag: tag,
        };
        world.bodies.reserve(def.body_capacity as usize);
        world.colliders.reserve(def.body_capacity as usize);
        world.joints.reserve(def.joint_capacity as usize);
        world.set_support(def.support);
        Ok(world)
    }

    /// Moves everything on by `dt` seconds.
    ///
    /// # Errors
    /// `dt` outside 1e-6 … 1 s; nothing has moved then.
    pub fn step(&mut self, dt: f32) -> Result<&StepReport> {
        check::step_length(dt)?;
        let _watch = Workers::watch(&self.threads);
        let mut clock = Clock::start(self.profiler.clone());
        clock.enter(c"find pairs");
        self.begin_step(dt);
        self.form_unions(dt);
        self.drive_joints(dt);
        let stirs = self.stirs();
        if stirs {
            self.find_pairs(dt);
        }
        self.report.timings.broad_phase = clock.lap();
        clock.enter(c"update contacts");
        if stirs {
            self.update_contacts(dt);
        }
        self.report.timings.narrow_phase = clock.lap();
        clock.enter(c"group islands");
        if stirs {
            self.note_approaches();
            self.wake_what_is_touched();
            self.group_islands();
        }
        self.report.timings.islands = clock.lap();
        clock.enter(c"derive long range");
        if stirs {
            self.derive_long_range();
            self.hand_out_bounds();
        }
        self.report.timings.long_range = clock.lap();
        clock.enter(c"solve");
        self.solve_batches(dt);
        self.read_joint_loads(dt);
        if stirs {
            self.meet_what_is_driven_into(dt);
        }
        self.break_overloaded(dt);
        self.report.timings.solve = clock.lap();
        clock.enter(c"finish");
        self.store_results(dt);
        self.follow_idle_angles();
        self.stop_fast_bodies();
        self.keep_energy_on_surfaces(dt);
        self.report_splits();
        self.prepare_support();
        if stirs {
            self.report_contacts();
            self.report_hits();
        }
        self.sense();
        self.put_quiet_islands_to_sleep(dt);
        self.list_moved(stirs);
        clock.enter(c"judge support");
        self.judge_support();
        self.note_rest();
        self.report.timings.finish = clock.lap();
        self.report.timings.total = clock.total();
        Ok(&self.report)
    }

    fn begin_step(&mut self, dt: f32) {
        self.events.begin_step();
        self.movers.stopped.clear();
        self.forget_driven();
        self.forget_escaped();
        let (step, time) = (self.report.step + 1, self.report.time + f64::from(dt));
        self.report = StepReport { step, time, ..StepReport::default() };
        self.break_condemned();
        self.drive_kinematic_bodies(dt);
        self.settle_movers();
    }

    /// Summary of the last step.
    pub fn report(&self) -> &StepReport {
        &self.report
    }

    /// What the world was made with, and what has been set since: gravity, effort, sleep, thresholds, support.
    pub fn def(&self) -> &WorldDef {
        &self.def
    }

    /// Number of this world, as its handles have it.
    pub(crate) fn tag(&self) -> u16 {
        self._tag.number()
    }

    /// Simulated time (s).
    pub fn time(&self) -> f64 {
        self.report.time
    }

    /// Steps taken.
    pub fn step_count(&self) -> u64 {
        self.report.step
    }

    /// Has a job system of the host do the independent parts of steps, or the world's own threads again. The bits of a step do
    /// not depend on it.
    pub fn set_parallel_for(&mut self, jobs: Option<Arc<dyn ParallelFor>>) {
        self.threads.set_host(jobs);
    }

    /// Has the threads of a pool do the independent parts of steps, instead of the world's own, or again so many as the world was made with. From
    /// a step's first part that is shared to its end they do nothing else; where they are busy, the step goes on without them. The bits of
    /// a step do not depend on it.
    ///
    /// # Errors
    /// [`CapacityExceeded`](crate::ErrorKind::CapacityExceeded) when the world asks for threads again and the system gives none.
    pub fn set_thread_pool(&mut self, pool: Option<Arc<rayon::ThreadPool>>) -> Result<()> {
        match pool {
            Some(pool) => self.threads.set_pool(pool),
            None => self.threads.set_own(self.def.threads)?,
        }
        Ok(())
    }

    /// Has a profiler told where steps are, or no longer. The bits of a step do not depend on it.
    pub fn set_profiler(&mut self, profiler: Option<Arc<dyn Profiler>>) {
        self.profiler = profiler;
    }

    /// Acceleration of free fall (m/s²).
    pub fn gravity(&self) -> glam::Vec3 {
        self.def.gravity
    }

    /// Changes gravity (m/s²) and wakes everything.
    ///
    /// # Errors
    /// `gravity` is not finite.
    pub fn set_gravity(&mut self, gravity: glam::Vec3) -> Result<()> {
        if self.def.gravity != check::finite_vec("gravity", gravity)? {
            self.def.gravity = gravity;
            self.wake_all();
            self.release_all();
        }
        Ok(())
    }
}

impl std::fmt::Debug for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("World")
            .field("bodies", &self.bodies.len())
            .field("shapes", &self.colliders.len())
            .field("joints", &self.joints.len())
            .field("step", &self.report.step)
            .finish_non_exhaustive()
    }
}

/// A profiler of the host, which is told where a step is.
pub trait Profiler: Send + Sync {
    /// A zone of this name begins on the calling thread, inside those that have not ended yet.
    fn begin(&self, zone: &'static CStr);
    /// The zone that began last on the calling thread ends.
    fn end(&self, zone: &'static CStr);
}

/// Wall time of the stages of a step, and their zones.
struct Clock {
    start: Moment,
    last: Moment,
    profiler: Option<Arc<dyn Profiler>>,
    inner: Option<&'static CStr>,
}

impl Clock {
    const STEP: &CStr = c"longspan step";

    fn start(profiler: Option<Arc<dyn Profiler>>) -> Self {
        if let Some(profiler) = &profiler {
            profiler.begin(Self::STEP);
        }
        let now = Moment::now();
        Self { start: now, last: now, profiler, inner: None }
    }

    /// Begins the zone of a stage, which ends the one before it.
    fn enter(&mut self, zone: &'static CStr) {
        self.leave();
        if let Some(profiler) = &self.profiler {
            profiler.begin(zone);
            self.inner = Some(zone);
        }
    }

    fn leave(&mut self) {
        if let (Some(profiler), Some(zone)) = (&self.profiler, self.inner.take()) {
            profiler.end(zone);
        }
    }

    fn lap(&mut self) -> f32 {
        let now = Moment::now();
        let lap = now.since(self.last);
        self.last = now;
        lap.as_secs_f32()
    }

    fn total(&self) -> f32 {
        self.last.since(self.start).as_secs_f32()
    }
}

impl Drop for Clock {
    fn drop(&mut self) {
        self.leave();
        if let Some(profiler) = &self.profiler {
            profiler.end(Self::STEP);
        }
    }
}

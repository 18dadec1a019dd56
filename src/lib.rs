//! Rigid-body physics for things that hang, span and stand.
//!
//! A [`World`] holds bodies made of shapes, and joints between them; [`World::step`] moves it on. Units are SI and radians;
//! positions are `f64`, everything else is `f32`; no axis is special, gravity is a vector.
//!
//! ```
//! use longspan::{BodyDef, Pose, Shape, ShapeDef, World, WorldDef, glam::Vec3};
//!
//! let mut world = World::new(&WorldDef::default())?;
//! let ground = Shape::cuboid(Vec3::new(10.0, 0.5, 10.0))?;
//! world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(ShapeDef::new(ground)))?;
//! let cube = Shape::cuboid(Vec3::splat(0.5))?;
//! let body = world.create_body(&BodyDef::dynamic(Pose::at_xyz(0.0, 2.0, 0.0)).with_shape(ShapeDef::new(cube)))?;
//! for _ in 0..120 {
//!     world.step(1.0 / 60.0)?;
//! }
//! assert!((world.pose(body)?.position.y - 0.5).abs() < 1e-3);
//! # Ok::<(), longspan::Error>(())
//! ```
//!
//! Every call checks its arguments in every build: what it refuses is an [`Error`] that names the argument, and nothing has
//! changed. The same calls give the same bits, whatever the number of threads.
//!
//! Inside, arrows point one way: `world` drives `collide` and `solve`, which know bodies, shapes and joints but not the world.
//! No code here knows C; the stable C interface is the crate `longspan-capi`.

#![forbid(unsafe_op_in_unsafe_fn)]

mod body;
mod check;
mod collide;
mod contact;
mod debug;
mod dwell_time;
mod error;
mod fracture;
mod hull;
mod id;
mod island;
mod joint;
mod joint_drive;
mod joint_graph;
mod joint_rebounds;
mod joint_record;
mod kinematic_path;
mod lanes;
mod linalg;
mod load_distribution;
mod long_range;
mod mass;
mod material;
mod motor;
mod platform;
mod pose;
mod prefetch;
mod query;
mod record;
mod report;
mod settings;
mod shape;
mod snapshot;
mod solve;
mod speed_limits;
mod step_history;
mod surface;
mod tight_vec;
mod tuning;
mod workers;
mod world;

pub use body::{BodyDef, BodyKind, LockedAxes};
pub use check::{MAX_COORDINATE, MAX_LEVER, STEP_RANGE};
pub use debug::{Color, DebugDraw, DrawLayers, DrawOptions};
pub use error::{Error, ErrorKind, Result};
pub use fracture::voronoi::{Bond, Cell, Cells, MAX_CELLS, Material as BondMaterial};
pub use fracture::{
    BreakCause, BreakLimit, Damage, FractureSettings, JointBreak, JointLoad, JointStress, MAX_WINDOW, Piece, Split, Strength,
};
pub use glam;
pub use id::{BodyId, Handle, JointId, MAX_OBJECTS, ShapeId};
pub use joint::{
    Axis, Drive, ForceSide, JointAxisState, JointDef, JointKind, JointState, Limits, Motor, Softness, SphericalMotor,
};
pub use joint_graph::support::verdict::{BodySupport, SupportChange, Verdict};
pub use long_range::{
    BoundKind, BoundKindDef, BoundState, ChainLink, ChainState, LongRangeDef, MAX_LEVELS, PlaneState, SoftBound,
};
pub use mass::{MASS_RANGE, Mass, MassProperties};
pub use material::{CombineRule, Material};
pub use pose::Pose;
pub use query::{Cast, Distance, MAX_CAST_TURN, MAX_QUERY_LENGTH, NearestPoint, NearestShape, QueryFilter, Ray, RayHit};
pub use rayon;
pub use record::{Divergence, RecordedWorld, RecordingSink, Replay, Replayed};
pub use report::{
    ArticulationReport, Contact, ContactPair, ContactPoint, Hit, IslandPlan, IslandReport, JointOverload, JointStop, Moved,
    Residuals, StepCounts, StepReport, StepTimings,
};
pub use settings::{ArticulationSettings, MAX_EFFORT, MAX_THREADS, SleepSettings, Solver, WorldDef};
pub use shape::{CollisionFilter, EXTENT_RANGE, Geometry, LocalPose, MAX_HULL_POINTS, Shape, ShapeDef};
pub use speed_limits::{MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED};
pub use workers::ParallelFor;
#[cfg(feature = "trace")]
pub use workers::trace;
pub use world::{Profiler, UnionInfo, World};

//! What a scene is: bodies, joints, a script of actions and the metrics that judge the run.

use std::ops::Range;

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, BodyKind, Geometry, JointDef, JointKind, Mass, MassProperties, Material, Pose, Shape, ShapeDef,
    SleepSettings, WorldDef,
};

use crate::engine::{SceneJoint, SceneSoftBound};
use crate::metrics::Metric;
use crate::params::{Params, SceneError};
use crate::units::Units;

/// Step of every scene unless it says otherwise (s).
pub const DT: f32 = 1.0 / 60.0;

/// Standard gravity as the scenes use it (m/s²).
pub const GRAVITY: f32 = 9.81;

/// A scene, ready to run once.
pub struct Scene {
    /// Name in the catalogue.
    pub name: &'static str,
    /// Every key of the scene with its value, and the common ones that were set.
    pub params: Vec<(String, String)>,
    /// World it runs in.
    pub world: WorldDef,
    /// First step size (s); a script may change it.
    pub dt: f32,
    /// Steps of the whole run.
    pub steps: u32,
    /// Steps whose time counts.
    pub window: Range<u32>,
    /// A second stretch of steps whose median time is reported among the errors, under this name.
    pub second_window: Option<(&'static str, Range<u32>)>,
    /// Where the scene's origin lies in the world (m).
    pub origin: DVec3,
    /// Units that the engine computes in.
    pub units: Units,
    /// Bodies at the start.
    pub bodies: Vec<BodyDef>,
    /// Joints at the start.
    pub joints: Vec<SceneJoint>,
    /// Soft bounds between joints.
    pub soft_bounds: Vec<SceneSoftBound>,
    /// What happens during the run, in order of time.
    pub script: Vec<Scheduled>,
    /// What judges the run; the first error named is the one that pictures show.
    pub metrics: Vec<Box<dyn Metric>>,
    /// Part of the name of the argument that a proper engine refuses in this scene; such a run ends there.
    pub expected_refusal: Option<&'static str>,
    /// Bodies that pictures leave out: walls in front of what matters.
    pub unseen: Vec<usize>,
}

/// An action and when it happens.
pub struct Scheduled {
    /// Done after this many steps.
    pub step: u32,
    /// What is done.
    pub action: Action,
}

/// What a script can do.
pub enum Action {
    /// Adds a body; its index is the next free one.
    Add(BodyDef),
    /// Takes a body out.
    Remove(usize),
    /// Sets the velocity of a body's centre of mass (m/s).
    SetLinearVelocity(usize, Vec3),
    /// Applies an impulse at a body's centre of mass (N·s).
    Push(usize, Vec3),
    /// Pushes a body towards a speed (m/s) along a unit vector, with the impulse that takes within a step up to a force (N).
    PushTo {
        /// The body.
        body: usize,
        /// Direction, unit.
        along: Vec3,
        /// Speed to reach (m/s).
        speed: f32,
        /// Greatest force (N).
        most: f32,
    },
    /// Changes the step size (s).
    SetStep(f32),
    /// Changes gravity (m/s²).
    SetGravity(Vec3),
}

impl Scene {
    /// An empty scene of this length; time counts over its last quarter.
    pub fn new(world: WorldDef, steps: u32) -> Self {
        Self {
            name: "",
            params: Vec::new(),
            world,
            dt: DT,
            steps,
            window: steps - steps.div_ceil(4)..steps,
            second_window: None,
            origin: DVec3::ZERO,
            units: Units::SAME,
            bodies: Vec::new(),
            joints: Vec::new(),
            soft_bounds: Vec::new(),
            script: Vec::new(),
            metrics: Vec::new(),
            expected_refusal: None,
            unseen: Vec::new(),
        }
    }

    /// Adds a body, its mass computed here once for every engine.
    pub fn body(&mut self, def: BodyDef) -> usize {
        self.bodies.push(with_computed_mass(def));
        self.bodies.len() - 1
    }

    /// Adds a joint between two bodies or a body and the world.
    pub fn joint(&mut self, a: Option<usize>, b: Option<usize>, def: JointDef) -> usize {
        self.joints.push(SceneJoint { a, b, def });
        self.joints.len() - 1
    }

    /// Schedules an action; actions of one step happen in the order in which they were scheduled.
    pub fn at(&mut self, step: u32, action: Action) {
        let action = match action {
            Action::Add(def) => Action::Add(with_computed_mass(def)),
            other => other,
        };
        self.script.push(Scheduled { step, action });
        self.script.sort_by_key(|scheduled| scheduled.step);
    }

    /// Adds a metric.
    pub fn judge(&mut self, metric: impl Metric + 'static) {
        self.metrics.push(Box::new(metric));
    }
}

/// A world in which nothing sleeps.
pub fn sleepless() -> WorldDef {
    WorldDef { sleep: SleepSettings { enabled: false, ..SleepSettings::default() }, ..WorldDef::default() }
}

/// A sleepless world without gravity.
pub(crate) fn weightless() -> WorldDef {
    WorldDef { gravity: Vec3::ZERO, ..sleepless() }
}

/// A sleepless world with the common keys applied, and the number of steps of `seconds` or what the user set.
pub(crate) fn start(params: &mut Params, seconds: f64) -> Result<Scene, SceneError> {
    start_in(sleepless(), params, seconds)
}

pub(crate) fn start_in(mut world: WorldDef, params: &mut Params, seconds: f64) -> Result<Scene, SceneError> {
    params.apply_common(&mut world)?;
    let steps = params.steps(seconds, DT)?;
    Ok(Scene::new(world, steps))
}

/// A sleepless world and scene of `seconds`, stepped at the key `rate` (1/s), which is returned too.
pub(crate) fn start_at_rate(params: &mut Params, seconds: f64) -> Result<(Scene, f64), SceneError> {
    let rate = params.number("rate", 60.0, 1.0..=1.0e4)?;
    let mut world = sleepless();
    params.apply_common(&mut world)?;
    let dt = (1.0 / rate) as f32;
    let steps = params.steps(seconds, dt)?;
    Ok((Scene { dt, ..Scene::new(world, steps) }, rate))
}

/// One shape with default surface and density.
pub(crate) fn shape(geometry: Geometry) -> Result<ShapeDef, SceneError> {
    Ok(ShapeDef::new(Shape::new(geometry)?))
}

/// A box of half the given edges (m).
pub(crate) fn cuboid(x: f32, y: f32, z: f32) -> Result<ShapeDef, SceneError> {
    shape(Geometry::Box { half_extents: Vec3::new(x, y, z) })
}

/// A ball.
pub(crate) fn ball(radius: f32) -> Result<ShapeDef, SceneError> {
    shape(Geometry::Ball { radius })
}

/// The same shape with another friction coefficient.
pub(crate) fn with_friction(shape: ShapeDef, friction: f32) -> ShapeDef {
    ShapeDef { material: Material { friction, ..shape.material }, ..shape }
}

/// A static box whose top face lies at height `top` (m).
pub(crate) fn floor(half_width: f32, top: f64, friction: f32) -> Result<BodyDef, SceneError> {
    let shape = with_friction(cuboid(half_width, 0.5, half_width)?, friction);
    Ok(BodyDef::fixed(Pose::at_xyz(0.0, top - 0.5, 0.0)).with_shape(shape))
}

/// A spherical joint at these points of the two bodies (m).
pub(crate) fn spherical(on_a: Vec3, on_b: Vec3) -> JointDef {
    JointDef::new(JointKind::SPHERICAL, BodyId::NULL, BodyId::NULL).at(on_a, on_b)
}

/// A joint with these points on the two bodies (m) and its axis along z of both.
pub(crate) fn about_z(kind: JointKind, on_a: Vec3, on_b: Vec3) -> JointDef {
    let x_to_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    let mut def = JointDef::new(kind, BodyId::NULL, BodyId::NULL).at(on_a, on_b);
    def.frame_a.rotation = x_to_z;
    def.frame_b.rotation = x_to_z;
    def
}

/// Replaces the mass of a dynamic body of one shape by its properties, so that every engine gets the same numbers.
fn with_computed_mass(def: BodyDef) -> BodyDef {
    match computed_mass(&def) {
        Some(properties) => def.with_mass(Mass::Properties(properties)),
        None => def,
    }
}

fn computed_mass(def: &BodyDef) -> Option<MassProperties> {
    let [shape] = &def.shapes[..] else { return None };
    if def.kind != BodyKind::Dynamic {
        return None;
    }
    let of_shape = shape.shape.mass_properties(shape.density)?;
    let factor = match def.mass {
        Mass::FromShapes => 1.0,
        Mass::Total(total) => total / of_shape.mass,
        Mass::Properties(_) => return None,
    };
    let (offset, turn) = (shape.local_pose.position, shape.local_pose.rotation);
    Some(MassProperties {
        mass: of_shape.mass * factor,
        center_of_mass: offset + turn * of_shape.center_of_mass,
        principal_inertia: of_shape.principal_inertia * factor,
        inertia_frame: (turn * of_shape.inertia_frame).normalize(),
    })
}

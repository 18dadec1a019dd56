//! An engine that computes in other units: the same scene larger, slower or heavier, with nothing in the scene or its metrics aware of it.
//!
//! Every length is multiplied by `length`, every time by `time` and every mass by `mass`; a speed is then multiplied by
//! `length / time`, a force by `mass × length / time²` and so on. Mechanics does not know its units, so the motion must be the same
//! one. What an engine makes of it beside that comes from thresholds in SI units.
//!
//! With `time = √length` gravity is still that of the earth: the scene is built at another size on the same ground.

use longspan::glam::{DVec3, Vec3};
use longspan::{
    Axis, BodyDef, BoundState, Drive, Geometry, JointDef, JointKind, Limits, Mass, MassProperties, Material, Motor, Pose, Shape,
    ShapeDef, SoftBound, Softness, SphericalMotor, Strength,
};

use crate::engine::{Engine, SceneJoint, SceneSoftBound};
use crate::params::{Params, SceneError};
use crate::run::RunError;

/// What one metre, one second and one kilogram of a scene are for the engine, and how many steps it takes for one of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    /// Length of the scene's metre (m).
    pub length: f32,
    /// Length of the scene's second (s).
    pub time: f32,
    /// The scene's kilogram (kg).
    pub mass: f32,
    /// Steps of the engine for one of the scene.
    pub steps: u32,
}

impl Units {
    /// Those of the scene itself.
    pub const SAME: Self = Self { length: 1.0, time: 1.0, mass: 1.0, steps: 1 };

    /// What the keys `scale`, `slow`, `heavy` and `finer` say; masses follow the cube of the scale, so that densities stay.
    pub(crate) fn of(params: &mut Params) -> Result<Self, SceneError> {
        let [scale, slow, heavy] = params.factors(["scale", "slow", "heavy"], 1.0e-4..=1.0e4)?.map(|factor| factor as f32);
        let [finer] = params.factors(["finer"], 1.0..=64.0)?;
        Ok(Self { length: scale, time: slow, mass: heavy * scale * scale * scale, steps: finer as u32 })
    }

    fn speed(self) -> f32 {
        self.length / self.time
    }

    fn acceleration(self) -> f32 {
        self.length / (self.time * self.time)
    }

    fn force(self) -> f32 {
        self.mass * self.acceleration()
    }

    fn torque(self) -> f32 {
        self.force() * self.length
    }

    fn pose(self, pose: Pose) -> Pose {
        Pose { position: pose.position * f64::from(self.length), ..pose }
    }

    fn body(self, def: &BodyDef) -> BodyDef {
        let mut body = def.clone();
        body.pose = self.pose(def.pose);
        body.linear_velocity *= self.speed();
        body.angular_velocity /= self.time;
        body.linear_damping /= self.time;
        body.angular_damping /= self.time;
        body.mass = match def.mass {
            Mass::FromShapes => Mass::FromShapes,
            Mass::Total(mass) => Mass::Total(mass * self.mass),
            Mass::Properties(properties) => Mass::Properties(self.properties(properties)),
        };
        body.shapes = def.shapes.iter().map(|shape| self.shape(shape)).collect();
        body
    }

    fn properties(self, of: MassProperties) -> MassProperties {
        MassProperties {
            mass: of.mass * self.mass,
            center_of_mass: of.center_of_mass * self.length,
            principal_inertia: of.principal_inertia * (self.mass * self.length * self.length),
            inertia_frame: of.inertia_frame,
        }
    }

    fn shape(self, def: &ShapeDef) -> ShapeDef {
        let mut shape = def.clone();
        if self.length != 1.0 {
            shape.shape = Shape::new(self.geometry(def.shape.geometry())).expect("a form of another size");
        }
        shape.local_pose.position *= self.length;
        shape.density *= self.mass / (self.length * self.length * self.length);
        shape.material = Material {
            rolling_friction: def.material.rolling_friction * self.length,
            spinning_friction: def.material.spinning_friction * self.length,
            ..def.material
        };
        shape
    }

    fn geometry(self, of: &Geometry) -> Geometry {
        let scale = self.length;
        let all = |points: &[Vec3]| points.iter().map(|&point| point * scale).collect();
        let mut geometry = of.clone();
        match &mut geometry {
            Geometry::Ball { radius } => *radius *= scale,
            Geometry::Box { half_extents } => *half_extents *= scale,
            Geometry::Capsule { half_height, radius }
            | Geometry::Cylinder { half_height, radius }
            | Geometry::Cone { half_height, radius } => (*half_height, *radius) = (*half_height * scale, *radius * scale),
            Geometry::ConvexHull { points } => *points = all(points),
            Geometry::TriangleMesh { vertices, .. } => *vertices = all(vertices),
            Geometry::HeightField { heights, size_x, size_z, .. } => {
                heights.iter_mut().for_each(|height| *height *= scale);
                (*size_x, *size_z) = (*size_x * scale, *size_z * scale);
            }
            Geometry::Compound { parts } => {
                for (place, part) in parts {
                    place.position *= scale;
                    *part = self.geometry(part);
                }
            }
            _ => {}
        }
        geometry
    }

    /// Give of what holds a coordinate whose unit is multiplied by `unit`, and its force by `force`.
    fn softness(self, of: Softness, [unit, force]: [f32; 2]) -> Softness {
        Softness { compliance: of.compliance * unit / force, damping: of.damping * force * self.time / unit }
    }

    fn along(self) -> [f32; 2] {
        [self.length, self.force()]
    }

    fn about(self) -> [f32; 2] {
        [1.0, self.torque()]
    }

    fn limits(of: Limits, [unit, _]: [f32; 2]) -> Limits {
        Limits { min: of.min * unit, max: of.max * unit }
    }

    fn motor(self, of: Motor, [unit, force]: [f32; 2]) -> Motor {
        match of {
            Motor::Off => Motor::Off,
            Motor::Velocity { target, max_force } => {
                Motor::Velocity { target: target * unit / self.time, max_force: max_force * force }
            }
            Motor::Position { target, softness, max_force } => Motor::Position {
                target: target * unit,
                softness: self.softness(softness, [unit, force]),
                max_force: max_force * force,
            },
            Motor::Drive(drive) => Motor::Drive(Drive {
                target: drive.target.map(|target| target * unit),
                velocity: drive.velocity * unit / self.time,
                softness: self.softness(drive.softness, [unit, force]),
                max_force: drive.max_force * force,
                max_speed: drive.max_speed * unit / self.time,
                side: drive.side,
            }),
        }
    }

    fn spherical_motor(self, of: SphericalMotor) -> SphericalMotor {
        match of {
            SphericalMotor::Off => SphericalMotor::Off,
            SphericalMotor::Velocity { target, max_torque } => {
                SphericalMotor::Velocity { target: target / self.time, max_torque: max_torque * self.torque() }
            }
            SphericalMotor::Position { target, softness, max_torque } => SphericalMotor::Position {
                target,
                softness: self.softness(softness, self.about()),
                max_torque: max_torque * self.torque(),
            },
        }
    }

    fn kind(self, of: JointKind) -> JointKind {
        let (along, about) = (self.along(), self.about());
        let axis = |axis: Axis, on: [f32; 2]| Axis { limits: Self::limits(axis.limits, on), motor: self.motor(axis.motor, on) };
        match of {
            JointKind::Hinge { limits, motor } => JointKind::Hinge { limits, motor: self.motor(motor, about) },
            JointKind::Spherical { swing_limit, twist_limits, motor } => {
                JointKind::Spherical { swing_limit, twist_limits, motor: self.spherical_motor(motor) }
            }
            JointKind::Distance { limits, spring_length, motor } => JointKind::Distance {
                limits: Self::limits(limits, along),
                spring_length: spring_length.map(|length| length * self.length),
                motor: self.motor(motor, along),
            },
            JointKind::Prismatic { limits, motor } => {
                JointKind::Prismatic { limits: Self::limits(limits, along), motor: self.motor(motor, along) }
            }
            JointKind::Generic { linear, angular } => {
                JointKind::Generic { linear: linear.map(|one| axis(one, along)), angular: angular.map(|one| axis(one, about)) }
            }
            other => other,
        }
    }

    fn joint(self, def: &JointDef) -> JointDef {
        let mut joint = *def;
        let (force, torque) = (self.force(), self.torque());
        let is_along = matches!(def.kind, JointKind::Prismatic { .. } | JointKind::Distance { .. });
        let free = if is_along { self.along() } else { self.about() };
        joint.kind = self.kind(def.kind);
        (joint.frame_a, joint.frame_b) = (self.pose(def.frame_a), self.pose(def.frame_b));
        joint.linear = self.softness(def.linear, self.along());
        joint.angular = self.softness(def.angular, self.about());
        joint.limit = self.softness(def.limit, free);
        joint.friction *= free[1];
        joint.axis_friction = std::array::from_fn(|axis| def.axis_friction[axis] * if axis < 3 { force } else { torque });
        joint.break_force *= force;
        joint.break_torque *= torque;
        joint.strength = Strength {
            tension: def.strength.tension * force,
            compression: def.strength.compression * force,
            shear: def.strength.shear * force,
            bending: def.strength.bending * torque,
            torsion: def.strength.torsion * torque,
            window: def.strength.window * self.time,
            ..def.strength
        };
        joint
    }
}

/// An engine seen through its [`Units`].
pub struct Converted<'a> {
    engine: &'a mut dyn Engine,
    units: Units,
}

impl<'a> Converted<'a> {
    /// `engine`, with nothing in it yet, in these units, under `gravity` of the scene (m/s²).
    ///
    /// # Errors
    /// If its gravity would have to be another and cannot be changed.
    pub fn new(engine: &'a mut dyn Engine, units: Units, gravity: Vec3) -> Result<Self, RunError> {
        let name = engine.name();
        let mut converted = Self { engine, units };
        if units.acceleration() != 1.0 && !converted.set_gravity(gravity) {
            return Err(RunError::Unsupported { engine: name, feature: "gravity that changes" });
        }
        Ok(converted)
    }
}

impl Engine for Converted<'_> {
    fn name(&self) -> &'static str {
        self.engine.name()
    }

    fn add_body(&mut self, def: &BodyDef) -> usize {
        self.engine.add_body(&self.units.body(def))
    }

    fn remove_body(&mut self, body: usize) {
        self.engine.remove_body(body);
    }

    fn add_joint(&mut self, joint: &SceneJoint) -> usize {
        self.engine.add_joint(&SceneJoint { def: self.units.joint(&joint.def), ..joint.clone() })
    }

    fn add_soft_bound(&mut self, bound: &SceneSoftBound) {
        let softness = self.units.softness(bound.bound.softness, self.units.along());
        self.engine.add_soft_bound(&SceneSoftBound { bound: SoftBound { softness, ..bound.bound }, ..*bound });
    }

    fn step(&mut self, dt: f32) {
        for _ in 0..self.units.steps {
            self.engine.step(dt * self.units.time / self.units.steps as f32);
        }
    }

    fn pose(&self, body: usize) -> Pose {
        let pose = self.engine.pose(body);
        Pose { position: pose.position / f64::from(self.units.length), ..pose }
    }

    fn linear_velocity(&self, body: usize) -> Vec3 {
        self.engine.linear_velocity(body) / self.units.speed()
    }

    fn angular_velocity(&self, body: usize) -> Vec3 {
        self.engine.angular_velocity(body) * self.units.time
    }

    fn set_linear_velocity(&mut self, body: usize, v: Vec3) {
        self.engine.set_linear_velocity(body, v * self.units.speed());
    }

    fn apply_impulse(&mut self, body: usize, impulse: Vec3) {
        self.engine.apply_impulse(body, impulse * (self.units.mass * self.units.speed()));
    }

    fn joint_force(&self, joint: usize) -> Option<Vec3> {
        Some(self.engine.joint_force(joint)? / self.units.force())
    }

    fn joint_torque(&self, joint: usize) -> Option<Vec3> {
        Some(self.engine.joint_torque(joint)? / self.units.torque())
    }

    fn has_joint(&self, joint: usize) -> bool {
        self.engine.has_joint(joint)
    }

    fn contact_force(&self, body: usize) -> Option<Vec3> {
        Some(self.engine.contact_force(body)? / self.units.force())
    }

    fn mass_properties(&self, body: usize) -> Option<MassProperties> {
        let back = Units { length: 1.0 / self.units.length, mass: 1.0 / self.units.mass, ..Units::SAME };
        Some(back.properties(self.engine.mass_properties(body)?))
    }

    fn set_gravity(&mut self, gravity: Vec3) -> bool {
        self.engine.set_gravity(gravity * self.units.acceleration())
    }

    fn refusal(&self) -> Option<String> {
        self.engine.refusal()
    }

    fn is_supported(&self, body: usize) -> Option<bool> {
        self.engine.is_supported(body)
    }

    fn bounds(&self) -> Vec<BoundState> {
        let (length, force) = (self.units.length, self.units.force());
        let point = |point: DVec3| point / f64::from(length);
        let back = |bound: BoundState| BoundState {
            points: bound.points.map(point),
            distance: bound.distance / length,
            upper: bound.upper / length,
            lower: bound.lower / length,
            tension: bound.tension / force,
            ..bound
        };
        self.engine.bounds().into_iter().map(back).collect()
    }

    fn is_awake(&self, body: usize) -> bool {
        self.engine.is_awake(body)
    }
}

#[cfg(test)]
mod tests {
    use crate::{Effort, LongspanEngine, Measurement, build, run};

    /// Scenes with a motor, a spring, friction, a stop, contacts, a chain, a servo, a bound and loads that break.
    const SCENES: [(&str, &str); 12] = [
        ("hinge_motor", "1"),
        ("hinge_servo", "1"),
        ("spring", "2"),
        ("stiff_hinge", "1"),
        ("hinge_limit", "1"),
        ("slope", "1"),
        ("rolling", "1"),
        ("spinning", "1"),
        ("damping", "1"),
        ("hanging_chain", "0.5"),
        ("elevator", "1"),
        ("breaking_beam", "1"),
    ];

    fn measured(scene: &str, seconds: &str, units: &[(&str, &str)]) -> Measurement {
        let keys: Vec<(String, String)> =
            [("seconds", seconds)].iter().chain(units).map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        let scene = build(scene, &keys).expect("a scene");
        let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1).expect("a world");
        run(scene, &mut engine, Effort::Default, 1).expect("a run")
    }

    #[test]
    fn scenes_move_alike_in_other_units() {
        let units = [
            [("scale", "4"), ("slow", "2"), ("heavy", "1")],
            [("scale", "0.25"), ("slow", "0.5"), ("heavy", "1")],
            [("scale", "1"), ("slow", "1"), ("heavy", "1024")],
        ];
        for (scene, seconds) in SCENES {
            let own = measured(scene, seconds, &[]);
            for units in units {
                for (error, other) in own.errors.iter().zip(measured(scene, seconds, &units).errors) {
                    // Errors are per cent, millimetres and the like of what moves metres: a wrong unit is off by a factor of two and more.
                    let bound = 0.01 * error.1.abs() + if error.0.ends_with("_m") { 1.0e-4 } else { 0.1 };
                    let off = (error.1 - other.1).abs();
                    assert!(off < bound, "{scene} {units:?}: {} is {}, not {}, bound {bound}", error.0, other.1, error.1);
                }
            }
        }
    }

    #[test]
    fn finer_steps_are_more_and_shorter() {
        let keys = [("seconds", "1"), ("finer", "4")].map(|(key, value)| (key.to_owned(), value.to_owned()));
        let scene = build("slope", &keys).expect("a scene");
        let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1).expect("a world");
        let measurement = run(scene, &mut engine, Effort::Default, 1).expect("a run");
        let report = engine.world().report();
        assert_eq!((measurement.steps, report.step), (60, 240));
        assert!((report.time - 1.0).abs() < 1.0e-5, "{} s", report.time);
    }
}

//! Jolt, from the sources in the crate `joltc-sys`, through the shim in `jolt_shim.cpp`: ten velocity and two position
//! iterations a collision step, one collision step a step unless more are asked for.

mod ffi;

use glam::{Mat3, Vec3};
use longspan::{BodyDef, BodyKind, Geometry, JointDef, JointKind, LocalPose, Pose, ShapeDef, WorldDef};
use longspan_scenes::{Effort, Engine, SceneJoint};

use self::ffi::{JoltBodyDef, JoltFrame, JoltJointDef, JoltMass, JoltShape, JoltVec3, JoltWorld, JoltWorldDef};
use super::mass::{RigidMass, Unverified};
use super::{checks, parts, unsupported};

const NAME: &str = "jolt";

/// Bound (m) that stands for an open one where the other is finite.
const FAR: f32 = 1.0e6;
/// Angle (rad) that does so for a hinge: at π Jolt takes both bounds for open.
const MAX_STOP: f32 = 0.999 * std::f32::consts::PI;

/// A scene in Jolt.
pub struct Jolt {
    world: *mut JoltWorld,
    /// Whether each body was removed; the shim numbers them as the scene does.
    removed: Vec<bool>,
    joints: usize,
    sleeping: bool,
    unverified: Unverified,
}

impl Jolt {
    /// An empty scene.
    pub fn new(def: &WorldDef, effort: Effort, threads: usize) -> Self {
        let collision_steps = match effort {
            Effort::Default => 1,
            Effort::N(steps) => steps,
        };
        let settings = JoltWorldDef {
            gravity: def.gravity.into(),
            restitution_threshold: def.restitution_threshold,
            collision_steps,
            threads: threads as u32,
            allow_sleeping: def.sleep.enabled,
        };
        // SAFETY: the definition is complete.
        let world = unsafe { ffi::jolt_world_create(&settings) };
        Self { world, removed: Vec::new(), joints: 0, sleeping: def.sleep.enabled, unverified: Unverified::default() }
    }

    /// The number under which the shim knows a body that is still there.
    fn number(&self, body: usize) -> u32 {
        assert!(!self.removed[body], "body {body} was removed from the scene");
        body as u32
    }

    fn read_mass(&self, body: usize) -> RigidMass {
        // SAFETY: `number` lets only living bodies through.
        let mass = unsafe { ffi::jolt_body_mass(self.world, self.number(body)) };
        RigidMass { mass: mass.mass, center: mass.center.into(), inertia: Mat3::from_cols_array(&mass.inertia) }
    }
}

impl Drop for Jolt {
    fn drop(&mut self) {
        // SAFETY: this world was created in `new` and is destroyed only here.
        unsafe { ffi::jolt_world_destroy(self.world) };
    }
}

impl Engine for Jolt {
    fn name(&self) -> &'static str {
        NAME
    }

    fn add_body(&mut self, def: &BodyDef) -> usize {
        let index = self.removed.len();
        let mut settings = body_def(def, self.sleeping);
        if def.kind == BodyKind::Dynamic {
            let mass = self.unverified.resolve(index, def);
            settings.mass = JoltMass { mass: mass.mass, center: mass.center.into(), inertia: mass.inertia.to_cols_array() };
        }
        let shape = body_shape(def);
        // SAFETY: the shape is not null, and Jolt shares its ownership.
        let number = unsafe { ffi::jolt_body_create(self.world, shape.0, &settings) };
        assert_ne!(number, ffi::JOLT_GROUND, "Jolt was set up for no more than 65536 bodies");
        self.removed.push(false);
        index
    }

    fn remove_body(&mut self, body: usize) {
        self.unverified.forget(body);
        let number = self.number(body);
        self.removed[body] = true;
        // SAFETY: the body was alive until here.
        unsafe { ffi::jolt_body_remove(self.world, number) };
    }

    fn add_joint(&mut self, joint: &SceneJoint) -> usize {
        let number = |body: Option<usize>| body.map_or(ffi::JOLT_GROUND, |body| self.number(body));
        let settings = joint_def(number(joint.a), number(joint.b), &joint.def);
        // SAFETY: both bodies are alive or the ground.
        unsafe { ffi::jolt_joint_create(self.world, &settings) };
        self.joints += 1;
        self.joints - 1
    }

    fn step(&mut self, dt: f32) {
        // SAFETY: the world is alive.
        let dropped = unsafe { ffi::jolt_world_step(self.world, dt) };
        assert_eq!(dropped, 0, "Jolt dropped contacts: a buffer of the shim is too small for this scene");
        let mut unverified = std::mem::take(&mut self.unverified);
        unverified.verify(NAME, |body| self.read_mass(body));
    }

    fn pose(&self, body: usize) -> Pose {
        // SAFETY: `number` lets only living bodies through.
        let frame = unsafe { ffi::jolt_body_frame(self.world, self.number(body)) };
        Pose { position: Vec3::from(frame.position).as_dvec3(), rotation: frame.rotation.into() }
    }

    fn linear_velocity(&self, body: usize) -> Vec3 {
        // SAFETY: `number` lets only living bodies through.
        unsafe { ffi::jolt_body_linear_velocity(self.world, self.number(body)) }.into()
    }

    fn angular_velocity(&self, body: usize) -> Vec3 {
        // SAFETY: `number` lets only living bodies through.
        unsafe { ffi::jolt_body_angular_velocity(self.world, self.number(body)) }.into()
    }

    fn set_linear_velocity(&mut self, body: usize, v: Vec3) {
        // SAFETY: `number` lets only living bodies through.
        unsafe { ffi::jolt_body_set_linear_velocity(self.world, self.number(body), v.into()) };
    }

    fn apply_impulse(&mut self, body: usize, impulse: Vec3) {
        // SAFETY: `number` lets only living bodies through.
        unsafe { ffi::jolt_body_add_impulse(self.world, self.number(body), impulse.into()) };
    }

    /// Of the step's last collision step. None for a slider, whose impulses Jolt gives along axes that it does not show.
    fn joint_force(&self, joint: usize) -> Option<Vec3> {
        assert!(joint < self.joints, "the scene has no joint {joint}");
        let mut force = JoltVec3::default();
        // SAFETY: the joint was created; the shim knows if it has gone with one of its bodies.
        unsafe { ffi::jolt_joint_force(self.world, joint as u32, &mut force) }.then(|| force.into())
    }

    fn set_gravity(&mut self, gravity: Vec3) -> bool {
        // SAFETY: the world is alive.
        unsafe { ffi::jolt_world_set_gravity(self.world, gravity.into()) };
        true
    }

    fn is_awake(&self, body: usize) -> bool {
        // SAFETY: `number` lets only living bodies through.
        unsafe { ffi::jolt_body_is_active(self.world, self.number(body)) }
    }
}

fn frame(pose: &Pose) -> JoltFrame {
    JoltFrame { position: pose.position.as_vec3().into(), rotation: pose.rotation.into() }
}

fn body_def(def: &BodyDef, sleeping: bool) -> JoltBodyDef {
    let surface = surface(def);
    let [x, y, z] = def.locked_axes.translation;
    let [about_x, about_y, about_z] = def.locked_axes.rotation;
    let axes = [x, y, z, about_x, about_y, about_z].into_iter().enumerate();
    JoltBodyDef {
        frame: frame(&def.pose),
        linear_velocity: def.linear_velocity.into(),
        angular_velocity: def.angular_velocity.into(),
        mass: JoltMass::default(),
        friction: surface.material.friction,
        restitution: surface.material.restitution,
        linear_damping: def.linear_damping,
        angular_damping: def.angular_damping,
        gravity_factor: def.gravity_scale,
        motion: match def.kind {
            BodyKind::Static => ffi::JOLT_STATIC,
            BodyKind::Kinematic => ffi::JOLT_KINEMATIC,
            BodyKind::Dynamic => ffi::JOLT_DYNAMIC,
        },
        member_of: surface.filter.member_of,
        collides_with: surface.filter.collides_with,
        allowed_axes: axes.map(|(bit, locked)| u8::from(!locked) << bit).sum(),
        continuous: def.fast,
        allow_sleeping: def.can_sleep && sleeping,
    }
}

/// The shape that stands for the surface of the whole body: Jolt has one per body.
fn surface(def: &BodyDef) -> &ShapeDef {
    let [first, others @ ..] = def.shapes.as_slice() else { unsupported(NAME, "a body without shapes") };
    checks::material(NAME, &first.material);
    if others.iter().any(|other| other.material != first.material || other.filter != first.filter) {
        unsupported(NAME, "a body whose shapes differ in material or filter");
    }
    first
}

/// A shape of Jolt's, shared with the bodies made from it.
struct OwnedShape(*mut JoltShape);

impl OwnedShape {
    fn new(shape: *mut JoltShape, what: &str) -> Self {
        if shape.is_null() {
            unsupported(NAME, what);
        }
        Self(shape)
    }
}

impl Drop for OwnedShape {
    fn drop(&mut self) {
        // SAFETY: the shape is not null, and this is its one release.
        unsafe { ffi::jolt_shape_release(self.0) };
    }
}

fn body_shape(def: &BodyDef) -> OwnedShape {
    let mut shapes: Vec<OwnedShape> = def
        .shapes
        .iter()
        .flat_map(|shape| parts::parts(shape).into_iter().map(|(place, geometry)| part_shape(place, geometry)))
        .collect();
    if shapes.len() == 1 {
        return shapes.remove(0);
    }
    let pointers: Vec<*const JoltShape> = shapes.iter().map(|shape| shape.0.cast_const()).collect();
    // SAFETY: the shapes are not null and live until the compound has its own share in them.
    OwnedShape::new(unsafe { ffi::jolt_shape_compound(pointers.as_ptr(), pointers.len()) }, "a body of these shapes")
}

fn part_shape(place: LocalPose, geometry: &Geometry) -> OwnedShape {
    // SAFETY: the shim takes any extents that longspan's own shapes allow; the points live through the call.
    let (place, shape) = unsafe {
        match geometry {
            Geometry::Ball { radius } => (place, ffi::jolt_shape_ball(*radius)),
            Geometry::Box { half_extents } => (place, ffi::jolt_shape_box((*half_extents).into())),
            Geometry::Capsule { half_height, radius } => (place, ffi::jolt_shape_capsule(*half_height, *radius)),
            Geometry::Cylinder { half_height, radius } => (place, ffi::jolt_shape_cylinder(*half_height, *radius)),
            Geometry::ConvexHull { points } => {
                let points: Vec<JoltVec3> = points.iter().copied().map(JoltVec3::from).collect();
                (place, ffi::jolt_shape_hull(points.as_ptr(), points.len()))
            }
            Geometry::HalfSpace { normal } => {
                let (place, half_extents) = parts::ground_box(&place, *normal);
                (place, ffi::jolt_shape_box(half_extents.into()))
            }
            other => unsupported(NAME, parts::name(other)),
        }
    };
    let shape = OwnedShape::new(shape, parts::name(geometry));
    if place == LocalPose::IDENTITY {
        return shape;
    }
    let frame = JoltFrame { position: place.position.into(), rotation: place.rotation.into() };
    // SAFETY: the shape is not null; the placed one has its own share in it.
    OwnedShape::new(unsafe { ffi::jolt_shape_placed(shape.0, frame) }, parts::name(geometry))
}

fn joint_def(a: u32, b: u32, def: &JointDef) -> JoltJointDef {
    checks::joint(NAME, def);
    let drive = match def.kind {
        JointKind::Hinge { motor, .. } => checks::speed_motor(motor),
        _ => None,
    };
    let [motor_speed, motor_torque] = drive.unwrap_or_default();
    let (kind, limits) = match def.kind {
        JointKind::Fixed => (ffi::JOLT_FIXED, None),
        JointKind::Hinge { limits, .. } => (ffi::JOLT_HINGE, checks::finite_limits(limits, MAX_STOP)),
        JointKind::Spherical { swing_limit, .. } => match checks::swing(swing_limit) {
            Some(swing) => (ffi::JOLT_CONE, Some([0.0, swing])),
            None => (ffi::JOLT_POINT, None),
        },
        JointKind::Prismatic { limits, .. } => (ffi::JOLT_SLIDER, checks::finite_limits(limits, FAR)),
        JointKind::Distance { limits, .. } => {
            let [min, max] = checks::finite_limits(limits, FAR).unwrap_or([0.0, FAR]);
            (ffi::JOLT_DISTANCE, Some([min.max(0.0), max]))
        }
        _ => unsupported(NAME, "a joint of an unknown kind"),
    };
    let [min, max] = limits.unwrap_or_default();
    if kind != ffi::JOLT_DISTANCE && (min > 0.0 || max < 0.0) {
        unsupported(NAME, "limits that do not include zero");
    }
    JoltJointDef {
        kind,
        a,
        b,
        frame_a: frame(&def.frame_a),
        frame_b: frame(&def.frame_b),
        limited: limits.is_some(),
        min,
        max,
        driven: drive.is_some(),
        motor_speed,
        motor_torque,
        collide_connected: def.collide_connected,
    }
}

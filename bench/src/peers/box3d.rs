//! Box3D, through the crate `boxddd-sys`: soft contacts and joints solved in substeps.
//!
//! Its default joints are springs of 60 Hz, which is what bounds their accuracy at high effort.

use boxddd_sys::ffi;
use glam::{DVec3, Mat3, Quat, Vec3};
use longspan::{BodyDef, BodyKind, Geometry, JointDef, JointKind, LocalPose, Pose, ShapeDef, WorldDef};
use longspan_scenes::{Effort, Engine, SceneJoint};

use super::mass::{RigidMass, Unverified};
use super::{checks, parts, unsupported};

const NAME: &str = "box3d";

/// Substeps a step that Box3D recommends and all its samples use.
const DEFAULT_SUBSTEPS: u32 = 4;
/// Sides of the prism that stands for a cylinder, of which Box3D has none; the most that its own builder takes.
const CYLINDER_SIDES: i32 = 32;
/// Most vertices of a hull.
const MAX_HULL_VERTICES: i32 = 128;
/// Largest angle of a hinge's stop (rad).
const MAX_STOP: f32 = 0.99 * std::f32::consts::PI;
/// Bound (m) that stands for an open one where the other is finite.
const FAR: f32 = 1.0e4;

/// A scene in Box3D.
pub struct Box3d {
    world: ffi::b3WorldId,
    /// None where a body was removed: Box3D's release build reads and writes through stale handles.
    bodies: Vec<Option<ffi::b3BodyId>>,
    joints: Vec<ffi::b3JointId>,
    /// Stands for the world in joints that have only one body.
    ground: ffi::b3BodyId,
    substeps: i32,
    unverified: Unverified,
}

impl Box3d {
    /// An empty scene.
    pub fn new(def: &WorldDef, effort: Effort, threads: usize) -> Self {
        // SAFETY: definitions come from their default functions, and the world exists when its first body is made.
        let (world, ground) = unsafe {
            let mut world = ffi::b3DefaultWorldDef();
            world.gravity = vec_to_box3d(def.gravity);
            world.restitutionThreshold = def.restitution_threshold;
            world.enableSleep = def.sleep.enabled;
            world.workerCount = threads as u32;
            let world = ffi::b3CreateWorld(&world);
            assert!(ffi::b3World_IsValid(world), "Box3D has no more than 128 worlds at a time");
            (world, ffi::b3CreateBody(world, &ffi::b3DefaultBodyDef()))
        };
        let substeps = match effort {
            Effort::Default => DEFAULT_SUBSTEPS,
            Effort::N(substeps) => substeps,
        };
        Self {
            world,
            bodies: Vec::new(),
            joints: Vec::new(),
            ground,
            substeps: substeps as i32,
            unverified: Unverified::default(),
        }
    }

    fn id(&self, body: usize) -> ffi::b3BodyId {
        self.bodies[body].unwrap_or_else(|| panic!("body {body} was removed from the scene"))
    }

    fn read_mass(&self, body: usize) -> RigidMass {
        let id = self.id(body);
        // SAFETY: `id` lets only living bodies through.
        let (inverse_mass, center, rotation, inverse) = unsafe {
            (
                ffi::b3Body_GetInverseMass(id),
                ffi::b3Body_GetLocalCenter(id),
                ffi::b3Body_GetRotation(id),
                ffi::b3Body_GetWorldInverseRotationalInertia(id),
            )
        };
        let axes = Mat3::from_quat(quat_from_box3d(rotation));
        let inverse = Mat3::from_cols(vec_from_box3d(inverse.cx), vec_from_box3d(inverse.cy), vec_from_box3d(inverse.cz));
        RigidMass::from_inverses(inverse_mass, vec_from_box3d(center), axes.transpose() * inverse * axes)
    }
}

impl Drop for Box3d {
    fn drop(&mut self) {
        // SAFETY: this world was created in `new` and is destroyed only here.
        unsafe { ffi::b3DestroyWorld(self.world) };
    }
}

impl Engine for Box3d {
    fn name(&self) -> &'static str {
        NAME
    }

    fn add_body(&mut self, def: &BodyDef) -> usize {
        let index = self.bodies.len();
        // SAFETY: the definition comes from its default function; the body is used while it is alive.
        let id = unsafe {
            let mut body = ffi::b3DefaultBodyDef();
            body.type_ = match def.kind {
                BodyKind::Static => ffi::b3BodyType_b3_staticBody,
                BodyKind::Kinematic => ffi::b3BodyType_b3_kinematicBody,
                BodyKind::Dynamic => ffi::b3BodyType_b3_dynamicBody,
            };
            body.position = vec_to_box3d(def.pose.position.as_vec3());
            body.rotation = quat_to_box3d(def.pose.rotation);
            body.angularVelocity = vec_to_box3d(def.angular_velocity);
            body.linearDamping = def.linear_damping;
            body.angularDamping = def.angular_damping;
            body.gravityScale = def.gravity_scale;
            body.enableSleep = def.can_sleep;
            body.isBullet = def.fast;
            body.motionLocks = motion_locks(def);
            ffi::b3CreateBody(self.world, &body)
        };
        for shape in &def.shapes {
            attach(id, shape);
        }
        if def.kind == BodyKind::Dynamic {
            let mass = self.unverified.resolve(index, def);
            let [cx, cy, cz] = [mass.inertia.x_axis, mass.inertia.y_axis, mass.inertia.z_axis].map(vec_to_box3d);
            let inertia = ffi::b3Matrix3 { cx, cy, cz };
            let data = ffi::b3MassData { mass: mass.mass, center: vec_to_box3d(mass.center), inertia };
            // SAFETY: the body was created above.
            unsafe { ffi::b3Body_SetMassData(id, data) };
        }
        if def.kind != BodyKind::Static {
            // Only now: a body's definition gives the velocity of its origin, this call that of its centre of mass.
            // SAFETY: the body was created above.
            unsafe { ffi::b3Body_SetLinearVelocity(id, vec_to_box3d(def.linear_velocity)) };
        }
        self.bodies.push(Some(id));
        index
    }

    fn remove_body(&mut self, body: usize) {
        self.unverified.forget(body);
        let id = self.id(body);
        self.bodies[body] = None;
        // SAFETY: the body was alive until here.
        unsafe { ffi::b3DestroyBody(id) };
    }

    fn add_joint(&mut self, joint: &SceneJoint) -> usize {
        let [a, b] = [joint.a, joint.b].map(|body| body.map_or(self.ground, |body| self.id(body)));
        self.joints.push(create_joint(self.world, a, b, &joint.def));
        self.joints.len() - 1
    }

    fn step(&mut self, dt: f32) {
        // SAFETY: the world is alive.
        unsafe { ffi::b3World_Step(self.world, dt, self.substeps) };
        let mut unverified = std::mem::take(&mut self.unverified);
        unverified.verify(NAME, |body| self.read_mass(body));
    }

    fn pose(&self, body: usize) -> Pose {
        let id = self.id(body);
        // SAFETY: `id` lets only living bodies through.
        let (position, rotation) = unsafe { (ffi::b3Body_GetPosition(id), ffi::b3Body_GetRotation(id)) };
        Pose { position: DVec3::from(vec_from_box3d(position)), rotation: quat_from_box3d(rotation) }
    }

    fn linear_velocity(&self, body: usize) -> Vec3 {
        // SAFETY: `id` lets only living bodies through.
        vec_from_box3d(unsafe { ffi::b3Body_GetLinearVelocity(self.id(body)) })
    }

    fn angular_velocity(&self, body: usize) -> Vec3 {
        // SAFETY: `id` lets only living bodies through.
        vec_from_box3d(unsafe { ffi::b3Body_GetAngularVelocity(self.id(body)) })
    }

    fn set_linear_velocity(&mut self, body: usize, v: Vec3) {
        // SAFETY: `id` lets only living bodies through.
        unsafe { ffi::b3Body_SetLinearVelocity(self.id(body), vec_to_box3d(v)) };
    }

    fn apply_impulse(&mut self, body: usize, impulse: Vec3) {
        // SAFETY: `id` lets only living bodies through.
        unsafe { ffi::b3Body_ApplyLinearImpulseToCenter(self.id(body), vec_to_box3d(impulse), true) };
    }

    /// Of the step's last substep: Box3D keeps no sum. None for a prismatic joint, whose axes it mixes up in its report.
    fn joint_force(&self, joint: usize) -> Option<Vec3> {
        let id = self.joints[joint];
        // SAFETY: the joint's handle is checked first.
        unsafe {
            (ffi::b3Joint_IsValid(id) && ffi::b3Joint_GetType(id) != ffi::b3JointType_b3_prismaticJoint)
                .then(|| vec_from_box3d(ffi::b3Joint_GetConstraintForce(id)))
        }
    }

    fn set_gravity(&mut self, gravity: Vec3) -> bool {
        // SAFETY: the world is alive, and only living bodies are on the list.
        unsafe {
            ffi::b3World_SetGravity(self.world, vec_to_box3d(gravity));
            self.bodies.iter().flatten().for_each(|&id| ffi::b3Body_SetAwake(id, true));
        }
        true
    }

    fn is_awake(&self, body: usize) -> bool {
        // SAFETY: `id` lets only living bodies through.
        unsafe { ffi::b3Body_IsAwake(self.id(body)) }
    }
}

fn motion_locks(def: &BodyDef) -> ffi::b3MotionLocks {
    let [linear_x, linear_y, linear_z] = def.locked_axes.translation;
    let [angular_x, angular_y, angular_z] = def.locked_axes.rotation;
    ffi::b3MotionLocks {
        linearX: linear_x,
        linearY: linear_y,
        linearZ: linear_z,
        angularX: angular_x,
        angularY: angular_y,
        angularZ: angular_z,
    }
}

fn attach(body: ffi::b3BodyId, shape: &ShapeDef) {
    checks::material(NAME, &shape.material);
    // SAFETY: the definition comes from its default function.
    let mut def = unsafe { ffi::b3DefaultShapeDef() };
    // Box3D's own rules are the ones that `checks::material` lets through: geometric mean and maximum.
    def.baseMaterial.friction = shape.material.friction;
    def.baseMaterial.restitution = shape.material.restitution;
    def.density = 0.0;
    def.updateBodyMass = false;
    def.filter.categoryBits = u64::from(shape.filter.member_of);
    def.filter.maskBits = u64::from(shape.filter.collides_with);
    for (place, geometry) in parts::parts(shape) {
        attach_part(body, &def, place, geometry);
    }
}

fn attach_part(body: ffi::b3BodyId, def: &ffi::b3ShapeDef, place: LocalPose, geometry: &Geometry) {
    // SAFETY: the body is alive; Box3D clones what it is given, and every hull is destroyed by who created it.
    unsafe {
        match geometry {
            Geometry::Ball { radius } => {
                let sphere = ffi::b3Sphere { center: vec_to_box3d(place.position), radius: *radius };
                ffi::b3CreateSphereShape(body, def, &sphere);
            }
            Geometry::Capsule { half_height, radius } => {
                let half = place.rotation * Vec3::new(0.0, *half_height, 0.0);
                let [center1, center2] = [place.position - half, place.position + half].map(vec_to_box3d);
                ffi::b3CreateCapsuleShape(body, def, &ffi::b3Capsule { center1, center2, radius: *radius });
            }
            Geometry::Box { half_extents } => attach_box(body, def, place, *half_extents),
            Geometry::HalfSpace { normal } => {
                let (place, half_extents) = parts::ground_box(&place, *normal);
                attach_box(body, def, place, half_extents);
            }
            Geometry::Cylinder { half_height, radius } => {
                let hull = ffi::b3CreateCylinder(2.0 * half_height, *radius, -half_height, CYLINDER_SIDES);
                attach_hull(body, def, place, hull);
            }
            Geometry::ConvexHull { points } => {
                let points: Vec<_> = points.iter().copied().map(vec_to_box3d).collect();
                attach_hull(body, def, place, ffi::b3CreateHull(points.as_ptr(), points.len() as i32, MAX_HULL_VERTICES));
            }
            other => unsupported(NAME, parts::name(other)),
        }
    }
}

fn attach_box(body: ffi::b3BodyId, def: &ffi::b3ShapeDef, place: LocalPose, half: Vec3) {
    // SAFETY: the body is alive and the hull, a plain value, is cloned.
    unsafe {
        let hull = ffi::b3MakeTransformedBoxHull(half.x, half.y, half.z, transform(place.position, place.rotation));
        ffi::b3CreateHullShape(body, def, &hull.base);
    }
}

/// Attaches and destroys `hull`, which is null if Box3D refused to build it.
///
/// # Safety
/// The body is alive, and nothing else uses the hull.
unsafe fn attach_hull(body: ffi::b3BodyId, def: &ffi::b3ShapeDef, place: LocalPose, hull: *mut ffi::b3HullData) {
    if hull.is_null() {
        unsupported(NAME, "a convex hull of these points");
    }
    // SAFETY: the caller vouches for the body; the hull is not null, is cloned, and is this function's to destroy.
    unsafe {
        let unit_scale = ffi::b3Vec3 { x: 1.0, y: 1.0, z: 1.0 };
        ffi::b3CreateTransformedHullShape(body, def, hull, transform(place.position, place.rotation), unit_scale);
        ffi::b3DestroyHull(hull);
    }
}

fn create_joint(world: ffi::b3WorldId, a: ffi::b3BodyId, b: ffi::b3BodyId, def: &JointDef) -> ffi::b3JointId {
    checks::joint(NAME, def);
    // SAFETY: every definition comes from its default function, and world and bodies are alive.
    unsafe {
        match def.kind {
            JointKind::Fixed => {
                let mut joint = ffi::b3DefaultWeldJointDef();
                set_base(&mut joint.base, a, b, def, Quat::IDENTITY);
                ffi::b3CreateWeldJoint(world, &joint)
            }
            JointKind::Hinge { limits, motor } => {
                let mut joint = ffi::b3DefaultRevoluteJointDef();
                set_base(&mut joint.base, a, b, def, z_to_x());
                if let Some([lower, upper]) = checks::finite_limits(limits, MAX_STOP) {
                    (joint.enableLimit, joint.lowerAngle, joint.upperAngle) = (true, lower, upper);
                }
                if let Some([speed, most]) = checks::speed_motor(motor) {
                    (joint.enableMotor, joint.motorSpeed, joint.maxMotorTorque) = (true, speed, most);
                }
                ffi::b3CreateRevoluteJoint(world, &joint)
            }
            JointKind::Spherical { swing_limit, .. } => {
                let mut joint = ffi::b3DefaultSphericalJointDef();
                set_base(&mut joint.base, a, b, def, z_to_x());
                if let Some(swing) = checks::swing(swing_limit) {
                    (joint.enableConeLimit, joint.coneAngle) = (true, swing);
                }
                ffi::b3CreateSphericalJoint(world, &joint)
            }
            JointKind::Prismatic { limits, .. } => {
                let mut joint = ffi::b3DefaultPrismaticJointDef();
                set_base(&mut joint.base, a, b, def, Quat::IDENTITY);
                if let Some([lower, upper]) = checks::finite_limits(limits, FAR) {
                    (joint.enableLimit, joint.lowerTranslation, joint.upperTranslation) = (true, lower, upper);
                }
                ffi::b3CreatePrismaticJoint(world, &joint)
            }
            JointKind::Distance { limits, .. } => {
                let [min, max] = checks::finite_limits(limits, FAR).unwrap_or([0.0, FAR]);
                let mut joint = ffi::b3DefaultDistanceJointDef();
                set_base(&mut joint.base, a, b, def, Quat::IDENTITY);
                joint.length = max;
                if min < max {
                    // A spring of no stiffness is Box3D's way to have limits alone.
                    (joint.enableSpring, joint.hertz) = (true, 0.0);
                    (joint.enableLimit, joint.minLength, joint.maxLength) = (true, min.max(0.0), max);
                }
                ffi::b3CreateDistanceJoint(world, &joint)
            }
            _ => unsupported(NAME, "a joint of an unknown kind"),
        }
    }
}

/// The rotation that takes z, the axis of Box3D's hinges and cones, to x, that of ours.
fn z_to_x() -> Quat {
    Quat::from_rotation_arc(Vec3::Z, Vec3::X)
}

fn set_base(base: &mut ffi::b3JointDef, a: ffi::b3BodyId, b: ffi::b3BodyId, def: &JointDef, axes: Quat) {
    base.bodyIdA = a;
    base.bodyIdB = b;
    base.localFrameA = transform(def.frame_a.position.as_vec3(), def.frame_a.rotation * axes);
    base.localFrameB = transform(def.frame_b.position.as_vec3(), def.frame_b.rotation * axes);
    base.collideConnected = def.collide_connected;
}

fn vec_to_box3d(v: Vec3) -> ffi::b3Vec3 {
    ffi::b3Vec3 { x: v.x, y: v.y, z: v.z }
}

fn vec_from_box3d(v: ffi::b3Vec3) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

fn quat_to_box3d(q: Quat) -> ffi::b3Quat {
    ffi::b3Quat { v: ffi::b3Vec3 { x: q.x, y: q.y, z: q.z }, s: q.w }
}

fn quat_from_box3d(q: ffi::b3Quat) -> Quat {
    Quat::from_xyzw(q.v.x, q.v.y, q.v.z, q.s)
}

fn transform(position: Vec3, rotation: Quat) -> ffi::b3Transform {
    ffi::b3Transform { p: vec_to_box3d(position), q: quat_to_box3d(rotation) }
}

//! Rapier, from its crate: soft contacts and joints solved in substeps, `num_solver_iterations` of them a step.

use glam::Vec3;
use longspan::{BodyDef, BodyKind, Geometry, JointDef, JointKind, Pose, ShapeDef, WorldDef};
use longspan_scenes::{Effort, Engine, SceneJoint};
use rapier3d::parry::mass_properties::MassProperties;
use rapier3d::prelude::{
    CoefficientCombineRule, ColliderBuilder, GenericJoint, GenericJointBuilder, Group, ImpulseJointHandle, InteractionGroups,
    InteractionTestMode, JointAxesMask, JointAxis, LockedAxes, PhysicsWorld, Pose3, RigidBodyBuilder, RigidBodyHandle,
    SharedShape,
};

use super::mass::{RigidMass, Unverified};
use super::{checks, parts, unsupported};

const NAME: &str = "rapier";

/// Bound (m) that stands for an open one where the other is finite.
const FAR: f32 = 1.0e6;
/// Gain (1/s) of a speed motor: so high that its torque limit alone makes it give.
const SERVO_FACTOR: f32 = 1.0e8;

/// A scene in Rapier.
pub struct Rapier {
    world: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
    joints: Vec<ImpulseJointHandle>,
    /// Stands for the world in joints that have only one body.
    ground: RigidBodyHandle,
    sleeping: bool,
    unverified: Unverified,
}

impl Rapier {
    /// An empty scene.
    pub fn new(def: &WorldDef, effort: Effort, threads: usize) -> Self {
        if threads != 1 {
            unsupported(NAME, "more than one thread: that takes a build with its `parallel` feature");
        }
        let mut world = PhysicsWorld { gravity: def.gravity, ..PhysicsWorld::default() };
        if let Effort::N(substeps) = effort {
            world.integration_parameters.num_solver_iterations = substeps as usize;
        }
        let ground = world.insert_body(RigidBodyBuilder::fixed());
        Self {
            world,
            bodies: Vec::new(),
            joints: Vec::new(),
            ground,
            sleeping: def.sleep.enabled,
            unverified: Unverified::default(),
        }
    }

    fn handle(&self, body: Option<usize>) -> RigidBodyHandle {
        body.map_or(self.ground, |body| self.bodies[body])
    }

    fn read_mass(&self, body: usize) -> RigidMass {
        let mass = &self.world.bodies[self.bodies[body]].mass_properties().local_mprops;
        RigidMass { mass: mass.mass(), center: mass.local_com, inertia: mass.reconstruct_inertia_matrix() }
    }

    /// Length of one substep (s).
    fn substep(&self) -> f32 {
        let parameters = &self.world.integration_parameters;
        parameters.dt / parameters.num_solver_iterations as f32
    }
}

impl Engine for Rapier {
    fn name(&self) -> &'static str {
        NAME
    }

    fn add_body(&mut self, def: &BodyDef) -> usize {
        let builder = match def.kind {
            BodyKind::Static => RigidBodyBuilder::fixed(),
            BodyKind::Kinematic => RigidBodyBuilder::kinematic_velocity_based(),
            BodyKind::Dynamic => RigidBodyBuilder::dynamic(),
        };
        let mut builder = builder
            .pose(pose_to_rapier(&def.pose))
            .linvel(def.linear_velocity)
            .angvel(def.angular_velocity)
            .linear_damping(def.linear_damping)
            .angular_damping(def.angular_damping)
            .gravity_scale(def.gravity_scale)
            .can_sleep(def.can_sleep && self.sleeping)
            .ccd_enabled(def.fast)
            .locked_axes(locked_axes(def));
        let index = self.bodies.len();
        if def.kind == BodyKind::Dynamic {
            let mass = self.unverified.resolve(index, def);
            // The colliders get no density, so that this is the whole mass.
            builder =
                builder.additional_mass_properties(MassProperties::with_inertia_matrix(mass.center, mass.mass, mass.inertia));
        }
        let handle = self.world.insert_body(builder);
        for collider in def.shapes.iter().flat_map(colliders) {
            self.world.insert_collider(collider, Some(handle));
        }
        self.bodies.push(handle);
        index
    }

    fn remove_body(&mut self, body: usize) {
        self.unverified.forget(body);
        self.world.remove_body(self.bodies[body]);
    }

    fn add_joint(&mut self, joint: &SceneJoint) -> usize {
        let (a, b) = (self.handle(joint.a), self.handle(joint.b));
        self.joints.push(self.world.insert_impulse_joint(a, b, joint_to_rapier(&joint.def)));
        self.joints.len() - 1
    }

    fn step(&mut self, dt: f32) {
        self.world.integration_parameters.dt = dt;
        self.world.step();
        let mut unverified = std::mem::take(&mut self.unverified);
        unverified.verify(NAME, |body| self.read_mass(body));
    }

    fn pose(&self, body: usize) -> Pose {
        let pose = self.world.bodies[self.bodies[body]].position();
        Pose { position: pose.translation.as_dvec3(), rotation: pose.rotation }
    }

    fn linear_velocity(&self, body: usize) -> Vec3 {
        self.world.bodies[self.bodies[body]].linvel()
    }

    fn angular_velocity(&self, body: usize) -> Vec3 {
        self.world.bodies[self.bodies[body]].angvel()
    }

    fn set_linear_velocity(&mut self, body: usize, v: Vec3) {
        self.world.bodies[self.bodies[body]].set_linvel(v, true);
    }

    fn apply_impulse(&mut self, body: usize, impulse: Vec3) {
        self.world.bodies[self.bodies[body]].apply_impulse(impulse, true);
    }

    /// Of the step's last substep: Rapier keeps no sum. It accounts impulses on body A, along the axes of A's frame.
    fn joint_force(&self, joint: usize) -> Option<Vec3> {
        let joint = self.world.impulse_joints.get(self.joints[joint])?;
        let [a, b] = [joint.body1(), joint.body2()].map(|body| self.world.bodies[body].position());
        let (frame_a, frame_b) = (a * joint.data.local_frame1, b * joint.data.local_frame2);
        let impulse_on_a = if joint.data.coupled_axes.contains(JointAxesMask::LIN_AXES) {
            (frame_b.translation - frame_a.translation).normalize_or_zero() * joint.data.limits[0].impulse
        } else {
            frame_a.rotation * Vec3::new(joint.impulses[0], joint.impulses[1], joint.impulses[2])
        };
        Some(-impulse_on_a / self.substep())
    }

    fn set_gravity(&mut self, gravity: Vec3) -> bool {
        self.world.gravity = gravity;
        self.world.wake_up_all(true);
        true
    }

    fn is_awake(&self, body: usize) -> bool {
        !self.world.bodies[self.bodies[body]].is_sleeping()
    }
}

fn pose_to_rapier(pose: &Pose) -> Pose3 {
    Pose3::from_parts(pose.position.as_vec3(), pose.rotation)
}

fn locked_axes(def: &BodyDef) -> LockedAxes {
    let [x, y, z] = def.locked_axes.translation;
    let [about_x, about_y, about_z] = def.locked_axes.rotation;
    let bits = [x, y, z, about_x, about_y, about_z].into_iter().enumerate().map(|(bit, locked)| u8::from(locked) << bit).sum();
    LockedAxes::from_bits_truncate(bits)
}

fn colliders(shape: &ShapeDef) -> Vec<ColliderBuilder> {
    checks::material(NAME, &shape.material);
    let groups = InteractionGroups::new(
        Group::from_bits_truncate(shape.filter.member_of),
        Group::from_bits_truncate(shape.filter.collides_with),
        InteractionTestMode::And,
    );
    let finish = |(place, geometry): (longspan::LocalPose, &Geometry)| {
        collider(geometry)
            .position(Pose3::from_parts(place.position, place.rotation))
            .density(0.0)
            .friction(shape.material.friction)
            .friction_combine_rule(CoefficientCombineRule::GeometricMean)
            .restitution(shape.material.restitution)
            .restitution_combine_rule(CoefficientCombineRule::Max)
            .collision_groups(groups)
    };
    parts::parts(shape).into_iter().map(finish).collect()
}

fn collider(geometry: &Geometry) -> ColliderBuilder {
    match geometry {
        Geometry::Ball { radius } => ColliderBuilder::ball(*radius),
        Geometry::Box { half_extents } => ColliderBuilder::cuboid(half_extents.x, half_extents.y, half_extents.z),
        Geometry::Capsule { half_height, radius } => ColliderBuilder::capsule_y(*half_height, *radius),
        Geometry::Cylinder { half_height, radius } => ColliderBuilder::cylinder(*half_height, *radius),
        Geometry::Cone { half_height, radius } => ColliderBuilder::cone(*half_height, *radius),
        Geometry::ConvexHull { points } => {
            ColliderBuilder::convex_hull(points).unwrap_or_else(|| unsupported(NAME, "a convex hull of these points"))
        }
        Geometry::HalfSpace { normal } => ColliderBuilder::new(SharedShape::halfspace(*normal)),
        other => unsupported(NAME, parts::name(other)),
    }
}

fn joint_to_rapier(def: &JointDef) -> GenericJoint {
    checks::joint(NAME, def);
    let (mut drive, mut swing) = (None, None);
    let (locked, free) = match def.kind {
        JointKind::Fixed => (JointAxesMask::LOCKED_FIXED_AXES, None),
        JointKind::Hinge { limits, motor } => {
            drive = checks::speed_motor(motor);
            let limits = checks::finite_limits(limits, std::f32::consts::PI);
            (JointAxesMask::LOCKED_REVOLUTE_AXES, limits.map(|limits| (JointAxis::AngX, limits)))
        }
        JointKind::Spherical { swing_limit, .. } => {
            swing = checks::swing(swing_limit);
            (JointAxesMask::LOCKED_SPHERICAL_AXES, None)
        }
        JointKind::Prismatic { limits, .. } => {
            let limits = checks::finite_limits(limits, FAR);
            (JointAxesMask::LOCKED_PRISMATIC_AXES, limits.map(|limits| (JointAxis::LinX, limits)))
        }
        JointKind::Distance { limits, .. } => {
            let limits = checks::finite_limits(limits, FAR).map(|[min, max]| [min.max(0.0), max]);
            (JointAxesMask::empty(), limits.map(|limits| (JointAxis::LinX, limits)))
        }
        _ => unsupported(NAME, "a joint of an unknown kind"),
    };
    let mut builder = GenericJointBuilder::new(locked)
        .local_frame1(pose_to_rapier(&def.frame_a))
        .local_frame2(pose_to_rapier(&def.frame_b))
        .contacts_enabled(def.collide_connected);
    if matches!(def.kind, JointKind::Distance { .. }) {
        builder = builder.coupled_axes(JointAxesMask::LIN_AXES);
    }
    if let Some((axis, limits)) = free {
        builder = builder.limits(axis, limits);
    }
    if let Some(swing) = swing {
        // Rapier limits each axis on its own: a pyramid about the cone that is asked for.
        builder = builder.limits(JointAxis::AngY, [-swing, swing]).limits(JointAxis::AngZ, [-swing, swing]);
    }
    if let Some([speed, most]) = drive {
        let axis = JointAxis::AngX;
        builder = builder.motor_velocity(axis, speed, SERVO_FACTOR).motor_max_force(axis, most);
    }
    builder.build()
}

//! Bodies that nothing pulls at: momentum is kept, damping follows its formula.

use longspan::glam::{DVec3, Vec3};
use longspan::{Axis, BodyDef, BodyId, JointDef, JointKind, Limits, Mass, MassProperties, Motor, Pose};

use crate::metrics::{AngularMomentumError, EnergyError, JointGap, LinearMomentumError, View};
use crate::outcome::SpeedError;
use crate::params::{Params, SceneError};
use crate::random::Random;
use crate::scene::{DT, Scene, ball, cuboid, start_in, weightless};

pub(crate) fn free_gyro(params: &mut Params) -> Result<Scene, SceneError> {
    let spin = params.number("spin", 5.0, 0.01..=1000.0)? as f32;
    let mut scene = start_in(weightless(), params, 10.0)?;
    let mass = Mass::Properties(MassProperties::new(1.0, Vec3::new(1.0, 2.0, 3.0)));
    let mut def = BodyDef::dynamic(Pose::IDENTITY).with_shape(cuboid(0.6, 0.4, 0.2)?).with_mass(mass);
    def.angular_velocity = Vec3::new(0.05, spin, 0.02);
    scene.body(def);
    scene.judge(AngularMomentumError::default());
    scene.judge(EnergyError::new("energy_err_pct", None, None));
    Ok(scene)
}

/// Eight boxes in a branching tree of joints, one of each kind, with their mass centre at the origin at the start: turning as one,
/// each with some spin of its own, and drifting.
pub(crate) fn free_cluster(params: &mut Params) -> Result<Scene, SceneError> {
    let spin = params.number("spin", 3.0, 0.0..=100.0)? as f32;
    let drift = params.number("drift", 1.0, 1.0e-3..=100.0)? as f32;
    let joints = params.word("joints", &["mixed", "spherical", "hinge", "fixed", "prismatic"])?;
    let mut random = Random::new(params.seed()?);
    let mut scene = start_in(weightless(), params, 10.0)?;
    for index in 0..8 {
        let mut solid = cuboid(random.between(0.05, 0.2), random.between(0.05, 0.2), random.between(0.05, 0.2))?;
        // Joints, not contacts, are what this scene is about.
        solid.filter.collides_with = 0;
        let place = DVec3::new(0.6 * f64::from(index % 4), 0.6 * f64::from(index / 4), 0.0) + random.vector(0.1).as_dvec3();
        let def = BodyDef::dynamic(Pose::at(place).rotated(random.rotation())).with_shape(solid);
        scene.body(def.with_mass(Mass::Total(random.between(1.0, 5.0))));
    }
    centre_masses(&mut scene);
    let turning = Vec3::new(0.3, 0.5, 0.8).normalize() * spin;
    for def in &mut scene.bodies {
        def.linear_velocity = Vec3::new(0.6, 0.0, 0.8) * drift + turning.cross(def.pose.position.as_vec3());
        def.angular_velocity = turning + random.vector(1.0);
    }

    let slide = Limits::new(-0.2, 0.2);
    let swing = JointKind::Spherical { swing_limit: 0.5, twist_limits: Limits::new(-0.5, 0.5), motor: Default::default() };
    let generic = JointKind::Generic {
        linear: [Axis::LOCKED, Axis::limited(-0.1, 0.1), Axis::LOCKED],
        angular: [Axis::FREE, Axis::limited(-0.3, 0.3), Axis::LOCKED],
    };
    let kinds = [
        (0, JointKind::SPHERICAL),
        (1, JointKind::HINGE),
        (2, JointKind::Fixed),
        (0, JointKind::Prismatic { limits: slide, motor: Motor::Off }),
        (1, swing),
        (2, JointKind::Distance { limits: Limits::new(0.3, 0.9), spring_length: None, motor: Motor::Off }),
        (3, generic),
    ];
    for (index, (a, kind)) in kinds.into_iter().enumerate() {
        let b = index + 1;
        let kind = match joints {
            "spherical" => JointKind::SPHERICAL,
            "hinge" => JointKind::HINGE,
            "fixed" => JointKind::Fixed,
            "prismatic" => JointKind::PRISMATIC,
            _ => kind,
        };
        let def = joint_halfway(&scene, a, b, kind);
        scene.joint(Some(a), Some(b), def);
    }
    let steps = scene.steps;
    scene.judge(LinearMomentumError::default());
    scene.judge(AngularMomentumError::default());
    scene.judge(JointGap::over_last(steps));
    Ok(scene)
}

/// Moves all bodies so that their common centre of mass lies at the origin.
fn centre_masses(scene: &mut Scene) {
    let mass_of = |def: &BodyDef| match def.mass {
        Mass::Properties(properties) => f64::from(properties.mass),
        _ => 0.0,
    };
    let total: f64 = scene.bodies.iter().map(mass_of).sum();
    let center = scene.bodies.iter().map(|def| def.pose.position * mass_of(def)).sum::<DVec3>() / total;
    for def in &mut scene.bodies {
        def.pose.position -= center;
    }
}

/// A joint whose frames agree at the start: halfway between the bodies, turned as body A is; a distance joint from centre to centre.
fn joint_halfway(scene: &Scene, a: usize, b: usize, kind: JointKind) -> JointDef {
    let mut def = JointDef::new(kind, BodyId::NULL, BodyId::NULL);
    if matches!(kind, JointKind::Distance { .. }) {
        return def;
    }
    let (pose_a, pose_b) = (scene.bodies[a].pose, scene.bodies[b].pose);
    let shared = Pose::at(0.5 * (pose_a.position + pose_b.position)).rotated(pose_a.rotation);
    let local = |pose: Pose| {
        let turn = (pose.rotation.conjugate() * shared.rotation).normalize();
        Pose::at(pose.inverse_transform_point(shared.position).as_dvec3()).rotated(turn)
    };
    (def.frame_a, def.frame_b) = (local(pose_a), local(pose_b));
    def
}

/// Damping is implicit: after n substeps of h a speed is v₀/(1 + h c)ⁿ.
pub(crate) fn damping(params: &mut Params) -> Result<Scene, SceneError> {
    let linear = params.number("linear", 0.5, 0.0..=1000.0)?;
    let angular = params.number("angular", 0.8, 0.0..=1000.0)?;
    let mut scene = start_in(weightless(), params, 4.0)?;
    let (speed, spin) = (10.0, 5.0);
    let mut def = BodyDef::dynamic(Pose::IDENTITY).with_shape(ball(0.25)?);
    def.linear_velocity = Vec3::X * speed as f32;
    def.angular_velocity = Vec3::Y * spin as f32;
    (def.linear_damping, def.angular_damping) = (linear as f32, angular as f32);
    let body = scene.body(def);

    let substeps = scene.world.substeps;
    let decayed = move |start: f64, rate: f64, step: u32| {
        let h = f64::from(DT) / f64::from(substeps);
        start / (1.0 + h * rate).powi((step * substeps) as i32)
    };
    let linear_speed = move |view: &View| f64::from(view.engine.linear_velocity(body).x);
    let angular_speed = move |view: &View| f64::from(view.engine.angular_velocity(body).y);
    scene.judge(SpeedError::new("speed_err_pct", speed, linear_speed, move |step, _| decayed(speed, linear, step)));
    scene.judge(SpeedError::new("spin_err_pct", spin, angular_speed, move |step, _| decayed(spin, angular, step)));
    Ok(scene)
}

//! Scenes whose outcome is known in closed form.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, JointDef, JointKind, Limits, Mass, MassProperties, Material, Motor, Pose, Softness};

use crate::metrics::{EnergyError, HingeError, HingeOvershoot, JointGap, Moved, Overlap, TrajectoryError, View};
use crate::outcome::{Distance, ForceError, PeriodError, ReboundError, SpeedError};
use crate::params::{Params, SceneError};
use crate::scene::{GRAVITY, Scene, about_z, ball, cuboid, floor, start, start_in, weightless, with_friction};

pub(crate) fn box_on_plane(params: &mut Params) -> Result<Scene, SceneError> {
    let mass = params.number("mass", 100.0, 1.0e-6..=1.0e9)? as f32;
    let mut scene = start(params, 2.0)?;
    scene.body(floor(20.0, 0.0, 0.5)?);
    let solid = cuboid(0.5, 0.5, 0.5)?;
    let body = scene.body(BodyDef::dynamic(Pose::at_xyz(0.0, 0.5, 0.0)).with_shape(solid).with_mass(Mass::Total(mass)));
    let steps = scene.steps;
    scene.judge(ForceError::new(body, f64::from(mass) * f64::from(GRAVITY), steps.saturating_sub(60).max(1)));
    scene.judge(Moved::after(steps, None));
    scene.judge(Overlap::at_end());
    Ok(scene)
}

/// A flat box on a plane tilted by `angle_deg`: it rests if tan θ ≤ μ and else slides ½ g (sin θ − μ cos θ) t².
pub(crate) fn slope(params: &mut Params) -> Result<Scene, SceneError> {
    let angle = params.number("angle_deg", 20.0, 0.0..=60.0)?.to_radians();
    let friction = params.number("friction", 0.5, 0.0..=10.0)?;
    let mut scene = start(params, 2.0)?;
    let turn = Quat::from_rotation_z(angle as f32);
    let out_of_plane = |distance: f32| Pose::at((turn * Vec3::Y * distance).as_dvec3()).rotated(turn);
    let plane = with_friction(cuboid(60.0, 0.5, 5.0)?, friction as f32);
    scene.body(BodyDef::fixed(out_of_plane(-0.5)).with_shape(plane));
    let solid = with_friction(cuboid(0.25, 0.1, 0.25)?, friction as f32);
    let body = scene.body(BodyDef::dynamic(out_of_plane(0.1)).with_shape(solid));
    let acceleration = (f64::from(GRAVITY) * (angle.sin() - friction * angle.cos())).max(0.0);
    scene.judge(Distance::new(body, move |t| 0.5 * acceleration * t * t));
    Ok(scene)
}

pub(crate) fn bounce(params: &mut Params) -> Result<Scene, SceneError> {
    let restitution = params.number("restitution", 0.5, 0.0..=1.0)?;
    let height = params.number("height", 2.0, 0.1..=1000.0)?;
    let fall = (2.0 * height / f64::from(GRAVITY)).sqrt();
    let mut scene = start(params, fall * (1.0 + 2.0 * restitution))?;
    let material = Material { restitution: restitution as f32, ..Material::default() };
    let mut ground = floor(20.0, 0.0, 0.5)?;
    ground.shapes[0].material = material;
    scene.body(ground);
    let mut solid = ball(0.25)?;
    solid.material = material;
    let body = scene.body(BodyDef::dynamic(Pose::at_xyz(0.0, height + 0.25, 0.0)).with_shape(solid));
    scene.judge(ReboundError::new(body, 0.25, restitution * restitution * height));
    Ok(scene)
}

/// A ball on a weightless rod: T = 2π / (ω₀ · agm(1, cos θ₀/2)), ω₀² = m g l / (I + m l²).
pub(crate) fn pendulum(params: &mut Params) -> Result<Scene, SceneError> {
    let length = params.number("length", 1.0, 0.2..=100.0)? as f32;
    let angle = params.number("angle_deg", 60.0, 1.0..=170.0)?.to_radians();
    let mut scene = start(params, 10.0)?;
    let anchor = scene.body(BodyDef::fixed(Pose::at_xyz(0.0, 0.1, 0.0)).with_shape(cuboid(0.1, 0.1, 0.1)?));
    let turn = Quat::from_rotation_z(angle as f32);
    let center = turn * Vec3::NEG_Y * length;
    let body = scene.body(BodyDef::dynamic(Pose::at(center.as_dvec3()).rotated(turn)).with_shape(ball(0.1)?));
    scene.joint(Some(anchor), Some(body), about_z(JointKind::HINGE, Vec3::Y * -0.1, Vec3::Y * length));

    let mass = properties_of(&scene, body);
    let (m, l) = (f64::from(mass.mass), f64::from(length));
    let rate = (m * f64::from(GRAVITY) * l / (f64::from(mass.principal_inertia.z) + m * l * l)).sqrt();
    let (mut a, mut b) = (1.0_f64, (0.5 * angle).cos());
    for _ in 0..10 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    let swing = m * f64::from(GRAVITY) * l * (1.0 - angle.cos());
    let steps = scene.steps;
    scene.judge(PeriodError::new(body, DVec3::X, 0.0, std::f64::consts::TAU / (rate * a)));
    scene.judge(EnergyError::new("energy_drift_pct", Some("energy_rise_pct"), Some(swing)));
    scene.judge(JointGap::over_last(steps));
    Ok(scene)
}

pub(crate) fn projectile(params: &mut Params) -> Result<Scene, SceneError> {
    let speed = params.number("speed", 15.0, 0.0..=1000.0)? as f32;
    let mut scene = start(params, 2.0)?;
    let mut def = BodyDef::dynamic(Pose::at_xyz(0.0, 1.0, 0.0)).with_shape(ball(0.1)?);
    def.linear_velocity = Vec3::new(0.6, 0.8, 0.0) * speed;
    let (start_at, velocity) = (def.pose.position, def.linear_velocity.as_dvec3());
    let body = scene.body(def);
    scene.judge(TrajectoryError::new(body, "pos_err_max_m", Some("pos_err_rms_m"), move |_, t| {
        start_at + velocity * t - DVec3::Y * (0.5 * f64::from(GRAVITY) * t * t)
    }));
    Ok(scene)
}

/// A weight on a spring and damper, let go at the spring's rest length: y(t) = −(m g/k)(1 − e^(−γt)(cos ωt + γ/ω sin ωt)).
pub(crate) fn spring(params: &mut Params) -> Result<Scene, SceneError> {
    let mass = params.number("mass", 1.0, 1.0e-3..=1.0e6)?;
    let stiffness = params.number("stiffness", 100.0, 1.0e-3..=1.0e9)?;
    let damping = params.number("damping", 1.0, 0.0..=1.0e9)?;
    if damping * damping >= 4.0 * mass * stiffness {
        let expected = "less than critical: damping² < 4 · mass · stiffness".to_owned();
        return Err(SceneError::BadValue { key: "damping".into(), value: damping.to_string(), expected });
    }
    let mut scene = start(params, 5.0)?;
    let length = 1.0;
    let anchor = scene.body(BodyDef::fixed(Pose::at_xyz(0.0, 0.1, 0.0)).with_shape(cuboid(0.1, 0.1, 0.1)?));
    let hung = BodyDef::dynamic(Pose::at_xyz(0.0, -f64::from(length), 0.0));
    let body = scene.body(hung.with_shape(ball(0.1)?).with_mass(Mass::Total(mass as f32)));
    let kind = JointKind::Distance { limits: Limits::NONE, spring_length: Some(length), motor: Motor::Off };
    let mut def = JointDef::new(kind, BodyId::NULL, BodyId::NULL).at(Vec3::Y * -0.1, Vec3::ZERO);
    def.linear = Softness { compliance: (1.0 / stiffness) as f32, damping: damping as f32 };
    scene.joint(Some(anchor), Some(body), def);

    let (sag, decay) = (mass * f64::from(GRAVITY) / stiffness, damping / (2.0 * mass));
    let rate = (stiffness / mass - decay * decay).sqrt();
    scene.judge(TrajectoryError::new(body, "pos_err_max_m", Some("pos_err_rms_m"), move |_, t| {
        let swing = (-decay * t).exp() * ((rate * t).cos() + decay / rate * (rate * t).sin());
        DVec3::NEG_Y * (f64::from(length) + sag * (1.0 - swing))
    }));
    scene.judge(PeriodError::new(body, DVec3::Y, -f64::from(length) - sag, std::f64::consts::TAU / rate));
    Ok(scene)
}

/// A wheel driven by a motor of bounded torque: ω(t) = min(target, τ t/I).
pub(crate) fn hinge_motor(params: &mut Params) -> Result<Scene, SceneError> {
    let target = params.number("speed", 10.0, 0.01..=100.0)?;
    let torque = params.number("torque", 5.0, 1.0e-6..=1.0e9)?;
    let mut scene = start_in(weightless(), params, 3.0)?;
    let anchor = scene.body(BodyDef::fixed(Pose::IDENTITY).with_shape(cuboid(0.1, 0.1, 0.1)?));
    let mass = Mass::Properties(MassProperties::new(1.0, Vec3::new(0.6, 0.6, 1.0)));
    let body = scene.body(BodyDef::dynamic(Pose::at_xyz(0.0, 0.0, 0.2)).with_shape(cuboid(0.5, 0.5, 0.05)?).with_mass(mass));
    let motor = Motor::Velocity { target: target as f32, max_force: torque as f32 };
    let kind = JointKind::Hinge { limits: Limits::NONE, motor };
    scene.joint(Some(anchor), Some(body), about_z(kind, Vec3::Z * 0.2, Vec3::ZERO));
    let inertia = f64::from(properties_of(&scene, body).principal_inertia.z);
    let spin = move |view: &View| f64::from(view.engine.angular_velocity(body).z);
    scene.judge(SpeedError::new("spin_err_pct", target, spin, move |_, t| target.min(torque * t / inertia)));
    Ok(scene)
}

/// A flywheel and a pendulum whose hinges rub: ω(t) = ω₀ − F t/I, and half swings of θ(t) = ±d + (A − d) cos Ω t with d = F/(m g l) and
/// A less by 2 d in each, until A ≤ d.
pub(crate) fn stiff_hinge(params: &mut Params) -> Result<Scene, SceneError> {
    let spin = params.number("speed", 10.0, 0.1..=100.0)?;
    let friction = params.number("friction", 2.0, 1.0e-6..=1.0e9)?;
    let angle = params.number("angle_deg", 1.0, 0.1..=5.0)?.to_radians();
    let share = params.number("share", 0.08, 0.001..=1.0)?;
    let mut scene = start(params, 8.0)?;
    let anchor = scene.body(BodyDef::fixed(Pose::at_xyz(0.0, 0.1, 0.0)).with_shape(cuboid(0.1, 0.1, 0.1)?));

    let mass = Mass::Properties(MassProperties::new(1.0, Vec3::new(0.6, 0.6, 1.0)));
    let disc = BodyDef::dynamic(Pose::at_xyz(0.0, 0.1, 0.5)).with_shape(cuboid(0.5, 0.5, 0.05)?).with_mass(mass);
    let wheel = scene.body(BodyDef { angular_velocity: Vec3::Z * spin as f32, ..disc });
    let bearing = about_z(JointKind::HINGE, Vec3::Z * 0.5, Vec3::ZERO).with_friction(friction as f32);
    scene.joint(Some(anchor), Some(wheel), bearing);
    let speed = move |view: &View| f64::from(view.engine.angular_velocity(wheel).z);
    let inertia = f64::from(properties_of(&scene, wheel).principal_inertia.z);
    scene.judge(SpeedError::new("spin_err_pct", spin, speed, move |_, t| (spin - friction * t / inertia).max(0.0)));

    let turn = Quat::from_rotation_z(angle as f32);
    let bob = scene.body(BodyDef::dynamic(Pose::at((turn * Vec3::NEG_Y).as_dvec3()).rotated(turn)).with_shape(ball(0.1)?));
    let mass = properties_of(&scene, bob);
    let weight = f64::from(mass.mass * GRAVITY);
    let rate = (weight / f64::from(mass.principal_inertia.z + mass.mass)).sqrt();
    let shift = share * angle;
    let bearing = about_z(JointKind::HINGE, Vec3::Y * -0.1, Vec3::Y).with_friction((weight * shift) as f32);
    scene.joint(Some(anchor), Some(bob), bearing);
    let out = move |view: &View| {
        let center = view.engine.pose(bob).position;
        center.x.atan2(-center.y)
    };
    scene.judge(SpeedError::new("swing_err_pct", angle, out, move |_, t| {
        // Half swings that leave more than friction holds, and those that have passed.
        let most = ((1.0 / share - 1.0) / 2.0).ceil().max(0.0);
        let passed = (t * rate / std::f64::consts::PI).floor();
        let side = |swings: f64| if swings % 2.0 == 0.0 { 1.0 } else { -1.0 };
        if passed >= most {
            return side(most) * (angle - 2.0 * most * shift);
        }
        side(passed) * shift + (angle - (2.0 * passed + 1.0) * shift) * (rate * t).cos()
    }));
    Ok(scene)
}

/// A bar that falls about its end onto the stop of its hinge and must rest there.
pub(crate) fn hinge_limit(params: &mut Params) -> Result<Scene, SceneError> {
    let stop = params.number("stop_deg", -45.0, -89.0..=-1.0)?.to_radians() as f32;
    let mut scene = start(params, 4.0)?;
    let anchor = scene.body(BodyDef::fixed(Pose::IDENTITY).with_shape(cuboid(0.1, 0.1, 0.1)?));
    let body = scene.body(BodyDef::dynamic(Pose::at_xyz(0.5, 0.0, 0.0)).with_shape(cuboid(0.5, 0.05, 0.05)?));
    let kind = JointKind::Hinge { limits: Limits::new(stop, 1.0), motor: Motor::Off };
    scene.joint(Some(anchor), Some(body), about_z(kind, Vec3::ZERO, Vec3::X * -0.5));
    let steps = scene.steps;
    scene.judge(HingeOvershoot::since(0));
    scene.judge(JointGap::over_last(steps));
    Ok(scene)
}

/// A bar held level or at an angle against gravity by a position motor: it hangs where spring and weight balance.
pub(crate) fn hinge_servo(params: &mut Params) -> Result<Scene, SceneError> {
    let target = params.number("angle_deg", 30.0, -80.0..=80.0)?.to_radians();
    let stiffness = params.number("stiffness", f64::INFINITY, 1.0..=f64::INFINITY)?;
    let mut scene = start(params, 6.0)?;
    let anchor = scene.body(BodyDef::fixed(Pose::IDENTITY).with_shape(cuboid(0.1, 0.1, 0.1)?));
    let body = scene.body(BodyDef::dynamic(Pose::at_xyz(0.5, 0.0, 0.0)).with_shape(cuboid(0.5, 0.05, 0.05)?));
    let mass = properties_of(&scene, body);
    let weight_torque = f64::from(mass.mass * GRAVITY) * 0.5;
    // Half of critical damping, so that the bar has come to rest well before the end.
    let inertia = f64::from(mass.principal_inertia.z) + 0.25 * f64::from(mass.mass);
    let softness = match stiffness.is_finite() {
        true => Softness { compliance: (1.0 / stiffness) as f32, damping: (stiffness * inertia).sqrt() as f32 },
        false => Softness::RIGID,
    };
    let motor = Motor::Position { target: target as f32, softness, max_force: f32::INFINITY };
    let kind = JointKind::Hinge { limits: Limits::NONE, motor };
    let joint = scene.joint(Some(anchor), Some(body), about_z(kind, Vec3::ZERO, Vec3::X * -0.5));

    // k (θ₀ − θ) = ½ m g l cos θ, by Newton's method; there is one balance if the spring is stiffer than the weight.
    let balance = (0..50).fold(target, |angle: f64, _| {
        let torque = angle - target + weight_torque * angle.cos() / stiffness;
        angle - torque / (1.0 - weight_torque * angle.sin() / stiffness)
    });
    scene.judge(HingeError::new(joint, balance));
    Ok(scene)
}

pub(crate) fn properties_of(scene: &Scene, body: usize) -> MassProperties {
    match scene.bodies[body].mass {
        Mass::Properties(properties) => properties,
        other => unreachable!("the scene computed the mass of each body: {other:?}"),
    }
}

//! One row per kind of abuse, with what is promised for it.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, JointDef, JointKind, Limits, Mass, MassProperties, Motor, Pose};

use crate::catalogue::build;
use crate::chain::add_chain;
use crate::engine::Effort;
use crate::impact::add_wall_and_ball;
use crate::longspan_engine::LongspanEngine;
use crate::metrics::{EndSpeeds, EnergyGrowth, Escaped, Held, HingeOvershoot, JointGap, Metric, NotFinite, Overlap, PeakSpeed};
use crate::params::{Params, SceneError};
use crate::pile::add_pit;
use crate::random::Random;
use crate::run::run;
use crate::scene::{Action, Scene, about_z, ball, cuboid, floor, spherical, start};
use crate::violent::{deep_overlap, violated_limits};

/// What is promised for a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Promise {
    /// Right within the bounds that the row states.
    Accurate,
    /// Finite, without growing energy, within the bounds that the row states; not necessarily right.
    Bounded,
    /// Refused with an error that names this argument.
    Refused(&'static str),
}

impl std::fmt::Display for Promise {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Accurate => f.write_str("accurate"),
            Self::Bounded => f.write_str("bounded"),
            Self::Refused(argument) => write!(f, "refused ({argument})"),
        }
    }
}

/// A row of the table.
pub struct Row {
    /// Value of the key `row`.
    pub name: &'static str,
    /// What is done, in one line.
    pub abuse: &'static str,
    /// What is promised.
    pub promise: Promise,
    /// Builds the scene and says what is measured and within which bounds.
    build: fn(&mut Scene, &mut Random) -> Result<Bounds, SceneError>,
}

/// Metrics of a row beside those that every row has, and the greatest value of each error that is bounded.
#[derive(Default)]
struct Bounds {
    metrics: Vec<Box<dyn Metric>>,
    bounds: Vec<(&'static str, f64)>,
}

impl Bounds {
    fn and(mut self, metric: impl Metric + 'static, bounds: &[(&'static str, f64)]) -> Self {
        self.metrics.push(Box::new(metric));
        self.bounds.extend(bounds);
        self
    }
}

/// The whole table.
pub const ROWS: &[Row] = &[
    row("mass_ratio", "a chain of five with a weight up to 1e9 times a link", Promise::Bounded, mass_ratio),
    row("inertia_ratio", "a spinning chain of bodies with principal inertias up to 1e6 apart", Promise::Bounded, inertia_ratio),
    row("size", "three cubes of 1 mm to 1 km on one another", Promise::Accurate, size),
    row("speed", "a ball at up to 1 km/s against a wall of 10 cm", Promise::Bounded, speed),
    row("step_size", "a chain and a stack under steps of 1/1000 to 1/10 s that keep changing", Promise::Bounded, step_size),
    row("gravity", "bodies in a closed box while gravity turns", Promise::Bounded, gravity),
    row("needles", "needles of 1 m by 2 mm dropped in a heap", Promise::Bounded, needles),
    row("sheets", "sheets of 1 m² by 2 mm dropped in a heap", Promise::Bounded, sheets),
    row("deep_overlap", "twenty cubes created inside one another", Promise::Bounded, overlap),
    row("contradictory_joints", "a bar pinned to two points farther apart than it is long", Promise::Bounded, contradictory),
    row("limits_violated", "a chain of hinges up to a radian past their stops", Promise::Bounded, limits),
    row("motor_against_stop", "a motor of unbounded torque driving a hinge into its stop", Promise::Bounded, motor_against_stop),
    row("many_contacts", "2500 boxes on one plate: 10,000 contact points", Promise::Accurate, many_contacts),
    row("complete_graph", "twelve thrown bodies, every pair joined", Promise::Bounded, complete_graph),
    row("bad_mass", "a mass that is zero, negative, infinite, not a number or out of range", Promise::Refused("mass"), bad_mass),
    row("bad_position", "a position that is not finite or too far away", Promise::Refused("pose.position"), bad_position),
    row("bad_velocity", "a velocity that is not finite or too fast", Promise::Refused("linear_velocity"), bad_velocity),
    row("bad_joint", "limits upside down or not a number", Promise::Refused("limits"), bad_joint),
    row("bad_step", "a step that is zero, negative, too long or not a number", Promise::Refused("dt"), bad_step),
];

const fn row(
    name: &'static str,
    abuse: &'static str,
    promise: Promise,
    build: fn(&mut Scene, &mut Random) -> Result<Bounds, SceneError>,
) -> Row {
    Row { name, abuse, promise, build }
}

pub(crate) fn stress(params: &mut Params) -> Result<Scene, SceneError> {
    let names: Vec<&'static str> = ROWS.iter().map(|row| row.name).collect();
    let chosen = params.word("row", &names)?;
    let mut random = Random::new(params.seed()?);
    let mut scene = start(params, 4.0)?;
    let Some(row) = ROWS.iter().find(|row| row.name == chosen) else {
        unreachable!("the word was chosen among the rows' names");
    };
    let Bounds { mut metrics, mut bounds } = (row.build)(&mut scene, &mut random)?;
    if let Promise::Refused(argument) = row.promise {
        scene.expected_refusal = Some(argument);
    } else {
        metrics.push(Box::new(NotFinite::default()));
        bounds.push(("non_finite", 0.0));
    }
    scene.judge(Held::new(metrics, bounds));
    scene.params.push(("promise".into(), row.promise.to_string()));
    Ok(scene)
}

/// How a row did over many seeds.
#[derive(Debug, Clone, Default)]
pub struct Judged {
    /// Seeds for which the promise held.
    pub held: u64,
    /// Seeds tried.
    pub seeds: u64,
    /// Seeds for which it did not hold.
    pub failed: Vec<u64>,
    /// The greatest share of its bound that an error took; above 1 the promise is broken.
    pub of_bound: f64,
    /// Worst value of each error.
    pub worst: Vec<(&'static str, f64)>,
}

/// Runs a row on our engine with the seeds 1 to `seeds`.
///
/// # Errors
/// If a scene cannot be built or run.
pub fn judge(row: &Row, seeds: u64) -> Result<Judged, Box<dyn std::error::Error>> {
    let mut judged = Judged { seeds, ..Judged::default() };
    for seed in 1..=seeds {
        let scene = build("stress", &[("row".into(), row.name.into()), ("seed".into(), seed.to_string())])?;
        let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1)?;
        for (name, value) in run(scene, &mut engine, Effort::Default, 1)?.errors {
            match name {
                "held" if value == 1.0 => judged.held += 1,
                "held" => judged.failed.push(seed),
                "of_bound" => judged.of_bound = judged.of_bound.max(value),
                _ => match judged.worst.iter_mut().find(|(known, _)| *known == name) {
                    Some((_, worst)) => *worst = worst.max(value),
                    None => judged.worst.push((name, value)),
                },
            }
        }
    }
    Ok(judged)
}

/// Rise of energy that rounding and recovery from a bad start may cause (%).
const ENERGY: [(&str, f64); 1] = [("energy_growth_pct", 2.0)];

fn mass_ratio(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    add_chain(scene, 5, random.log_between(1.0, 1.0e9), Quat::IDENTITY)?;
    for body in 1..scene.bodies.len() {
        scene.bodies[body].linear_velocity = Vec3::X * 0.2;
    }
    Ok(held_together(scene))
}

/// No energy from nowhere, and joints that stay closed.
fn held_together(scene: &Scene) -> Bounds {
    Bounds::default()
        .and(EnergyGrowth::default(), &ENERGY)
        .and(JointGap::over_last(scene.steps), &[("joint_gap_m", 0.01)])
        .and(PeakSpeed::default(), &[])
}

fn inertia_ratio(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    let mut above = scene.body(BodyDef::fixed(Pose::IDENTITY).with_shape(cuboid(0.05, 0.05, 0.05)?));
    let mut arm = Vec3::Y * -0.05;
    let solid = cuboid(0.05, 0.1, 0.05)?;
    for index in 0..5 {
        let thin = random.log_between(1.0e-6, 1.0) * 0.01;
        let inertia = if random.unit() < 0.5 { Vec3::new(0.01, thin, 0.01) } else { Vec3::new(thin, 0.01, 0.01) };
        let pose = Pose::at_xyz(0.0, -0.15 - 0.2 * f64::from(index), 0.0);
        let mass = Mass::Properties(MassProperties::new(1.0, inertia));
        let mut def = BodyDef::dynamic(pose).with_shape(solid.clone()).with_mass(mass);
        def.angular_velocity = random.vector(10.0);
        let body = scene.body(def);
        scene.joint(Some(above), Some(body), spherical(arm, Vec3::Y * 0.1));
        (above, arm) = (body, Vec3::Y * -0.1);
    }
    // Needles that tumble turn some of what they lose in one substep into speed in another.
    Ok(Bounds::default()
        .and(EnergyGrowth::default(), &[("energy_growth_pct", 25.0)])
        .and(JointGap::over_last(scene.steps), &[("joint_gap_m", 0.01)])
        .and(PeakSpeed::default(), &[]))
}

fn size(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    let edge = random.log_between(1.0e-3, 1.0e3);
    scene.body(floor(1.0e4, 0.0, 0.5)?);
    let half = 0.5 * edge;
    let solid = cuboid(half, half, half)?;
    for level in 0..3 {
        let height = f64::from(half) * (1.0 + 2.0 * f64::from(level));
        scene.body(BodyDef::dynamic(Pose::at_xyz(0.0, height, 0.0)).with_shape(solid.clone()));
    }
    let reach = f64::from(edge);
    let above_floor = Escaped::from(DVec3::new(-reach, 0.0, -reach), DVec3::new(reach, 3.0 * reach, reach));
    Ok(Bounds::default().and(above_floor, &[("escaped", 0.0)]).and(Overlap::at_end(), &[("pen_end_m", 0.01 * reach)]))
}

fn speed(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    scene.world.gravity = Vec3::ZERO;
    let start = -10.0 - random.unit();
    let (def, before_wall) = add_wall_and_ball(scene, 0.05, start, random.log_between(1.0, 1.0e3))?;
    scene.body(def);
    Ok(Bounds::default().and(before_wall, &[("escaped", 0.0)]).and(EnergyGrowth::default(), &ENERGY))
}

fn step_size(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    add_chain(scene, 5, 10.0, Quat::from_rotation_z(1.0))?;
    scene.body(floor(20.0, -10.0, 0.5)?);
    let solid = cuboid(0.25, 0.25, 0.25)?;
    for level in 0..5 {
        let pose = Pose::at_xyz(5.0, -9.75 + 0.5 * f64::from(level), 0.0);
        scene.body(BodyDef::dynamic(pose).with_shape(solid.clone()));
    }
    for step in (0..scene.steps).step_by(10) {
        scene.at(step, Action::SetStep(random.log_between(1.0e-3, 0.1)));
    }
    let reach = DVec3::splat(10.0);
    Ok(held_together(scene).and(Escaped::from(-reach, reach), &[("escaped", 0.0)]))
}

fn gravity(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    add_pit(scene, 2.0, 4.0)?;
    scene.body(BodyDef::fixed(Pose::at_xyz(0.0, 4.5, 0.0)).with_shape(cuboid(3.0, 0.5, 3.0)?));
    for index in 0..27 {
        let place = |part: i32| f64::from(part % 3 - 1) * 0.9;
        let pose = Pose::at_xyz(place(index), 1.5 + place(index / 3), place(index / 9));
        let shape = if index % 2 == 0 { ball(0.25)? } else { cuboid(0.25, 0.2, 0.22)? };
        scene.body(BodyDef::dynamic(pose).with_shape(shape));
    }
    for step in (0..scene.steps).step_by(15) {
        scene.at(step, Action::SetGravity(random.rotation() * Vec3::Y * 9.81));
    }
    let inside = Escaped::from(DVec3::new(-2.1, -0.1, -2.1), DVec3::new(2.1, 4.1, 2.1));
    Ok(Bounds::default().and(inside, &[("escaped", 0.0)]).and(PeakSpeed::default(), &[("speed_peak", 15.0)]))
}

fn needles(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    heap_of(scene, Vec3::new(0.5, 0.001, 0.001), random)
}

fn sheets(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    heap_of(scene, Vec3::new(0.5, 0.001, 0.5), random)
}

fn heap_of(scene: &mut Scene, half: Vec3, random: &mut Random) -> Result<Bounds, SceneError> {
    scene.body(floor(50.0, 0.0, 0.5)?);
    let solid = cuboid(half.x, half.y, half.z)?;
    for level in 0..10 {
        let pose = Pose::at(DVec3::Y * (1.0 + 1.5 * f64::from(level)) + random.vector(0.1).as_dvec3());
        scene.body(BodyDef::dynamic(pose.rotated(random.rotation())).with_shape(solid.clone()));
    }
    let reach = 45.0;
    let above_floor = Escaped::from(DVec3::new(-reach, -0.01, -reach), DVec3::splat(reach));
    Ok(Bounds::default()
        .and(above_floor, &[("escaped", 0.0)])
        .and(EnergyGrowth::default(), &ENERGY)
        .and(EndSpeeds::default(), &[("mean_speed_end", 2.0)]))
}

fn overlap(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    deep_overlap(scene, 20, random)?;
    let reach = 20.0;
    let near = Escaped::from(DVec3::new(-reach, -0.01, -reach), DVec3::splat(reach));
    Ok(Bounds::default()
        .and(near, &[("escaped", 0.0)])
        .and(PeakSpeed::default(), &[("speed_peak", 10.0)])
        .and(EndSpeeds::default(), &[("mean_speed_end", 0.5)]))
}

fn contradictory(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    let apart = 1.0 + random.unit();
    let body = scene.body(BodyDef::dynamic(Pose::IDENTITY).with_shape(cuboid(0.5, 0.05, 0.05)?));
    for sign in [-1.0, 1.0] {
        let mut def = spherical(Vec3::ZERO, Vec3::X * (0.5 * sign as f32));
        def.frame_a = Pose::at_xyz(0.5 * sign * apart, 0.0, 0.0);
        scene.joint(None, Some(body), def);
    }
    Ok(Bounds::default().and(PeakSpeed::default(), &[("speed_peak", 10.0)]).and(EndSpeeds::default(), &[("mean_speed_end", 1.0)]))
}

fn limits(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    violated_limits(scene, 8, random)?;
    // A chain that is folded too far may stay so; it must neither tear nor fly.
    let (settled, steps) = (60.min(scene.steps), scene.steps);
    Ok(Bounds::default()
        .and(HingeOvershoot::since(settled), &[("overshoot_deg", 60.0)])
        .and(JointGap::over_last(steps), &[("joint_gap_m", 0.4)])
        .and(PeakSpeed::default(), &[("speed_peak", 200.0)]))
}

fn motor_against_stop(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    let anchor = scene.body(BodyDef::fixed(Pose::IDENTITY).with_shape(cuboid(0.1, 0.1, 0.1)?));
    let body = scene.body(BodyDef::dynamic(Pose::at_xyz(0.5, 0.0, 0.0)).with_shape(cuboid(0.5, 0.05, 0.05)?));
    let motor = Motor::Velocity { target: random.log_between(0.1, 100.0), max_force: f32::INFINITY };
    let kind = JointKind::Hinge { limits: Limits::new(-0.5, 0.5), motor };
    scene.joint(Some(anchor), Some(body), about_z(kind, Vec3::ZERO, Vec3::X * -0.5));
    let (settled, steps) = (60.min(scene.steps), scene.steps);
    Ok(Bounds::default()
        .and(HingeOvershoot::since(settled), &[("overshoot_deg", 5.0)])
        .and(JointGap::over_last(steps), &[("joint_gap_m", 0.01)]))
}

fn many_contacts(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    scene.body(floor(40.0, 0.0, 0.5)?);
    scene.body(BodyDef::dynamic(Pose::at_xyz(0.0, 0.25, 0.0)).with_shape(cuboid(20.0, 0.25, 20.0)?));
    let solid = cuboid(0.2, 0.2, 0.2)?;
    for index in 0..2500 {
        let along = |place: i32| f64::from(place) * 0.75 - 0.5 * 49.0 * 0.75;
        let aside = random.vector(0.05);
        let pose = Pose::at_xyz(along(index % 50) + f64::from(aside.x), 0.7, along(index / 50) + f64::from(aside.z));
        scene.body(BodyDef::dynamic(pose).with_shape(solid.clone()));
    }
    // The contacts are there at once; a second shows whether they hold.
    scene.steps = scene.steps.min(60);
    scene.window = 0..scene.steps;
    Ok(Bounds::default().and(Overlap::at_end(), &[("pen_end_m", 0.005)]).and(EndSpeeds::default(), &[("mean_speed_end", 0.05)]))
}

fn complete_graph(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    scene.world.gravity = Vec3::ZERO;
    let mut solid = ball(0.05)?;
    solid.filter.collides_with = 0;
    let bodies: Vec<usize> = (0..12)
        .map(|_| {
            let mut def = BodyDef::dynamic(Pose::at(random.vector(1.0).as_dvec3())).with_shape(solid.clone());
            def.linear_velocity = random.vector(5.0);
            scene.body(def.with_mass(Mass::Total(1.0)))
        })
        .collect();
    for &b in &bodies {
        for &a in &bodies[..b] {
            let length = scene.bodies[a].pose.position.distance(scene.bodies[b].pose.position) as f32;
            let limits = Limits::new(length, length);
            let kind = JointKind::Distance { limits, spring_length: None, motor: Motor::Off };
            scene.joint(Some(a), Some(b), JointDef::new(kind, BodyId::NULL, BodyId::NULL));
        }
    }
    let steps = scene.steps / 2;
    Ok(Bounds::default().and(EnergyGrowth::default(), &ENERGY).and(JointGap::over_last(steps), &[("joint_gap_m", 0.01)]))
}

fn bad_mass(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    let bad = [0.0, -1.0, f32::INFINITY, f32::NAN, 1.0e-12, 1.0e13];
    let mass = Mass::Properties(MassProperties::new(bad[random.index(bad.len())], Vec3::ONE));
    scene.body(BodyDef::dynamic(Pose::IDENTITY).with_shape(ball(0.5)?).with_mass(mass));
    Ok(Bounds::default())
}

fn bad_position(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    let bad = [f64::NAN, f64::INFINITY, -1.0e10];
    scene.body(BodyDef::dynamic(Pose::at_xyz(0.0, bad[random.index(bad.len())], 0.0)).with_shape(ball(0.5)?));
    Ok(Bounds::default())
}

fn bad_velocity(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    let bad = [f32::NAN, f32::NEG_INFINITY, 1.0e6];
    let mut def = BodyDef::dynamic(Pose::IDENTITY).with_shape(ball(0.5)?);
    def.linear_velocity.z = bad[random.index(bad.len())];
    scene.body(def);
    Ok(Bounds::default())
}

fn bad_joint(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    let bad = [Limits::new(1.0, -1.0), Limits::new(f32::NAN, 1.0), Limits::new(f32::INFINITY, f32::NEG_INFINITY)];
    let body = scene.body(BodyDef::dynamic(Pose::IDENTITY).with_shape(ball(0.5)?));
    let kind = JointKind::Hinge { limits: bad[random.index(bad.len())], motor: Motor::Off };
    scene.joint(None, Some(body), about_z(kind, Vec3::ZERO, Vec3::ZERO));
    Ok(Bounds::default())
}

fn bad_step(scene: &mut Scene, random: &mut Random) -> Result<Bounds, SceneError> {
    let bad = [0.0, -0.01, 2.0, f32::NAN];
    scene.dt = bad[random.index(bad.len())];
    scene.body(BodyDef::dynamic(Pose::IDENTITY).with_shape(ball(0.5)?));
    Ok(Bounds::default())
}

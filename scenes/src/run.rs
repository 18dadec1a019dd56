//! Runs a scene on an engine and lets the metrics judge. Times are taken of runs of their own, by [`crate::time`].

use longspan::glam::{DMat3, Vec3};
use longspan::{BodyDef, MassProperties};

use crate::engine::{Effort, Engine};
use crate::metrics::{Errors, View, world_inertia};
use crate::scene::{Action, Scene};
use crate::shifted::Shifted;
use crate::units::Converted;

/// What a non-finite error is written as.
pub const NOT_FINITE: f64 = 1.0e30;

/// Largest relative difference of mass and inertia that an engine may hold against the scene's.
const MASS_TOLERANCE: f64 = 1.0e-3;

/// How a run went.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// Name of the scene.
    pub scene: &'static str,
    /// Every key of the scene and its value.
    pub params: Vec<(String, String)>,
    /// Name of the engine.
    pub engine: &'static str,
    /// Effort it ran at.
    pub effort: Effort,
    /// Threads it ran on.
    pub threads: usize,
    /// Steps done.
    pub steps: u32,
    /// Errors by name; what is not finite is [`NOT_FINITE`].
    pub errors: Vec<(&'static str, f64)>,
}

/// Why a run gave no measurement.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RunError {
    /// The engine refused a part of the scene.
    #[error("{engine} refuses the scene: {problem}")]
    Refused {
        /// The engine.
        engine: &'static str,
        /// What it says.
        problem: String,
    },
    /// The engine cannot do what the scene's script asks.
    #[error("{engine} cannot run the scene: it has no {feature}")]
    Unsupported {
        /// The engine.
        engine: &'static str,
        /// What it lacks.
        feature: &'static str,
    },
    /// The engine computes with another mass than the scene gave it.
    #[error("{engine} holds another mass or inertia for body {body} than the scene gave it: {found}")]
    OtherMass {
        /// The engine.
        engine: &'static str,
        /// The body.
        body: usize,
        /// Mass (kg) given and held.
        found: String,
    },
}

/// Runs `scene` on a fresh engine whose world was made from `scene.world`.
///
/// # Errors
/// If the engine refuses or cannot run the scene.
pub fn run(scene: Scene, engine: &mut dyn Engine, effort: Effort, threads: usize) -> Result<Measurement, RunError> {
    run_watched(scene, engine, effort, threads, &mut |_| {})
}

/// As [`run`], with somebody watching: `watch` sees what a metric sees, once before the first step and once after each.
///
/// # Errors
/// If the engine refuses or cannot run the scene.
pub fn run_watched(
    mut scene: Scene,
    engine: &mut dyn Engine,
    effort: Effort,
    threads: usize,
    watch: &mut dyn FnMut(&View),
) -> Result<Measurement, RunError> {
    let name = engine.name();
    let mut engine = Shifted { engine, origin: scene.origin };
    let mut engine = Converted::new(&mut engine, scene.units, scene.world.gravity)?;
    let mut metrics = std::mem::take(&mut scene.metrics);
    let mut stage = Stage::set(&scene, &mut engine);
    let mut steps = 0;
    let mut script = scene.script.iter().peekable();
    loop {
        if let Some(problem) = engine.refusal() {
            let Some(argument) = scene.expected_refusal else { return Err(RunError::Refused { engine: name, problem }) };
            let errors = vec![("held", f64::from(u8::from(problem.starts_with(argument))))];
            return Ok(measurement(&scene, name, effort, threads, steps, errors));
        }
        let view = stage.view(&scene, &engine, steps);
        for metric in &mut metrics {
            metric.observe(&view);
        }
        watch(&view);
        if steps == 1 {
            stage.check_masses(&engine)?;
        }
        if steps == scene.steps {
            break;
        }
        while let Some(scheduled) = script.next_if(|scheduled| scheduled.step <= steps) {
            stage.act(&scheduled.action, &mut engine)?;
        }
        stage.step(&mut engine);
        steps += 1;
    }

    let mut errors = Errors::new();
    if scene.expected_refusal.is_some() {
        errors.push(("held", 0.0));
    }
    for metric in &metrics {
        metric.report(&mut errors);
    }
    Ok(measurement(&scene, name, effort, threads, steps, errors))
}

fn measurement(
    scene: &Scene,
    engine: &'static str,
    effort: Effort,
    threads: usize,
    steps: u32,
    mut errors: Errors,
) -> Measurement {
    for (_, value) in &mut errors {
        if !value.is_finite() {
            *value = NOT_FINITE;
        }
    }
    Measurement { scene: scene.name, params: scene.params.clone(), engine, effort, threads, steps, errors }
}

/// The bodies that the engine holds and the settings that a script may change.
pub(crate) struct Stage {
    bodies: Vec<BodyDef>,
    alive: Vec<bool>,
    gravity: Vec3,
    dt: f32,
    /// Simulated time so far (s).
    pub(crate) time: f64,
}

impl Stage {
    pub(crate) fn set(scene: &Scene, engine: &mut dyn Engine) -> Self {
        for def in &scene.bodies {
            engine.add_body(def);
        }
        for joint in &scene.joints {
            engine.add_joint(joint);
        }
        for bound in &scene.soft_bounds {
            engine.add_soft_bound(bound);
        }
        Self {
            bodies: scene.bodies.clone(),
            alive: vec![true; scene.bodies.len()],
            gravity: scene.world.gravity,
            dt: scene.dt,
            time: 0.0,
        }
    }

    fn view<'a>(&'a self, scene: &'a Scene, engine: &'a dyn Engine, step: u32) -> View<'a> {
        View {
            step,
            steps: scene.steps,
            time: self.time,
            gravity: self.gravity,
            engine,
            bodies: &self.bodies,
            alive: &self.alive,
            joints: &scene.joints,
        }
    }

    /// Advances the engine by the step size of the moment.
    pub(crate) fn step(&mut self, engine: &mut dyn Engine) {
        engine.step(self.dt);
        self.time += f64::from(self.dt);
    }

    pub(crate) fn act(&mut self, action: &Action, engine: &mut dyn Engine) -> Result<(), RunError> {
        match action {
            Action::Add(def) => {
                engine.add_body(def);
                self.bodies.push(def.clone());
                self.alive.push(true);
            }
            Action::Remove(body) => {
                engine.remove_body(*body);
                self.alive[*body] = false;
            }
            Action::SetLinearVelocity(body, velocity) => engine.set_linear_velocity(*body, *velocity),
            Action::Push(body, impulse) => engine.apply_impulse(*body, *impulse),
            &Action::PushTo { body, along, speed, most } => {
                let longspan::Mass::Properties(mass) = self.bodies[body].mass else { return Ok(()) };
                let missing = mass.mass * (speed - engine.linear_velocity(body).dot(along));
                engine.apply_impulse(body, along * missing.clamp(-most * self.dt, most * self.dt));
            }
            Action::SetStep(dt) => self.dt = *dt,
            Action::SetGravity(gravity) => {
                if !engine.set_gravity(*gravity) {
                    return Err(RunError::Unsupported { engine: engine.name(), feature: "gravity that changes" });
                }
                self.gravity = *gravity;
            }
        }
        Ok(())
    }

    fn check_masses(&self, engine: &dyn Engine) -> Result<(), RunError> {
        for (body, def) in self.bodies.iter().enumerate().filter(|(body, _)| self.alive[*body]) {
            if let (longspan::Mass::Properties(given), Some(held)) = (def.mass, engine.mass_properties(body))
                && !same_mass(&given, &held)
            {
                let found = format!("{} kg given, {} kg held", given.mass, held.mass);
                return Err(RunError::OtherMass { engine: engine.name(), body, found });
            }
        }
        Ok(())
    }
}

/// Compares masses, and inertia as tensors: principal axes may be numbered in any order.
fn same_mass(given: &MassProperties, held: &MassProperties) -> bool {
    let size = |m: DMat3| m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length());
    let tensor = |mass: &MassProperties| world_inertia(mass, &longspan::Pose::IDENTITY);
    let inertia_apart = size(tensor(given) - tensor(held)) / size(tensor(given));
    let mass_apart = f64::from(given.mass - held.mass).abs() / f64::from(given.mass);
    inertia_apart < MASS_TOLERANCE && mass_apart < MASS_TOLERANCE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::{CATALOGUE, build};
    use crate::longspan_engine::LongspanEngine;
    use crate::stress::{Promise, ROWS};

    fn measure(name: &str, keys: &[(&str, &str)]) -> Measurement {
        let given: Vec<(String, String)> = keys.iter().map(|(key, value)| ((*key).into(), (*value).into())).collect();
        let scene = build(name, &given).unwrap_or_else(|error| panic!("{name}: {error}"));
        let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1).unwrap();
        run(scene, &mut engine, Effort::Default, 1).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn error(run: &Measurement, name: &str) -> f64 {
        let found = run.errors.iter().find(|(found, _)| *found == name);
        found.unwrap_or_else(|| panic!("{} reports no {name}", run.scene)).1
    }

    #[test]
    fn every_scene_runs_on_our_engine_and_reports_errors() {
        for entry in CATALOGUE {
            let run = measure(entry.name, &[("seconds", "0.05")]);
            assert_eq!(run.steps, 3, "steps of {}", entry.name);
            assert!(!run.errors.is_empty(), "{} reports nothing", entry.name);
        }
    }

    #[test]
    fn what_is_promised_to_be_refused_is_refused_by_name() {
        for row in ROWS.iter().filter(|row| matches!(row.promise, Promise::Refused(_))) {
            for seed in 0..10 {
                let run = measure("stress", &[("row", row.name), ("seed", &seed.to_string())]);
                assert_eq!(error(&run, "held"), 1.0, "row {}, seed {seed}", row.name);
            }
        }
    }

    #[test]
    fn a_scene_far_away_is_the_same_scene() {
        let far = measure("far_origin", &[("of", "pile"), ("n", "8"), ("offset_km", "10"), ("seconds", "0.5")]);
        let near = measure("pile", &[("n", "8"), ("seconds", "0.5")]);
        let apart = (error(&far, "mean_speed_end") - error(&near, "mean_speed_end")).abs();
        assert!(apart < 1e-4, "speeds differ by {apart} m/s after a fall of half a second, bound 1e-4 m/s");
        assert_eq!(error(&far, "escaped"), 0.0);
    }
}

//! Running scenes, and saying what was promised and what was found.
#![allow(dead_code, reason = "each test program uses a part of this")]

pub mod motor_kinds;
pub mod oracle;

use longspan::World;
use longspan_scenes::{Effort, LongspanEngine, Measurement, Scene, build, run, run_watched};

/// A scene of the library with these keys.
pub fn scene(name: &str, keys: &[(&str, &str)]) -> Scene {
    let given: Vec<(String, String)> = keys.iter().map(|(key, value)| ((*key).into(), (*value).into())).collect();
    build(name, &given).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// A scene's run and the engine it ran on.
pub struct Run {
    pub measured: Measurement,
    pub engine: LongspanEngine,
}

impl Run {
    /// Runs a scene to its end.
    pub fn of(name: &str, keys: &[(&str, &str)]) -> Self {
        Self::on_threads(scene(name, keys), 1)
    }

    pub fn on_threads(scene: Scene, threads: usize) -> Self {
        let mut engine = LongspanEngine::new(&scene.world, Effort::Default, threads).expect("the scene's world is valid");
        let measured = run(scene, &mut engine, Effort::Default, threads).unwrap_or_else(|error| panic!("{error}"));
        Self { measured, engine }.complete()
    }

    /// Runs a scene while `watch` looks at it before the first step and after each.
    pub fn watched(scene: Scene, mut watch: impl FnMut(&longspan_scenes::metrics::View)) -> Self {
        let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1).expect("the scene's world is valid");
        let measured = run_watched(scene, &mut engine, Effort::Default, 1, &mut watch).unwrap_or_else(|error| panic!("{error}"));
        Self { measured, engine }.complete()
    }

    /// This run, of which no body was lost: errors are of what is left, and a scene that has come apart may have none.
    #[track_caller]
    fn complete(self) -> Self {
        let lost = self.engine.quarantined();
        assert!(lost == 0, "{}: {lost} bodies have been quarantined", self.what());
        self
    }

    pub fn world(&self) -> &World {
        self.engine.world()
    }

    /// An error that the scene reports.
    pub fn error(&self, name: &str) -> f64 {
        let found = self.measured.errors.iter().find(|(found, _)| *found == name);
        found.unwrap_or_else(|| panic!("{} reports no {name}", self.measured.scene)).1
    }

    /// Asserts that an error keeps its bound.
    #[track_caller]
    pub fn keeps(&self, name: &str, bound: f64, unit: &str) {
        let found = self.error(name);
        assert!(found <= bound, "{}: {name} is {found:.4e} {unit}, bound {bound:e} {unit}", self.what());
    }

    /// Asserts that an error is exactly this number.
    #[track_caller]
    pub fn is(&self, name: &str, expected: f64) {
        let found = self.error(name);
        assert!(found == expected, "{}: {name} is {found}, expected {expected}", self.what());
    }

    fn what(&self) -> String {
        let keys: Vec<String> = self.measured.params.iter().map(|(key, value)| format!("{key}={value}")).collect();
        format!("{} {}", self.measured.scene, keys.join(" "))
    }
}

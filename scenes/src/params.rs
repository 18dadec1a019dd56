//! Keys and values of a scene: each is asked for once, with its default and range, so that what is valid is known to the scene alone.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

use longspan::{SleepSettings, Solver, WorldDef};

/// Long-range kinds that a run can switch off one by one.
pub const LONG_RANGE_KINDS: [&str; 9] =
    ["long_range", "attachment", "hierarchy", "soft", "plane_position", "plane_axis", "union", "support", "thrust"];

/// Why a scene cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// No scene of that name.
    #[error("no scene is called '{name}'; the scenes are: {valid}")]
    UnknownScene {
        /// The name asked for.
        name: String,
        /// Names that exist, separated by commas.
        valid: String,
    },
    /// The scene has no such key.
    #[error("scene '{scene}' has no key '{key}'; its keys are: {valid}")]
    UnknownKey {
        /// The scene.
        scene: &'static str,
        /// The key asked for.
        key: String,
        /// Keys that exist, separated by commas.
        valid: String,
    },
    /// The value is none of those that the key takes.
    #[error("{key}={value}: must be {expected}")]
    BadValue {
        /// The key.
        key: String,
        /// The value given.
        value: String,
        /// What it may be.
        expected: String,
    },
    /// The library refused a part of the scene.
    #[error("the library refuses the scene: {0}")]
    Refused(#[from] longspan::Error),
}

/// Keys and values given by the user, and those that the scene has asked for.
#[derive(Debug, Clone, Default)]
pub struct Params {
    given: Vec<(String, String)>,
    asked: Vec<(String, String)>,
}

/// Keys that every scene takes beside the kinds of long-range constraints.
const COMMON: [&str; 12] = [
    "seconds",
    "solver",
    "substeps",
    "iterations",
    "error_target",
    "most_substeps",
    "sleep",
    "hold",
    "scale",
    "slow",
    "heavy",
    "finer",
];

impl Params {
    /// Of two values of one key the later counts.
    pub fn new(given: &[(String, String)]) -> Self {
        Self { given: given.to_vec(), asked: Vec::new() }
    }

    fn given(&self, key: &str) -> Option<String> {
        self.given.iter().rev().find(|(given, _)| given == key).map(|(_, value)| value.clone())
    }

    fn parsed<T: FromStr + PartialOrd + Display>(
        &mut self,
        key: &str,
        default: T,
        range: RangeInclusive<T>,
    ) -> Result<T, SceneError> {
        let value = match self.given(key) {
            None => default,
            Some(text) => match text.parse() {
                Ok(value) if range.contains(&value) => value,
                _ => {
                    let expected = format!("a number from {} to {}", range.start(), range.end());
                    return Err(SceneError::BadValue { key: key.into(), value: text, expected });
                }
            },
        };
        self.asked.push((key.into(), value.to_string()));
        Ok(value)
    }

    /// A real number in `range`.
    pub fn number(&mut self, key: &str, default: f64, range: RangeInclusive<f64>) -> Result<f64, SceneError> {
        self.parsed(key, default, range)
    }

    /// A whole number in `range`.
    pub fn count(&mut self, key: &str, default: usize, range: RangeInclusive<usize>) -> Result<usize, SceneError> {
        self.parsed(key, default, range)
    }

    /// Seed of the scene's random numbers.
    pub fn seed(&mut self) -> Result<u64, SceneError> {
        self.parsed("seed", 1, 0..=u64::MAX)
    }

    /// One of `words`; the first is the default.
    pub fn word(&mut self, key: &str, words: &[&'static str]) -> Result<&'static str, SceneError> {
        let chosen = match self.given(key) {
            None => words[0],
            Some(text) => match words.iter().find(|word| **word == text) {
                Some(word) => word,
                None => {
                    let expected = format!("one of {}", words.join(", "));
                    return Err(SceneError::BadValue { key: key.into(), value: text, expected });
                }
            },
        };
        self.asked.push((key.into(), chosen.into()));
        Ok(chosen)
    }

    /// `on` or `off`.
    pub fn switch(&mut self, key: &str, default: bool) -> Result<bool, SceneError> {
        let words = if default { ["on", "off"] } else { ["off", "on"] };
        Ok(self.word(key, &words)? == "on")
    }

    /// Every key that the scene asked for, with its value.
    pub fn into_asked(self) -> Vec<(String, String)> {
        self.asked
    }

    /// Applies the keys that every scene takes, [`COMMON`] and the long-range kinds. They are recorded only if given.
    pub(crate) fn apply_common(&mut self, world: &mut WorldDef) -> Result<(), SceneError> {
        if self.given("solver").is_some() {
            world.solver = match self.word("solver", &["auto", "gs", "direct"])? {
                "gs" => Solver::GaussSeidel,
                "direct" => Solver::Direct,
                _ => Solver::Auto,
            };
        }
        for kind in LONG_RANGE_KINDS {
            if self.given(kind).is_some() {
                let on = self.switch(kind, false)?;
                match kind {
                    "long_range" => world.long_range.enabled = on,
                    "attachment" => world.long_range.attachment.enabled = on,
                    "support" => (world.support, world.hold) = (on, on),
                    "thrust" => world.support_by_thrust = on,
                    "soft" => world.long_range.soft = on,
                    "union" => world.long_range.union = on,
                    "plane_position" => world.long_range.plane_position = on,
                    "plane_axis" => world.long_range.plane_axis = on,
                    "hierarchy" => world.long_range.hierarchy.enabled = on,
                    _ => {}
                }
            }
        }
        if self.given("substeps").is_some() {
            world.substeps = self.parsed("substeps", world.substeps, 1..=256)?;
        }
        if self.given("iterations").is_some() {
            world.iterations = self.parsed("iterations", world.iterations, 1..=256)?;
        }
        if self.given("error_target").is_some() {
            world.articulations.error_target = self.parsed("error_target", world.articulations.error_target, 0.0..=1.0e3)?;
        }
        if self.given("most_substeps").is_some() {
            world.articulations.most_substeps = self.parsed("most_substeps", world.articulations.most_substeps, 0..=64)?;
        }
        if self.given("hold").is_some() {
            world.hold = self.switch("hold", false)?;
        }
        if self.given("sleep").is_some() {
            world.sleep = SleepSettings { enabled: self.switch("sleep", false)?, ..world.sleep };
        }
        Ok(())
    }

    /// Factors in `range` that are one unless given, and recorded only then.
    pub(crate) fn factors<const N: usize>(
        &mut self,
        keys: [&str; N],
        range: RangeInclusive<f64>,
    ) -> Result<[f64; N], SceneError> {
        let mut factors = [1.0; N];
        for (key, factor) in keys.into_iter().zip(&mut factors).filter(|(key, _)| self.given(key).is_some()).collect::<Vec<_>>() {
            *factor = self.number(key, 1.0, range.clone())?;
        }
        Ok(factors)
    }

    /// Steps of a scene that lasts `seconds` unless the user set its length.
    pub fn steps(&mut self, seconds: f64, dt: f32) -> Result<u32, SceneError> {
        let seconds = match self.given("seconds") {
            None => seconds,
            Some(_) => self.number("seconds", seconds, 0.0..=1.0e5)?,
        };
        Ok((seconds / f64::from(dt)).round().max(1.0) as u32)
    }

    /// Refuses keys that nobody asked for.
    pub(crate) fn check_all_used(&self, scene: &'static str) -> Result<(), SceneError> {
        match self.given.iter().find(|(key, _)| !self.asked.iter().any(|(asked, _)| asked == key)) {
            None => Ok(()),
            Some((key, _)) => {
                let common = COMMON.into_iter().chain(LONG_RANGE_KINDS);
                let asked = self.asked.iter().map(|(key, _)| key.as_str());
                let own: Vec<&str> = asked.filter(|key| !common.clone().any(|common| common == *key)).collect();
                let valid = own.into_iter().chain(common.clone()).collect::<Vec<_>>().join(", ");
                Err(SceneError::UnknownKey { scene, key: key.clone(), valid })
            }
        }
    }
}

//! What each scene of the catalogue promises, at which rates and sizes, and at which other numbers it is tried.

use crate::catalogue::build;
use crate::engine::Effort;
use crate::longspan_engine::LongspanEngine;
use crate::run::run;

/// Keys of a scene and their values.
pub type Keys = &'static [(&'static str, &'static str)];

/// A scene, and the most that some of its errors may be.
pub type Promise = (&'static str, &'static [(&'static str, f64)]);

/// A scene, one of its keys, and other values than the one that it is made with.
pub type Holdout = (&'static str, &'static str, &'static [&'static str]);

/// How a scene is run: its key `rate`, where it has one, or others.
pub const AT: [(&str, Keys); 6] = [
    ("60 Hz", &[]),
    ("30 Hz", &[("rate", "30")]),
    ("120 Hz", &[("finer", "2")]),
    ("240 Hz", &[("finer", "4")]),
    // Times go with the root of lengths, so that gravity is that of the earth; steps stay as long, or nearly.
    ("a tenth of the size", &[("scale", "0.1"), ("slow", "0.316227766")]),
    ("ten times the size", &[("scale", "10"), ("slow", "3.16227766"), ("finer", "3")]),
];

/// What hangs and spans. The greatest errors over all of [`AT`] are a half to a tenth of these bounds, and those of gaps less.
pub const JOINTS: &[Promise] = &[
    ("hanging_chain", &[("stretch_pct", 3e-4), ("joint_gap_m", 5e-6), ("load_err_pct", 1e-2)]),
    ("swinging_weight", &[("traj_err_max_m", 1e-2), ("stretch_pct", 1e-2), ("energy_drift_pct", 0.1)]),
    ("lifted_chain", &[("stretch_pct", 1e-2), ("joint_gap_m", 5e-5)]),
    ("footbridge", &[("joint_gap_m", 1e-6), ("pen_max_m", 1e-4), ("sag_m", 2e-3)]),
    ("cable_car", &[("stretch_pct", 2e-5), ("joint_gap_m", 1e-6)]),
    ("mobile", &[("stretch_pct", 2e-3), ("joint_gap_m", 5e-5), ("energy_drift_pct", 2e-3), ("energy_rise_pct", 1e-4)]),
    ("cantilever", &[("limit_err_deg", 1e-2), ("joint_gap_m", 3e-4), ("energy_drift_pct", 5.0), ("energy_rise_pct", 1e-2)]),
    ("arm", &[("servo_err_deg", 5e-3), ("joint_gap_m", 5e-5), ("unexplained_rise_pct", 1.0)]),
    ("crane", &[("stretch_pct", 1e-3), ("joint_gap_m", 2e-5), ("unexplained_rise_pct", 1e-2)]),
    ("excavator", &[("servo_err_deg", 5e-4), ("slip_m", 1e-4), ("pen_max_m", 1e-5), ("unexplained_rise_pct", 5e-2)]),
    ("elevator", &[("behind_m", 1e-6), ("hop_m", 1e-6), ("load_err_pct", 1e-4)]),
    ("gripper", &[("slid_m", 5e-4), ("joint_gap_m", 1e-6)]),
    ("scissor_lift", &[("sunk_m", 1e-6), ("load_err_pct", 1e-3), ("joint_gap_m", 1e-6)]),
    ("bollard", &[("moved_m", 5e-3), ("joint_gap_m", 1e-6)]),
    ("capstan", &[("slid_m", 1e-3), ("joint_gap_m", 1e-6)]),
    ("winch", &[("wound_err_pct", 2.0), ("joint_gap_m", 2e-4)]),
    ("pulley", &[("fallen_err_pct", 2.0), ("joint_gap_m", 2e-5)]),
    ("tensegrity", &[("sunk_m", 2e-2), ("joint_gap_m", 2e-4), ("speed_m_s", 5e-3)]),
    ("hinge_loop", &[("plane_rms_m", 2e-6), ("joint_gap_m", 5e-5), ("ang_momentum_err_pct", 5e-5)]),
    ("free_cluster", &[("lin_momentum_err_pct", 2e-3), ("ang_momentum_err_pct", 2e-3), ("joint_gap_m", 1e-3)]),
    ("pendulum", &[("period_err_pct", 5e-2), ("energy_drift_pct", 0.2), ("energy_rise_pct", 1e-3)]),
    ("spring", &[("pos_err_max_m", 5e-4), ("period_err_pct", 0.1)]),
    ("hinge_motor", &[("spin_err_pct", 2e-3)]),
    ("hinge_servo", &[("angle_err_deg", 1e-5)]),
    ("stiff_hinge", &[("spin_err_pct", 5e-3), ("swing_err_pct", 1.0)]),
    ("hinge_limit", &[("overshoot_deg", 1e-4), ("joint_gap_m", 5e-5)]),
    ("net", &[("fallen", 0.0), ("joint_gap_m", 1e-3), ("energy_growth_pct", 0.1)]),
    ("breaking_beam", &[("break_load_err_pct", 1.0)]),
];

/// What stands, slides, rolls and flies.
pub const CONTACTS: &[Promise] = &[
    ("heavy_on_light", &[("pen_max_m", 2e-5), ("speed_max", 1e-6)]),
    ("column", &[("drift_m", 1e-6), ("sink_m", 1e-6), ("pen_max_m", 1e-6)]),
    ("arch", &[("drift_m", 2e-6), ("sink_m", 1e-5), ("speed_max_end", 1e-6)]),
    ("lamp_arch", &[("sunk_m", 1e-5), ("joint_gap_m", 5e-6)]),
    ("support_gallery", &[("wrong_verdicts", 0.0)]),
    ("wedge", &[("drift_m", 5e-6), ("sink_m", 2e-4), ("speed_max_end", 1e-6)]),
    ("card_house", &[("drift_m", 2e-2), ("sink_m", 2e-3), ("speed_max_end", 1e-6)]),
    ("free_gyro", &[("ang_momentum_err_pct", 1e-2), ("energy_err_pct", 2e-2)]),
    ("damping", &[("speed_err_pct", 0.1), ("spin_err_pct", 0.2)]),
    ("box_on_plane", &[("force_err_pct", 1e-4), ("drift_m", 1e-6), ("pen_max_m", 1e-6)]),
    ("slope", &[("way_err_m", 5e-5)]),
    ("bounce", &[("height_err_pct", 1.0)]),
    ("projectile", &[("pos_err_max_m", 5e-4)]),
    ("platform", &[("pos_err_max_m", 5e-4)]),
    ("rolling", &[("way_err_pct", 0.5)]),
    ("spinning", &[("spin_err_pct", 1e-2)]),
    ("locked_axes", &[("locked_shift_m", 1e-6), ("locked_turn_deg", 1e-6)]),
    ("bullet", &[("escaped", 0.0)]),
    ("resting", &[("speed_max", 1e-6), ("pen_max_m", 1e-6)]),
];

/// Three fewer and seven more of what a scene counts, half and twice as many; and loads of other sizes. Nothing was tuned for any of them.
pub const HOLDOUTS: &[Holdout] = &[
    ("hanging_chain", "n", &["15", "27", "37", "60"]),
    ("swinging_weight", "n", &["15", "27", "37", "60"]),
    ("lifted_chain", "n", &["50", "97", "107", "200"]),
    ("footbridge", "planks", &["12", "21", "31", "48"]),
    ("footbridge", "load", &["8", "80", "8000"]),
    ("cable_car", "n", &["97", "107", "200"]),
    ("hinge_loop", "n", &["66", "129", "139", "264"]),
    ("mobile", "levels", &["3", "4", "6", "7"]),
    ("cantilever", "n", &["15", "27", "37", "60"]),
    ("crane", "links", &["10", "17", "27", "40"]),
    ("crane", "load", &["50", "500", "50000"]),
    ("arm", "payload", &["20", "50", "400"]),
    ("excavator", "mass", &["25", "100", "1000"]),
    ("elevator", "load", &["50", "500", "50000"]),
    ("gripper", "load", &["2", "10", "25"]),
    ("scissor_lift", "stages", &["4", "5", "15"]),
    ("scissor_lift", "load", &["20", "200", "20000"]),
    ("bollard", "load", &["10", "100", "10000"]),
    ("capstan", "load", &["10", "50", "1000"]),
    ("winch", "load", &["50", "250", "1000"]),
    ("pulley", "load", &["410", "450", "600"]),
    ("tensegrity", "storeys", &["2", "3", "6"]),
    ("tensegrity", "load", &["1", "10", "300"]),
    ("net", "cells", &["3", "13"]),
    ("net", "mass", &["3", "10", "60"]),
    ("heavy_on_light", "ratio", &["100", "1000", "100000"]),
    ("column", "n", &["10", "17", "27", "40"]),
    ("arch", "n", &["5", "8", "18", "22", "31"]),
    ("lamp_arch", "n", &["6", "10", "20", "26", "31"]),
    ("lamp_arch", "lamp", &["0.01", "1", "300", "1000"]),
    ("card_house", "levels", &["2", "4", "5"]),
    ("slope", "angle_deg", &["5", "26", "27", "40"]),
    ("bounce", "restitution", &["0.1", "0.8", "1"]),
    ("rolling", "speed", &["0.5", "5"]),
];

/// The error of a run that is the greatest share of what is promised for it.
#[derive(Debug, Clone, Copy)]
pub struct Kept {
    /// Error over its bound; infinite where it must be zero and is not, is no number, is not reported, or where bodies were lost.
    pub share: f64,
    /// Name of the error.
    pub error: &'static str,
    /// The error itself, in the scene's own units.
    pub found: f64,
}

/// Runs a scene with these keys on our engine, and finds which of its errors is the greatest share of its bound.
///
/// # Errors
/// If the scene cannot be built or run.
pub fn judge((scene, bounds): Promise, keys: &[(&str, &str)]) -> Result<Kept, Box<dyn std::error::Error>> {
    let keys: Vec<_> = keys.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
    let scene = build(scene, &keys)?;
    let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1)?;
    let measured = run(scene, &mut engine, Effort::Default, 1)?;
    let is_whole = engine.quarantined() == 0;
    let kept = bounds.iter().map(|&(error, most)| {
        // A scene that has come apart may not report an error any more: it is infinite then, as one that is no number is.
        let found = measured.errors.iter().find(|(name, _)| *name == error).map_or(f64::INFINITY, |(_, found)| *found);
        let share = if is_whole && found <= 0.0 {
            0.0
        } else if is_whole && most > 0.0 && found < f64::INFINITY {
            found / most
        } else {
            f64::INFINITY
        };
        Kept { share, error, found }
    });
    kept.max_by(|a, b| a.share.total_cmp(&b.share)).ok_or_else(|| "the scene promises nothing".into())
}

/// Whether a scene has a key.
///
/// # Errors
/// If the scene cannot be built.
pub fn has_key(scene: &str, key: &str) -> Result<bool, crate::params::SceneError> {
    Ok(build(scene, &[])?.params.iter().any(|(name, _)| *name == key))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An error that a scene does not report, as after a change of its name, breaks the promise.
    #[test]
    fn what_is_not_reported_is_not_kept() {
        let keys = [("seconds", "0.1")];
        let kept = judge(("hanging_chain", &[("joint_gap_m", 1.0), ("no_such_error", 1.0)]), &keys).unwrap();
        assert_eq!((kept.error, kept.share), ("no_such_error", f64::INFINITY));
        let kept = judge(("hanging_chain", &[("joint_gap_m", 1.0)]), &keys).unwrap();
        assert!(kept.share < 1.0e-3, "{kept:?}");
    }
}

//! Scenes keep their promises at other rates and sizes: at 30, 120 and 240 steps a second, and a tenth and ten times as large on the same
//! earth. All bounds are in the scene's own units, so that one holds for all of them.

use crate::common::{Run, scene};

/// How a scene is run: its key `rate`, where it has one, or others.
const AT: [(&str, &[(&str, &str)]); 6] = [
    ("60 Hz", &[]),
    ("30 Hz", &[("rate", "30")]),
    ("120 Hz", &[("finer", "2")]),
    ("240 Hz", &[("finer", "4")]),
    // Times go with the root of lengths, so that gravity is that of the earth; steps stay as long, or nearly.
    ("a tenth of the size", &[("scale", "0.1"), ("slow", "0.316227766")]),
    ("ten times the size", &[("scale", "10"), ("slow", "3.16227766"), ("finer", "3")]),
];

/// Of a scene: what is promised of it, and how much at most.
type Promise = (&'static str, &'static [(&'static str, f64)]);

/// What hangs and spans. The greatest errors over all of [`AT`] are a half to a tenth of these bounds, and those of gaps less.
const JOINTS: &[Promise] = &[
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
const CONTACTS: &[Promise] = &[
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

fn keep(promises: &[Promise]) {
    let mut broken = Vec::new();
    for &(name, bounds) in promises {
        let has_rate = scene(name, &[]).params.iter().any(|(key, _)| *key == "rate");
        for (at, keys) in AT.into_iter().filter(|(_, keys)| has_rate || keys.iter().all(|(key, _)| *key != "rate")) {
            let run = Run::of(name, keys);
            for &(metric, most) in bounds {
                let found = run.error(metric);
                if found.is_nan() || found > most {
                    broken.push(format!("{name} at {at}: {metric} is {found:.4e}, bound {most:e}"));
                }
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn what_hangs_and_spans_keeps_its_promise_at_other_rates_and_sizes() {
    keep(JOINTS);
}

#[test]
fn what_stands_slides_and_flies_keeps_its_promise_at_other_rates_and_sizes() {
    keep(CONTACTS);
}

//! Ten kilometres from the origin is like the origin.

use crate::common::Run;

/// Errors at 10 km may differ by 1 % of those at the origin, or by this where they are smaller (m).
const FLOOR: f64 = 1e-6;

/// Runs a scene at the origin and 10 km away and compares its errors; `metre` is how much of each is a metre.
fn compare(name: &str, keys: &[(&str, &str)], errors: &[(&str, f64)]) {
    let near = Run::of(name, keys);
    let far_keys: Vec<_> = [("of", name), ("offset_km", "10")].into_iter().chain(keys.iter().copied()).collect();
    let far = Run::of("far_origin", &far_keys);
    for &(error, metre) in errors {
        let (at_origin, far_away) = (near.error(error), far.error(error));
        let apart = (far_away - at_origin).abs();
        let bound = (0.01 * at_origin).max(FLOOR * metre);
        assert!(
            apart <= bound,
            "{name}: {error} is {at_origin:.4e} at the origin, {far_away:.4e} at 10 km: {apart:.2e} apart, bound {bound:.2e}"
        );
    }
}

#[test]
fn a_hanging_chain_is_as_accurate_ten_kilometres_away() {
    // 30 links of 0.2 m: a metre of stretch is 100/6 %.
    let sweeps_alone = [("ratio", "1"), ("solver", "gs"), ("long_range", "off")];
    compare("hanging_chain", &sweeps_alone, &[("stretch_pct", 100.0 / 6.0), ("joint_gap_m", 1.0)]);
}

#[test]
fn a_heavy_weight_hangs_as_high_ten_kilometres_away() {
    // What is left of the stretch is where bounds stop being taut, which the last bit decides: the bar is that at the origin.
    let run = Run::of("far_origin", &[("of", "hanging_chain"), ("offset_km", "10"), ("solver", "gs")]);
    run.keeps("stretch_pct", 0.01, "%");
    run.keeps("joint_gap_m", 1e-4, "m");
}

#[test]
fn a_tower_stands_as_well_ten_kilometres_away() {
    compare("tower", &[("seconds", "3"), ("ball", "off")], &[("drift_m", 1.0), ("sink_m", 1.0)]);
}

#[test]
fn a_thrown_ball_flies_its_parabola_ten_kilometres_away() {
    compare("projectile", &[], &[("pos_err_max_m", 1.0)]);
}

//! Long-range constraints: chains keep their length at default effort, and the loads reported are true.

mod common;

use common::Run;

fn hanging(keys: &[(&str, &str)]) -> Run {
    Run::of("hanging_chain", &[&[("solver", "gs")], keys].concat())
}

#[test]
fn a_chain_under_ten_tonnes_keeps_its_length() {
    for n in ["10", "30", "100"] {
        let run = hanging(&[("n", n)]);
        run.keeps("stretch_pct", 0.01, "%");
        run.keeps("joint_gap_m", 1e-4, "m");
    }
}

#[test]
fn a_chain_keeps_its_length_at_any_ratio() {
    for ratio in ["10", "100", "1000000"] {
        hanging(&[("ratio", ratio)]).keeps("stretch_pct", 0.01, "%");
    }
    // A chain without a weight swings bent, so no line through it is taut.
    hanging(&[("ratio", "1")]).keeps("stretch_pct", 0.02, "%");
}

#[test]
fn the_top_joint_reads_the_weight_at_any_effort() {
    for substeps in ["1", "4", "16"] {
        hanging(&[("substeps", substeps)]).keeps("load_err_pct", 2.0, "%");
    }
}

#[test]
fn a_thrown_chain_gains_no_energy() {
    for ratio in ["100", "10000", "1000000"] {
        for seed in ["1", "2", "3", "4"] {
            let run = Run::of("violent", &[("solver", "gs"), ("ratio", ratio), ("seed", seed)]);
            run.is("non_finite", 0.0);
            run.keeps("energy_growth_pct", 1.0, "%");
        }
    }
}

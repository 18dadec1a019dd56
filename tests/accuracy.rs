//! What has a formula agrees with it.

use crate::common::{Run, scene};
use longspan_scenes::DT;

#[test]
fn a_thrown_ball_flies_its_parabola() {
    // In 2 s and 30 m of flight; rounding of f32 velocities alone leaves some 1e-5 m.
    Run::of("projectile", &[]).keeps("pos_err_max_m", 1e-3, "m");
}

#[test]
fn a_pendulum_keeps_its_period() {
    for angle in ["10", "60", "120"] {
        Run::of("pendulum", &[("angle_deg", angle)]).keeps("period_err_pct", 1.0, "%");
    }
}

/// tan θ = μ.
fn threshold_angle(friction: f64) -> f64 {
    friction.atan().to_degrees()
}

#[test]
fn a_box_stands_one_degree_below_the_friction_angle() {
    for friction in [0.2, 0.5, 0.9] {
        let angle = (threshold_angle(friction) - 1.0).to_string();
        let run = Run::of("slope", &[("angle_deg", &angle), ("friction", &friction.to_string())]);
        // Far below the 0.3 m that the box slides one degree above.
        run.keeps("way_err_m", 1e-3, "m");
    }
}

#[test]
fn a_box_slides_one_degree_above_the_friction_angle_as_far_as_it_should() {
    for friction in [0.2, 0.5, 0.9] {
        let angle = (threshold_angle(friction) + 1.0).to_string();
        let run = Run::of("slope", &[("angle_deg", &angle), ("friction", &friction.to_string())]);
        // First order in the substep: h/t = 0.2 % after 2 s, and the friction of the moment before it slides.
        run.keeps("way_err_pct", 1.0, "%");
    }
}

#[test]
fn a_ball_rebounds_to_the_height_of_its_restitution_squared() {
    for restitution in ["0.3", "0.5", "0.8", "1.0"] {
        Run::of("bounce", &[("restitution", restitution)]).keeps("height_err_pct", 2.0, "%");
    }
}

#[test]
fn a_resting_box_presses_with_its_weight_within_a_second() {
    for mass in ["0.001", "1", "100", "100000"] {
        Run::of("box_on_plane", &[("mass", mass)]).keeps("force_err_pct", 1.0, "%");
    }
}

#[test]
fn a_hinge_motor_of_bounded_torque_speeds_up_as_newton_says() {
    // The moment at which the target is reached falls inside a step: up to τ h/I of a target of 10 rad/s.
    Run::of("hinge_motor", &[]).keeps("spin_err_pct", 1.0, "%");
}

#[test]
fn hinges_that_rub_stop_a_flywheel_and_a_pendulum_as_coulomb_says() {
    for solver in ["auto", "gs"] {
        let run = Run::of("stiff_hinge", &[("solver", solver)]);
        run.keeps("spin_err_pct", 0.1, "%");
        run.keeps("swing_err_pct", 3.0, "%");
    }
}

#[test]
fn a_position_motor_holds_its_angle_against_gravity() {
    for angle in ["-60", "0", "30"] {
        Run::of("hinge_servo", &[("angle_deg", angle)]).keeps("angle_err_deg", 0.5, "°");
    }
}

#[test]
fn a_soft_position_motor_gives_way_as_its_spring_says() {
    for stiffness in ["200", "1000", "10000"] {
        Run::of("hinge_servo", &[("stiffness", stiffness)]).keeps("angle_err_deg", 0.5, "°");
    }
}

#[test]
fn a_bar_on_its_stop_rests_at_the_angle_of_the_stop() {
    for stop in ["-80", "-45", "-10"] {
        Run::of("hinge_limit", &[("stop_deg", stop)]).keeps("limit_err_deg", 0.5, "°");
    }
}

#[test]
fn a_spring_swings_at_its_frequency_at_any_compliance_and_step() {
    for stiffness in ["10", "100", "1000"] {
        for halving in [1, 2] {
            let mut scene = scene("spring", &[("stiffness", stiffness), ("damping", "0")]);
            scene.dt = DT / halving as f32;
            scene.steps *= halving;
            Run::on_threads(scene, 1).keeps("period_err_pct", 1.0, "%");
        }
    }
}

#[test]
fn a_spring_swings_at_its_frequency_at_any_effort() {
    for (substeps, iterations) in [("1", "10"), ("2", "2"), ("4", "1"), ("4", "8"), ("16", "2")] {
        let keys = [("damping", "0"), ("substeps", substeps), ("iterations", iterations)];
        Run::of("spring", &keys).keeps("period_err_pct", 1.0, "%");
    }
}

#[test]
fn a_joint_reports_the_weight_that_hangs_from_it() {
    for ratio in ["0.1", "1", "10"] {
        Run::of("hanging_chain", &[("n", "1"), ("ratio", ratio)]).keeps("load_err_pct", 2.0, "%");
    }
}

#[test]
fn a_free_gyro_keeps_its_angular_momentum() {
    Run::of("free_gyro", &[]).keeps("ang_momentum_err_pct", 1e-3, "%");
}

#[test]
fn a_free_gyro_keeps_its_energy() {
    Run::of("free_gyro", &[]).keeps("energy_err_pct", 1e-3, "%");
}

#[test]
fn a_free_jointed_cluster_keeps_its_linear_momentum() {
    for seed in ["1", "2", "3"] {
        Run::of("free_cluster", &[("seed", seed)]).keeps("lin_momentum_err_pct", 1e-3, "%");
    }
}

#[test]
fn a_free_jointed_cluster_keeps_its_angular_momentum() {
    for joints in ["spherical", "hinge", "fixed"] {
        Run::of("free_cluster", &[("joints", joints), ("spin", "1")]).keeps("ang_momentum_err_pct", 1e-3, "%");
    }
}

#[test]
fn a_free_cluster_whose_joints_hit_their_stops_keeps_its_angular_momentum() {
    for seed in ["1", "2", "3"] {
        Run::of("free_cluster", &[("seed", seed)]).keeps("ang_momentum_err_pct", 1e-3, "%");
    }
}

#[test]
fn a_free_jointed_cluster_stays_together() {
    for joints in ["spherical", "hinge", "fixed"] {
        Run::of("free_cluster", &[("joints", joints), ("spin", "1")]).keeps("joint_gap_m", 5e-4, "m");
    }
}

#[test]
fn a_platform_carries_a_box_as_friction_lets_it() {
    // One substep at the platform's speed of 1 m/s: 1 s/240.
    Run::of("platform", &[]).keeps("pos_err_max_m", 4.2e-3, "m");
}

#[test]
fn rolling_friction_stops_a_ball_where_it_should() {
    // First order in the substep, as sliding.
    Run::of("rolling", &[]).keeps("way_err_pct", 1.0, "%");
}

#[test]
fn a_ball_stopped_by_rolling_friction_stays_where_it_is() {
    // The least speed that a viewer sees within a second.
    Run::of("rolling", &[]).keeps("pose_speed_max", 1e-4, "m/s");
}

#[test]
fn spinning_friction_stops_a_spinning_ball_when_it_should() {
    // One substep of the loss of 3.9 rad/s², of 10 rad/s: 0.16 %.
    Run::of("spinning", &[]).keeps("spin_err_pct", 0.2, "%");
}

#[test]
fn locked_translations_and_rotations_stay_locked() {
    let run = Run::of("locked_axes", &[]);
    // Friction along what is free brakes it: 6 cm.
    assert!(
        run.error("free_shift_m") > 0.03,
        "the blow moved the box by only {} m: nothing is tested",
        run.error("free_shift_m")
    );
    run.keeps("locked_shift_m", 1e-6, "m");
    // Rounding of a unit quaternion in f32: 1e-7 of a radian a substep.
    run.keeps("locked_turn_deg", 1e-3, "°");
}

#[test]
fn damped_speeds_follow_the_implicit_formula() {
    // Rounding of 960 substeps in f32.
    let run = Run::of("damping", &[]);
    run.keeps("speed_err_pct", 0.01, "%");
    run.keeps("spin_err_pct", 0.01, "%");
}

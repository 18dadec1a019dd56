//! Every row of the stress table holds what it promises, over several seeds.

use longspan_scenes::stress::{Judged, ROWS, judge};

/// Seeds of each row: `LONGSPAN_SEEDS`, or ten.
fn seeds() -> u64 {
    std::env::var("LONGSPAN_SEEDS").ok().and_then(|text| text.parse().ok()).unwrap_or(10)
}

fn holds(name: &str) {
    let row = ROWS.iter().find(|row| row.name == name).expect("the row is in the table");
    let Judged { held, seeds, failed, worst, .. } = judge(row, seeds()).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(
        failed.is_empty(),
        "{name}, {}: held for {held} of {seeds} seeds, not for {failed:?}; worst values {worst:?}",
        row.promise
    );
}

macro_rules! rows {
    ($($test:ident: $row:literal),* $(,)?) => {
        $(#[test]
        fn $test() {
            holds($row);
        })*

        #[test]
        fn every_row_of_the_table_is_tested() {
            let tested = [$($row),*];
            let untested: Vec<_> = ROWS.iter().map(|row| row.name).filter(|name| !tested.contains(name)).collect();
            assert!(untested.is_empty(), "rows without a test: {untested:?}");
        }
    };
}

rows! {
    any_mass_ratio_stays_bounded: "mass_ratio",
    any_inertia_ratio_stays_bounded: "inertia_ratio",
    any_size_stands: "size",
    any_speed_stays_before_the_wall: "speed",
    any_step_length_stays_bounded: "step_size",
    turning_gravity_stays_bounded: "gravity",
    needles_stay_bounded: "needles",
    sheets_stay_bounded: "sheets",
    deep_overlap_stays_bounded: "deep_overlap",
    contradictory_joints_stay_bounded: "contradictory_joints",
    violated_limits_are_restored: "limits_violated",
    a_motor_against_a_stop_stays_bounded: "motor_against_stop",
    ten_thousand_contacts_on_a_body_hold: "many_contacts",
    a_complete_graph_of_joints_stays_bounded: "complete_graph",
    a_bad_mass_is_refused: "bad_mass",
    a_bad_position_is_refused: "bad_position",
    a_bad_velocity_is_refused: "bad_velocity",
    a_bad_joint_is_refused: "bad_joint",
    a_bad_step_is_refused: "bad_step",
}

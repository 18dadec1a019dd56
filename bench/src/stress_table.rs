//! What is promised under abuse and what held, as a table for the guide.

use longspan_scenes::stress::{Judged, ROWS, Row, judge};

use crate::line::short;

/// Prints one line a row as soon as it has run.
pub fn print(seeds: u64) -> Result<(), Box<dyn std::error::Error>> {
    println!("| row | what is done | promise | held | worst, of its bound | worst values |");
    println!("|---|---|---|---|---|---|");
    for row in ROWS {
        println!("{}", to_line(row, &judge(row, seeds)?));
    }
    Ok(())
}

fn to_line(row: &Row, judged: &Judged) -> String {
    let worst: Vec<String> = judged.worst.iter().map(|(name, value)| format!("{name} {}", short(*value))).collect();
    let share = if judged.worst.is_empty() { String::new() } else { short(judged.of_bound) };
    let (held, seeds) = (judged.held, judged.seeds);
    format!("| `{}` | {} | {} | {held}/{seeds} | {share} | {} |", row.name, row.abuse, row.promise, worst.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_what_was_promised_and_what_held() {
        let judged = Judged { held: 9, seeds: 10, failed: vec![3], of_bound: 1.5, worst: vec![("speed_peak", 15.0)] };
        let line = to_line(&ROWS[0], &judged);
        assert!(
            line.starts_with("| `mass_ratio` | ") && line.ends_with(" | bounded | 9/10 | 1.5000 | speed_peak 15.0000 |"),
            "{line}"
        );
    }
}

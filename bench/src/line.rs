//! One run as one line: JSON for files, text for people.

use std::time::Duration;

use longspan_scenes::{Effort, Measurement, Spread, Timing};
use serde_json::{Map, Number, Value, json};

/// What a run is judged to be, and how long the steps of another one like it take.
pub struct Outcome {
    pub run: Measurement,
    pub timing: Timing,
}

/// One JSON object, errors in the scene's own order. `cold` is the length of other work before each step.
pub fn to_json(Outcome { run, timing }: &Outcome, cold: Option<Duration>) -> Value {
    let params: Map<String, Value> = run.params.iter().map(|(key, value)| (key.clone(), plain(value))).collect();
    let errors: Map<String, Value> = run.errors.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
    let effort = match run.effort {
        Effort::Default => json!("default"),
        Effort::N(count) => json!(count),
    };
    json!({
        "scene": run.scene,
        "params": params,
        "engine": run.engine,
        "effort": effort,
        "threads": run.threads,
        "cold_ms": cold.map(|length| length.as_secs_f64() * 1e3),
        "ms": times(timing),
        "steps": run.steps,
        "errors": errors,
    })
}

fn times(timing: &Timing) -> Value {
    let spread = |spread: &Spread| json!({ "median": spread.median, "p99": spread.p99 });
    let mut all = Map::new();
    all.insert("whole".into(), spread(&timing.whole));
    all.insert("busiest".into(), spread(&timing.busiest));
    all.insert("busiest_from_s".into(), json!(timing.busiest_from));
    all.insert("last".into(), spread(&timing.last));
    all.insert("first".into(), json!(timing.first));
    all.insert("worst".into(), json!(timing.worst));
    all.insert("worst_step".into(), json!(timing.worst_step));
    if let Some((name, median)) = timing.second_window {
        all.insert(name.into(), json!(median));
    }
    Value::Object(all)
}

/// A number where the text is one.
fn plain(text: &str) -> Value {
    let whole = text.parse::<u64>().ok().map(Number::from);
    let number = whole.or_else(|| text.parse::<f64>().ok().and_then(Number::from_f64));
    number.map_or_else(|| json!(text), Value::Number)
}

/// The same for people.
pub fn to_text(Outcome { run, timing }: &Outcome) -> String {
    let effort = match run.effort {
        Effort::Default => "default".to_owned(),
        Effort::N(count) => count.to_string(),
    };
    let params: Vec<String> = run.params.iter().map(|(key, value)| format!("{key}={value}")).collect();
    let errors: Vec<String> = run.errors.iter().map(|(name, value)| format!("{name} {}", short(*value))).collect();
    let spread = |spread: &Spread| format!("{:.4} (p99 {:.4})", spread.median, spread.p99);
    let second = timing.second_window.map(|(name, median)| format!(", {name} {median:.4}")).unwrap_or_default();
    format!(
        "{} {}: {} at effort {effort}, {} thread{}; ms a step: whole run {}, busiest second {} from {:.1} s, own window {}, \
         first {:.4}, worst {:.4} (step {}){second}; {}",
        run.scene,
        params.join(" "),
        run.engine,
        run.threads,
        if run.threads == 1 { "" } else { "s" },
        spread(&timing.whole),
        spread(&timing.busiest),
        timing.busiest_from,
        spread(&timing.last),
        timing.first,
        timing.worst,
        timing.worst_step,
        errors.join(", ")
    )
}

/// Four digits.
pub fn short(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) { format!("{:.4}", value) } else { format!("{value:.3e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_every_field_and_keeps_the_order_of_errors() {
        let run = Measurement {
            scene: "hanging_chain",
            params: vec![("n".into(), "30".into()), ("of".into(), "pile".into())],
            engine: "longspan",
            effort: Effort::N(16),
            threads: 1,
            steps: 600,
            errors: vec![("stretch_pct", 0.01), ("joint_gap_m", 1e30)],
        };
        let spread = Spread { median: 0.25, p99: 0.5 };
        let timing = Timing {
            whole: spread,
            busiest: spread,
            busiest_from: 2.5,
            last: spread,
            first: 0.125,
            worst: 0.75,
            worst_step: 7,
            second_window: Some(("collapse", 0.5)),
        };
        let expected = r#"{"scene":"hanging_chain","params":{"n":30,"of":"pile"},"engine":"longspan","effort":16,"threads":1,"cold_ms":10.0,"ms":{"whole":{"median":0.25,"p99":0.5},"busiest":{"median":0.25,"p99":0.5},"busiest_from_s":2.5,"last":{"median":0.25,"p99":0.5},"first":0.125,"worst":0.75,"worst_step":7,"collapse":0.5},"steps":600,"errors":{"stretch_pct":0.01,"joint_gap_m":1e+30}}"#;
        let line = to_json(&Outcome { run, timing }, Some(Duration::from_millis(10))).to_string();
        assert_eq!(line.replace("1e30", "1e+30"), expected);
    }
}

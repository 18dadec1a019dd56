//! One run as one line: JSON for files, text for people.

use longspan_scenes::{Effort, Measurement};
use serde_json::{Map, Number, Value, json};

/// One JSON object, errors in the scene's own order.
pub fn to_json(run: &Measurement) -> Value {
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
        "ms_median": run.ms_median,
        "ms_p99": run.ms_p99,
        "steps": run.steps,
        "errors": errors,
    })
}

/// A number where the text is one.
fn plain(text: &str) -> Value {
    let whole = text.parse::<u64>().ok().map(Number::from);
    let number = whole.or_else(|| text.parse::<f64>().ok().and_then(Number::from_f64));
    number.map_or_else(|| json!(text), Value::Number)
}

/// The same for people.
pub fn to_text(run: &Measurement) -> String {
    let effort = match run.effort {
        Effort::Default => "default".to_owned(),
        Effort::N(count) => count.to_string(),
    };
    let params: Vec<String> = run.params.iter().map(|(key, value)| format!("{key}={value}")).collect();
    let errors: Vec<String> = run.errors.iter().map(|(name, value)| format!("{name} {}", short(*value))).collect();
    format!(
        "{} {}: {} at effort {effort}, {} thread{}: {:.4} ms (p99 {:.4}); {}",
        run.scene,
        params.join(" "),
        run.engine,
        run.threads,
        if run.threads == 1 { "" } else { "s" },
        run.ms_median,
        run.ms_p99,
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
            ms_median: 0.25,
            ms_p99: 0.5,
            steps: 600,
            errors: vec![("stretch_pct", 0.01), ("joint_gap_m", 1e30)],
        };
        let expected = r#"{"scene":"hanging_chain","params":{"n":30,"of":"pile"},"engine":"longspan","effort":16,"threads":1,"ms_median":0.25,"ms_p99":0.5,"steps":600,"errors":{"stretch_pct":0.01,"joint_gap_m":1e+30}}"#;
        let line = to_json(&run).to_string();
        assert_eq!(line.replace("1e30", "1e+30"), expected);
    }
}

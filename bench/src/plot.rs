//! Run time against error: one picture for each scene and its keys, one line for each engine and each of our modes, one point for
//! each effort.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use longspan_scenes::LONG_RANGE_KINDS;
use plotters::prelude::*;
use serde_json::Value;

use crate::args::{OURS, Stretch};

type Problem = Box<dyn std::error::Error>;

/// Errors are shown within these bounds, so that a zero and an explosion have a place too.
const SHOWN: (f64, f64) = (1.0e-9, 1.0e6);
const SIZE: (u32, u32) = (900, 600);
const COLORS: [RGBColor; 6] =
    [RGBColor(200, 30, 40), RGBColor(30, 90, 190), RGBColor(30, 140, 60), RGBColor(210, 130, 0), RGBColor(120, 50, 160), BLACK];

/// Points of one scene: by engine, each with its time (ms), its error and its effort.
#[derive(Default)]
struct Chart {
    error: String,
    engines: BTreeMap<String, Vec<Point>>,
}

struct Point {
    ms: f64,
    error: f64,
    effort: String,
}

/// Reads JSON lines and writes a picture of the error of this name, or of the first, for each scene.
pub fn plot(file: &Path, out_dir: &Path, error: Option<&str>, time: Stretch) -> Result<(), Problem> {
    let charts = read(&fs::read_to_string(file)?, error, time)?;
    fs::create_dir_all(out_dir)?;
    for (title, chart) in &charts {
        let name: String = title.chars().map(|c| if c.is_alphanumeric() || "_=.-".contains(c) { c } else { '_' }).collect();
        let path = out_dir.join(format!("{name}.svg"));
        draw(title, chart, time, &path)?;
        println!("{}", path.display());
    }
    Ok(())
}

fn read(text: &str, wanted: Option<&str>, time: Stretch) -> Result<BTreeMap<String, Chart>, Problem> {
    let mut charts: BTreeMap<String, Chart> = BTreeMap::new();
    for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let refuse = |what: &str| format!("line {}: {what}", number + 1);
        let run: Value = serde_json::from_str(line).map_err(|error| refuse(&error.to_string()))?;
        let field = |name: &str| run.get(name).ok_or_else(|| refuse(&format!("has no {name}")));
        let object = |name: &str| field(name)?.as_object().ok_or_else(|| refuse(&format!("{name} is not an object")));
        let word = |name: &str| field(name).map(text_of);
        let median = field("ms")?.get(time.name()).and_then(|spread| spread.get("median")).and_then(Value::as_f64);
        let ms = median.ok_or_else(|| refuse(&format!("ms has no {}.median", time.name())))?;
        // A scene without that error has only its time to show.
        let is_wanted = |name: &str| wanted.is_none_or(|wanted| name == wanted);
        let Some((error_name, error)) = object("errors")?.iter().find(|(name, _)| is_wanted(name)) else { continue };
        let error = error.as_f64().ok_or_else(|| refuse("an error is not a number"))?;

        let (mode, keys): (Vec<_>, Vec<_>) = object("params")?.iter().partition(|(key, _)| is_mode(key));
        let chart = charts.entry(title(&word("scene")?, &keys)).or_default();
        chart.error.clone_from(error_name);
        let mut engine = word("engine")?;
        if engine == OURS {
            engine = title(&engine, &mode);
        }
        if let Some(threads) = field("threads")?.as_u64().filter(|threads| *threads > 1) {
            engine = format!("{engine} ({threads} threads)");
        }
        chart.engines.entry(engine).or_default().push(Point { ms, error, effort: word("effort")? });
    }
    for points in charts.values_mut().flat_map(|chart| chart.engines.values_mut()) {
        points.sort_by(|a, b| a.ms.total_cmp(&b.ms));
    }
    Ok(charts)
}

/// Whether a key changes how our engine works and not what the scene is.
fn is_mode(key: &str) -> bool {
    ["solver", "substeps", "iterations"].contains(&key) || LONG_RANGE_KINDS.contains(&key)
}

fn title(name: &str, params: &[(&String, &Value)]) -> String {
    let keys = params.iter().map(|(key, value)| format!("{key}={}", text_of(value)));
    [name.to_owned()].into_iter().chain(keys).collect::<Vec<_>>().join(" ")
}

fn text_of(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

fn draw(title: &str, chart: &Chart, time: Stretch, path: &Path) -> Result<(), Problem> {
    let points = || chart.engines.values().flatten();
    let shown = |point: &Point| (point.ms.max(1e-6), point.error.clamp(SHOWN.0, SHOWN.1));
    let range = |of: fn((f64, f64)) -> f64| {
        let (min, max) = points().map(|p| of(shown(p))).fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
        min / 2.0..max * 2.0
    };

    let canvas = SVGBackend::new(path, SIZE).into_drawing_area();
    canvas.fill(&WHITE)?;
    let mut axes = ChartBuilder::on(&canvas)
        .caption(title, ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(72)
        .build_cartesian_2d(range(|p| p.0).log_scale(), range(|p| p.1).log_scale())?;
    let number =
        |value: &f64| if (1e-2..1e4).contains(value) { three_digits(*value).to_string() } else { format!("{value:.0e}") };
    axes.configure_mesh()
        .light_line_style(BLACK.mix(0.05))
        .x_desc(match time {
            Stretch::Whole => "time a step, median of the whole run (ms)",
            Stretch::Busiest => "time a step, median of the busiest second (ms)",
            Stretch::Last => "time a step, median of the scene's own window (ms)",
        })
        .y_desc(chart.error.as_str())
        .x_label_formatter(&number)
        .y_label_formatter(&number)
        .draw()?;
    for (index, (engine, points)) in chart.engines.iter().enumerate() {
        let color = COLORS[index % COLORS.len()];
        axes.draw_series(LineSeries::new(points.iter().map(shown), color.stroke_width(2)))?
            .label(engine.as_str())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
        axes.draw_series(points.iter().map(|point| {
            EmptyElement::at(shown(point))
                + Circle::new((0, 0), 4, color.filled())
                + Text::new(point.effort.clone(), (6, -14), ("sans-serif", 12))
        }))?;
    }
    axes.configure_series_labels().background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.3)).draw()?;
    canvas.present()?;
    Ok(())
}

/// Takes the noise off a number that was multiplied up.
fn three_digits(value: f64) -> f64 {
    let unit = 10.0_f64.powf(value.log10().floor() - 2.0);
    if unit < 1.0 { (value / unit).round() / (1.0 / unit).round() } else { (value / unit).round() * unit }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(engine: &str, effort: &str, ms: f64, stretch: f64) -> String {
        format!(
            r#"{{"scene":"hanging_chain","params":{{"n":30}},"engine":"{engine}","effort":{effort},"threads":1,"ms":{{"whole":{{"median":{ms},"p99":1}},"busiest":{{"median":7,"p99":8}}}},"steps":600,"errors":{{"stretch_pct":{stretch},"joint_gap_m":5}}}}"#
        )
    }

    #[test]
    fn lines_become_one_picture_a_scene_with_all_engines_and_efforts() {
        let text = [line("a", "\"default\"", 0.5, 0.0), line("a", "16", 0.1, 1e30), line("b", "4", 2.0, 3.0)].join("\n");
        let charts = read(&text, None, Stretch::Whole).unwrap();
        let (title, chart) = charts.first_key_value().unwrap();
        assert_eq!((charts.len(), title.as_str(), chart.error.as_str()), (1, "hanging_chain n=30", "stretch_pct"));
        assert_eq!(chart.engines["a"].iter().map(|point| point.effort.as_str()).collect::<Vec<_>>(), ["16", "default"]);

        let busiest = read(&text, None, Stretch::Busiest).unwrap();
        assert_eq!(busiest.values().flat_map(|chart| &chart.engines["a"]).map(|point| point.ms).fold(0.0, f64::max), 7.0);

        let path = std::env::temp_dir().join(format!("longspan-plot-{}.svg", std::process::id()));
        draw(title, chart, Stretch::Whole, &path).unwrap();
        let picture = fs::read_to_string(&path).unwrap();
        fs::remove_file(path).unwrap();
        for shown in ["hanging_chain n=30", "stretch_pct", "default", "<circle"] {
            assert!(picture.contains(shown), "the picture shows no {shown}");
        }
    }

    #[test]
    fn a_mode_is_a_line_of_its_own_in_the_picture_of_the_scene() {
        let swept = line(OURS, "4", 1.0, 2.0).replace(r#"{"n":30}"#, r#"{"n":30,"solver":"gs"}"#);
        let text = [line(OURS, "4", 1.0, 1.0), swept, line("a", "4", 1.0, 1.0)].join("\n");
        let charts = read(&text, Some("joint_gap_m"), Stretch::Whole).unwrap();
        let chart = &charts["hanging_chain n=30"];
        assert_eq!((charts.len(), chart.error.as_str()), (1, "joint_gap_m"));
        assert_eq!(chart.engines.keys().collect::<Vec<_>>(), ["a", "longspan", "longspan solver=gs"]);
        assert!(read(&text, Some("no_such_error"), Stretch::Whole).unwrap().is_empty());
    }

    #[test]
    fn labels_are_short() {
        assert_eq!(
            [0.1 + 0.2, 0.07, 1000.0, 1.1 * 1.1].map(|value| three_digits(value).to_string()),
            ["0.3", "0.07", "1000", "1.21"]
        );
    }

    #[test]
    fn a_line_that_is_no_run_is_refused_by_number() {
        let problem =
            read(&format!("{}\n{{}}", line("a", "1", 1.0, 1.0)), None, Stretch::Whole).err().map(|error| error.to_string());
        assert_eq!(problem.as_deref(), Some("line 2: has no ms"));
    }
}

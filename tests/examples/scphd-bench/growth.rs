//! The times of all cases as a table, and the curves as plots.

use scphd_benches::cases::{CURVES, NAMED};
use scphd_view::plot::{Chart, Colour, Figure, Interval, Mark};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Height of each chart, px.
const HEIGHT_PX: f64 = 240.0;

/// Writes times.csv, growth.svg and growth.png.
pub fn draw(criterion: &Path, out: &Path) -> Result<(), String> {
    let cannot = |error: std::io::Error| format!("{}: {error}", out.display());
    fs::create_dir_all(out).map_err(cannot)?;
    let mut table = String::from("group,id,scan_us\n");
    let mut time_us = |group: &str, id: &str| -> Result<f64, String> {
        let time_us = criterion_time_us(criterion, group, id)?;
        // Writing to a string cannot fail.
        let _ = writeln!(table, "{group},{id},{time_us:.3}");
        Ok(time_us)
    };
    for (name, _) in NAMED {
        time_us("scan", name)?;
    }
    let mut charts = Vec::new();
    for (index, curve) in CURVES.iter().enumerate() {
        let mut points = Vec::new();
        for &point in curve.points {
            points.push([point as f64, time_us(curve.name, &point.to_string())?]);
        }
        let highest = points.iter().map(|point| point[1]).fold(0.0, f64::max);
        let chart = Chart {
            x_label: curve.what.into(),
            y_label: "scan (µs)".into(),
            y: Interval::new(0.0, 1.1 * highest),
            marks: vec![
                Mark::line("", Colour::of_curve(index), points.clone()),
                Mark::rings("", Colour::of_curve(index), points),
            ],
            ..Chart::default()
        };
        charts.push((chart, HEIGHT_PX));
    }
    fs::write(out.join("times.csv"), table).map_err(cannot)?;
    let figure = Figure { title: "Time of a scan, f32, one thread of the host".into(), charts };
    figure.write(out, "growth").map(drop).map_err(|error| error.to_string())
}

/// The time that criterion has measured for a case, µs: the median of its samples, which is more robust against other load of the
/// machine than the mean.
fn criterion_time_us(criterion: &Path, group: &str, id: &str) -> Result<f64, String> {
    let path = criterion.join(group).join(id).join("new/estimates.json");
    let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let estimates: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    let time_ns = estimates["median"]["point_estimate"].as_f64();
    time_ns.map(|time_ns| time_ns / 1e3).ok_or_else(|| format!("{} has no median", path.display()))
}

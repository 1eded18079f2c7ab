//! The curves as a table and a picture.

use scphd_benches::cases::CURVES;
use scphd_benches::criterion_time_us;
use scphd_sim::plot::{Chart, Colour, Figure, Interval, Mark};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Height of each chart, px.
const HEIGHT_PX: f64 = 240.0;

/// Writes growth.csv, growth.svg and growth.png.
pub fn draw(criterion: &Path, out: &Path) -> Result<(), String> {
    let cannot = |error: std::io::Error| format!("{}: {error}", out.display());
    fs::create_dir_all(out).map_err(cannot)?;
    let mut table = String::from("curve,n,scan_us\n");
    let mut charts = Vec::new();
    for (index, curve) in CURVES.iter().enumerate() {
        let mut points = Vec::new();
        for &point in curve.points {
            let time_us = criterion_time_us(criterion, curve.name, &point.to_string())?;
            // Writing to memory cannot fail.
            let _ = writeln!(table, "{},{point},{time_us:.1}", curve.name);
            points.push([point as f64, time_us]);
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
    fs::write(out.join("growth.csv"), table).map_err(cannot)?;
    let figure = Figure { title: "Time of a scan, f32, one thread of the host".into(), charts };
    figure.write(out, "growth").map(drop).map_err(|error| error.to_string())
}

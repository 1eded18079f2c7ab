//! Errors over time with the filter's expected errors, the size of the map and the effective number of particles.

use super::axis::Interval;
use super::chart::{Chart, Colour, Mark};
use super::figure::Figure;
use super::trajectory::run_width;
use scphd_log::angle::wrap;
use scphd_log::dimensions::{Coordinates, Dimensions};
use scphd_score::record::{Record, ScanRecord};

/// Height of the frame of an error and of a count, px.
const HEIGHT_PX: [f64; 2] = [270.0, 170.0];
/// Multiples of the largest error of an estimate: at the first the filter's band is cut off, beyond the second dead reckoning
/// does not affect the limits.
const STRETCH: [f64; 2] = [2.5, 3.5];

/// The plot of errors, number of features and effective number of particles of `runs` over the log with this name.
///
/// Position error: distance of estimate and truth at the scans with truth, with the filter's 2σ, where σ² = `P_xx` + `P_yy`, in
/// space + `P_zz`, plus the noise of the truth, is the expected mean square distance. Heading error: signed, with ±2σ; only if
/// the truth has a heading. Dead reckoning may leave the frame; its label then has its greatest error.
pub fn figure<D: Dimensions>(name: &str, runs: &[(&str, &Record<D>)]) -> Figure {
    let start_s =
        runs.iter().filter_map(|(_, record)| record.scans.first().map(|scan| scan.t_s)).fold(f64::INFINITY, f64::min);
    let mut charts = vec![(position_chart(runs, start_s), HEIGHT_PX[0])];
    let mut scans = runs.iter().flat_map(|(_, record)| &record.scans);
    if scans.any(|scan| scan.true_heading_rad.is_some()) {
        charts.push((heading_chart(runs, start_s), HEIGHT_PX[0]));
    }
    charts.push((features_chart(runs, start_s), HEIGHT_PX[1]));
    charts.push((particles_chart(runs, start_s), HEIGHT_PX[1]));

    // A common time axis for all charts.
    let times = runs.iter().flat_map(|(_, record)| &record.scans);
    let time = Interval::around(times.map(|scan| scan.t_s - start_s));
    for (chart, _) in &mut charts {
        chart.x = time;
    }
    if let Some((last, _)) = charts.last_mut() {
        last.x_label = "time since the first scan (s)".into();
    }
    Figure { title: format!("{name}: errors over time"), charts }
}

/// A curve over time, with gaps where `value` is `None`.
fn curve<D: Dimensions>(
    record: &Record<D>,
    start_s: f64,
    value: impl Fn(&ScanRecord<D>) -> Option<f64>,
) -> Vec<[f64; 2]> {
    let points = record.scans.iter();
    points.map(|scan| [scan.t_s - start_s, value(scan).unwrap_or(f64::NAN)]).collect()
}

/// Position error of every run and of dead reckoning, m.
fn position_chart<D: Dimensions>(runs: &[(&str, &Record<D>)], start_s: f64) -> Chart {
    let band = |scan: &ScanRecord<D>| [0.0, 2.0 * scan.expected_error_m()];
    let (error, reckoned) = (ScanRecord::position_error_m, ScanRecord::dead_reckoning_error_m);
    let series = Series::new(runs, start_s, error, reckoned, band);
    let largest = series.largest();
    series.chart("position error (m)", "2σ", "m", Interval::new(0.0, largest))
}

/// Heading error of every run and of dead reckoning, degrees.
fn heading_chart<D: Dimensions>(runs: &[(&str, &Record<D>)], start_s: f64) -> Chart {
    let off = |scan: &ScanRecord<D>, heading: f64| Some(wrap(heading - scan.true_heading_rad?).to_degrees());
    let error = |scan: &ScanRecord<D>| off(scan, D::heading(&scan.pose));
    let reckoned = |scan: &ScanRecord<D>| off(scan, *scan.dead_reckoning.as_ref().get(D::Position::COUNT)?);
    let band = |scan: &ScanRecord<D>| {
        let variance = D::heading(&scan.pose_covariance.as_ref()[D::Position::COUNT]);
        let twice = 2.0 * variance.sqrt().to_degrees();
        [-twice, twice]
    };
    let series = Series::new(runs, start_s, error, reckoned, band);
    let largest = series.largest();
    series.chart("heading error (deg)", "±2σ", "deg", Interval::new(-largest, largest))
}

/// The curves of an error chart.
struct Series<'a> {
    labels: Vec<&'a str>,
    errors: Vec<Vec<[f64; 2]>>,
    bands: Vec<Vec<[f64; 3]>>,
    reckoned: Vec<[f64; 2]>,
}

impl<'a> Series<'a> {
    /// `error` is that of the estimate of a scan, `reckoned` that of dead reckoning, `band` the range that the filter expects.
    fn new<D: Dimensions>(
        runs: &[(&'a str, &Record<D>)],
        start_s: f64,
        error: impl Fn(&ScanRecord<D>) -> Option<f64>,
        reckoned: impl Fn(&ScanRecord<D>) -> Option<f64>,
        band: impl Fn(&ScanRecord<D>) -> [f64; 2],
    ) -> Self {
        let over_time = |record: &Record<D>| {
            let rows = record.scans.iter().map(|scan| {
                let [low, high] = band(scan);
                [scan.t_s - start_s, low, high]
            });
            rows.collect()
        };
        Self {
            labels: runs.iter().map(|(label, _)| *label).collect(),
            errors: runs.iter().map(|(_, record)| curve(record, start_s, &error)).collect(),
            bands: runs.iter().map(|(_, record)| over_time(record)).collect(),
            reckoned: runs.first().map_or_else(Vec::new, |(_, record)| curve(record, start_s, &reckoned)),
        }
    }

    /// Upper limit of the absolute errors: the largest of the estimates, and larger others within the multiples above.
    fn largest(&self) -> f64 {
        let errors = largest(self.errors.iter().flatten().map(|p| p[1]));
        let band = largest(self.bands.iter().flatten().map(|row| row[2]));
        let reckoned = largest(self.reckoned.iter().map(|p| p[1]));
        let size = match (errors, band) {
            (Some(errors), _) if errors > 0.0 => errors
                .max(band.unwrap_or(0.0).min(STRETCH[0] * errors))
                .max(reckoned.filter(|r| *r <= STRETCH[1] * errors).unwrap_or(0.0)),
            (_, Some(band)) if band > 0.0 => band.max(reckoned.unwrap_or(0.0)),
            _ => 1.0,
        };
        1.06 * size
    }

    /// The chart; with `y` `None` its limits are those of the data.
    fn chart(self, y_label: &str, band_name: &str, unit: &str, y: Option<Interval>) -> Chart {
        let count = self.labels.len();
        let mut marks = Vec::new();
        for (index, (label, band)) in self.labels.iter().zip(self.bands).enumerate() {
            if !band.is_empty() {
                let name = format!("{label}: {band_name}");
                marks.push(Mark::band(name, Colour::of_curve(index), band));
            }
        }
        if let Some(reach) = largest(self.reckoned.iter().map(|p| p[1])) {
            let label = if y.is_some_and(|y| reach > y.high()) {
                {
                    let digits = if reach < 10.0 { 1 } else { 0 };
                    format!("dead reckoning (up to {reach:.digits$} {unit})")
                }
            } else {
                "dead reckoning".into()
            };
            let colour = Colour::DEAD_RECKONING;
            marks.push(Mark::dashed(label, colour, self.reckoned));
        }
        for (index, (label, points)) in self.labels.iter().zip(self.errors).enumerate() {
            if points.iter().any(|p| p[1].is_finite()) {
                let mark = Mark::line(*label, Colour::of_curve(index), points);
                marks.push(mark.wide(run_width(index, count)));
            }
        }
        Chart { y_label: y_label.into(), y, marks, ..Chart::default() }
    }
}

/// Mass of the map over time, and the number of true landmarks that have been in view, if known.
fn features_chart<D: Dimensions>(runs: &[(&str, &Record<D>)], start_s: f64) -> Chart {
    let mut marks = Vec::new();
    // It is not drawn with gaps.
    let known = |scan: &ScanRecord<D>| scan.landmarks_seen.is_some();
    let knows = |record: &Record<D>| !record.scans.is_empty() && record.scans.iter().all(known);
    if let Some((_, record)) = runs.iter().find(|(_, record)| knows(record)) {
        let points = curve(record, start_s, |scan| Some(scan.landmarks_seen? as f64));
        marks.push(Mark::dashed("true landmarks in view so far", Colour::TRUTH, points));
    }
    marks.extend(counts(runs, start_s, |scan| scan.features_estimated));
    Chart { y_label: "features N̂".into(), marks, ..Chart::default() }
}

fn particles_chart<D: Dimensions>(runs: &[(&str, &Record<D>)], start_s: f64) -> Chart {
    Chart { y_label: "N_eff".into(), marks: counts(runs, start_s, |scan| scan.n_eff), ..Chart::default() }
}

/// A thin curve for every run.
fn counts<D: Dimensions>(runs: &[(&str, &Record<D>)], start_s: f64, value: fn(&ScanRecord<D>) -> f64) -> Vec<Mark> {
    let marks = runs.iter().enumerate().map(|(index, (label, record))| {
        let points = curve(record, start_s, |scan| Some(value(scan)));
        Mark::line(*label, Colour::of_curve(index), points).wide(0.8 * run_width(index, runs.len()))
    });
    marks.collect()
}

/// The largest absolute value of the finite ones.
fn largest(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.filter(|v| v.is_finite()).map(f64::abs).reduce(f64::max)
}

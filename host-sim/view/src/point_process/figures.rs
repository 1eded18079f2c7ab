//! Figures 3.1, 3.2 and 3.3 of the thesis, drawn from fresh realisations.
//!
//! The captions of figures 3.2 and 3.3 name no region; it is that of figure 3.1 here, and λ₁ is the mean number of
//! parents in it.

use super::cluster::{self, Border};
use super::{Matern, Normal, Point, Poisson, ProcessError, Rectangle, SegmentCox, poisson, spatial};
use crate::plot::{Chart, Colour, Figure, Interval, Mark, PlotError};
use scphd_log::noise::Noise;
use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};

/// The figures that [`draw`] knows.
pub const NUMBERS: [&str; 3] = ["3.1", "3.2", "3.3"];

/// Mean number of points of both processes of figure 3.1.
const FIGURE_3_1_POINTS: f64 = 100.0;
/// Sides of the polygon that stands for a circle.
const CIRCLE_SIDES: u32 = 72;
/// A point that breaks a curve.
const BREAK: Point = [f64::NAN, f64::NAN];

/// Why a figure could not be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// No such figure.
    #[error("there is no figure {0}: the figures are {known}", known = NUMBERS.join(", "))]
    Unknown(String),
    /// The process cannot be simulated.
    #[error(transparent)]
    Process(#[from] ProcessError),
    /// The picture cannot be rendered or written.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

/// Writes the figure `number` (one of [`NUMBERS`]) of the realisations that belong to `seed` as SVG and PNG into `dir`,
/// which is created where it is missing, and returns the paths.
///
/// The files are `figure-3.1a`, `figure-3.1b`, `figure-3.2` and `figure-3.3`, each written whole or not at all.
///
/// # Errors
///
/// [`FigureError::Unknown`] for another number, [`FigureError::Plot`] where a file cannot be written or rendered.
pub fn draw(number: &str, seed: u64, dir: &Path) -> Result<Vec<PathBuf>, FigureError> {
    let pictures = match number {
        "3.1" => {
            let [homogeneous, inhomogeneous] = figure_3_1(seed)?;
            vec![("figure-3.1a", homogeneous), ("figure-3.1b", inhomogeneous)]
        }
        "3.2" => vec![("figure-3.2", figure_3_2(seed)?)],
        "3.3" => vec![("figure-3.3", figure_3_3(seed)?)],
        _ => return Err(FigureError::Unknown(number.into())),
    };
    fs::create_dir_all(dir).map_err(|source| PlotError::Io { path: dir.into(), source })?;
    let mut paths = Vec::new();
    for (stem, picture) in pictures {
        paths.extend(picture.write(dir, stem)?);
    }
    Ok(paths)
}

/// Figure 3.1: (a) a homogeneous Poisson process with λ = 100 and (b) one whose points are normal with the mean (20, 20)
/// and variances of 160 and 360 and a covariance of 100.
///
/// # Errors
///
/// None: the parameters are sound.
pub fn figure_3_1(seed: u64) -> Result<[Figure; 2], ProcessError> {
    let mut noise = Noise::new(seed);
    let region = region()?;
    let homogeneous = poisson::homogeneous(region, FIGURE_3_1_POINTS)?.simulate(&mut noise);
    let normal = Normal::new([20.0, 20.0], [[160.0, 100.0], [100.0, 360.0]])?;
    let inhomogeneous = poisson::inhomogeneous(FIGURE_3_1_POINTS, normal)?.simulate(&mut noise);
    Ok([("Homogeneous", homogeneous), ("Inhomogeneous", inhomogeneous)].map(|(kind, points)| {
        let title = format!("{kind} Poisson process, λ = {FIGURE_3_1_POINTS}");
        picture(title, region, vec![observed(points)])
    }))
}

/// Figure 3.2: a segment Cox process with λ₁ = 5 segments of 40 m and λ₂ = 10 points on each.
///
/// # Errors
///
/// None: the parameters are sound.
pub fn figure_3_2(seed: u64) -> Result<Figure, ProcessError> {
    let (region, length) = (region()?, 40.0);
    let process = SegmentCox::new(region, Poisson::new(5.0)?, length, Poisson::new(10.0)?, Border::Kept)?;
    let clusters = process.simulate(&mut Noise::new(seed));
    let mut segments = Vec::new();
    for cluster in &clusters {
        segments.extend(cluster.parent.ends());
        segments.push(BREAK);
    }
    let parents = Mark::line(format!("segments ({})", clusters.len()), Colour::GREY, segments);
    let marks = vec![border(region), parents, observed(cluster::points(&clusters).collect())];
    let title = format!("Segment Cox process, λ₁ = 5, λ₂ = 10, L = {length} m");
    Ok(picture(title, region.grown(0.5 * length)?, marks))
}

/// Figure 3.3: a Matérn process with λ₁ = 5 clusters of a radius of 20 m and λ₂ = 20 points in each.
///
/// # Errors
///
/// None: the parameters are sound.
pub fn figure_3_3(seed: u64) -> Result<Figure, ProcessError> {
    let (region, radius) = (region()?, 20.0);
    let process = Matern::new(region, Poisson::new(5.0)?, radius, Poisson::new(20.0)?, Border::Kept)?;
    let clusters = process.simulate(&mut Noise::new(seed));
    let mut circles = Vec::new();
    for cluster in &clusters {
        let corner =
            |side| spatial::along(cluster.parent, radius, 2.0 * PI * f64::from(side) / f64::from(CIRCLE_SIDES));
        circles.extend((0..=CIRCLE_SIDES).map(corner));
        circles.push(BREAK);
    }
    let parents = Mark::line(format!("clusters ({})", clusters.len()), Colour::GREY, circles);
    let marks = vec![border(region), parents, observed(cluster::points(&clusters).collect())];
    let title = format!("Matérn process, λ₁ = 5, λ₂ = 20, R = {radius} m");
    Ok(picture(title, region.grown(radius)?, marks))
}

/// The region of figure 3.1.
fn region() -> Result<Rectangle, ProcessError> {
    Rectangle::new([-100.0, 100.0], [-100.0, 100.0])
}

/// The points a process shows.
fn observed(points: Vec<Point>) -> Mark {
    Mark::crosses(format!("points ({})", points.len()), Colour::of_curve(0), points)
}

/// The border of the region where parents lie.
fn border(region: Rectangle) -> Mark {
    let ([left, bottom], [right, top]) = (region.low(), region.high());
    let corners = [[left, bottom], [right, bottom], [right, top], [left, top], [left, bottom]];
    Mark::dashed("region of the parents", Colour::TRUTH, corners.to_vec())
}

/// A square picture of `view`.
fn picture(title: String, view: Rectangle, marks: Vec<Mark>) -> Figure {
    let axis = |axis: usize| Interval::new(view.low()[axis], view.high()[axis]);
    let chart =
        Chart { x_label: "x (m)".into(), y_label: "y (m)".into(), x: axis(0), y: axis(1), equal_scale: true, marks };
    Figure { title, charts: vec![(chart, Figure::usual_frame_width())] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Shape;
    use scphd_shared_data::Folder;

    /// The points shown in a picture.
    fn shown(figure: &Figure) -> &[Point] {
        match &figure.charts[0].0.marks.last().unwrap().shape {
            Shape::Crosses(points) => points,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn every_figure_is_written_as_svg_and_png() {
        let folder = Folder::new("point-figures");
        let dir = folder.0.join("new");
        let paths: Vec<PathBuf> = NUMBERS.iter().flat_map(|number| draw(number, 1, &dir).unwrap()).collect();
        let mut names: Vec<String> =
            paths.iter().map(|p| p.file_name().unwrap().to_string_lossy().into_owned()).collect();
        names.sort();
        let stems = ["figure-3.1a", "figure-3.1b", "figure-3.2", "figure-3.3"];
        let expected: Vec<String> =
            stems.iter().flat_map(|stem| [format!("{stem}.png"), format!("{stem}.svg")]).collect();
        assert_eq!(names, expected);
        assert!(paths.iter().all(|path| fs::metadata(path).unwrap().len() > 2_000));
    }

    #[test]
    fn an_unknown_figure_is_told() {
        let error = draw("3.4", 1, Path::new("never")).unwrap_err();
        assert_eq!(error.to_string(), "there is no figure 3.4: the figures are 3.1, 3.2, 3.3");
        assert!(!Path::new("never").exists());
    }

    #[test]
    fn a_seed_is_a_picture() {
        let svg = |seed| figure_3_3(seed).unwrap().svg();
        assert_eq!(svg(3), svg(3));
        assert_ne!(svg(3), svg(4));
    }

    #[test]
    fn the_points_are_those_of_the_captions() {
        let mut totals = [0.0; 4];
        let mut sums = [[0.0; 2]; 2];
        let seeds = 400;
        for seed in 0..seeds {
            let [a, b] = figure_3_1(seed).unwrap();
            for (panel, figure) in [&a, &b].into_iter().enumerate() {
                shown(figure).iter().for_each(|p| (0..2).for_each(|axis| sums[panel][axis] += p[axis]));
            }
            let figures = [a, b, figure_3_2(seed).unwrap(), figure_3_3(seed).unwrap()];
            figures.iter().zip(&mut totals).for_each(|(figure, total)| *total += shown(figure).len() as f64);
        }
        // Means 100, 100, 50 and 100; deviations of a mean of 400 are 0.5, 0.5, 1.2 and 2.3.
        for (total, (mean, deviation)) in totals.iter().zip([(100.0, 0.5), (100.0, 0.5), (50.0, 1.2), (100.0, 2.3)]) {
            assert!((total / seeds as f64 - mean).abs() < 4.0 * deviation, "{totals:?}");
        }
        // Deviations of a mean of 40 000 points: 0.29 where uniform, below 0.1 where normal.
        for (panel, (mean, deviation)) in [(0.0, 0.29), (20.0, 0.1)].into_iter().enumerate() {
            for sum in sums[panel] {
                assert!((sum / totals[panel] - mean).abs() < 4.0 * deviation, "{sums:?}");
            }
        }
    }

    #[test]
    fn the_realisations_are_fixed() {
        let [a, b] = figure_3_1(42).unwrap();
        let figures = [a, b, figure_3_2(42).unwrap(), figure_3_3(42).unwrap()];
        let fingerprint = figures.each_ref().map(|figure| {
            let bits = shown(figure).iter().flatten().map(|v| v.to_bits());
            bits.fold(shown(figure).len() as u64, |hash, bits| (hash ^ bits).wrapping_mul(0x100_0000_01b3))
        });
        assert_eq!(
            fingerprint,
            [10487293509202207726, 10828527896499742835, 2148149668244164380, 1168703101990566954],
            "the same on every machine"
        );
    }
}

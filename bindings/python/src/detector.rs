//! Sensors that detect features.

use crate::array::{line, rows};
use crate::error::{Refusal, of_model};
use crate::mounting::Mounting;
use nalgebra::{Vector1, Vector2};
use pyo3::prelude::*;
use scphd::models::{
    MeasurementModel, ModelError, PlanarPose, PolarBirths, PolarGrid, RangeBearingLimits, RangeBearingWindow, Sensing,
    UniformClutter,
};
use scphd::numerics::Vector;
use scphd::storage::ScanRoom;
use scphd::{Births, Detector, DetectorMemory};
use std::f32::consts::{PI, TAU};

/// The most measurements of a scan.
const MEASUREMENTS: usize = 1024;

/// Models of range and bearing.
pub type Polar = Sensing<scphd::models::RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>;
/// Models of bearings.
pub type Direction =
    Sensing<scphd::models::BearingOnly<f32, PolarBirths<f32>>, RangeBearingWindow<f32>, UniformClutter<f32>>;

/// What a detector is made of: it is put together for a scan, over its memory.
pub struct Parts<X, Z: Vector> {
    sensing: X,
    births: Births<f32>,
    mounting: Option<scphd::models::Mounting<f32>>,
    room: Box<DetectorMemory<Z, MEASUREMENTS>>,
}

impl<X, Z> Parts<X, Z>
where
    X: MeasurementModel<Pose = PlanarPose<f32>, Measurement = Z> + Copy,
    Z: Vector<Scalar = f32>,
{
    fn new(sensing: X, births: Births<f32>, mounting: Option<&Mounting>) -> PyResult<Self> {
        let mounting = mounting.and_then(Mounting::seat);
        let mut parts = Self { sensing, births, mounting, room: Box::new(DetectorMemory::new()) };
        parts.over()?;
        Ok(parts)
    }

    /// The detector without memory, which is enough for a joint map.
    pub fn detector(&self) -> PyResult<Detector<X>> {
        let names = [("births.of_static", "births_still"), ("births.of_moving", "births_moving")];
        let detector = Detector::new(self.sensing, self.births).map_err(|error| of_model(error, &names))?;
        match self.mounting {
            Some(seat) => detector.mounted(seat).map_err(Refusal::raised),
            None => Ok(detector),
        }
    }

    /// The detector over its memory, for a mixture.
    pub fn over(&mut self) -> PyResult<Detector<X, ScanRoom<'_, Z>>> {
        self.detector()?.over(&mut self.room).map_err(Refusal::raised)
    }
}

/// A detector that sees nothing, where there was no scan yet.
pub fn blind() -> Result<Detector<Polar>, ModelError> {
    let window = RangeBearingWindow::full_circle(1.0, 0.0)?;
    let clutter = UniformClutter::of_scan(0.0, 1.0)?;
    let sensing = Sensing { sensor: scphd::models::RangeBearing::new(1.0, 1.0)?, field_of_view: window, clutter };
    Detector::new(sensing, Births::NONE)
}

/// A sensor that measures range (m) and bearing (rad, 0 ahead, growing to the left) of features that it cannot tell apart.
///
/// The probability of detection falls linearly with range, and to zero over a ramp around every edge of the view. A scan has at most
/// 1024 measurements.
///
/// Parameters
/// ----------
/// range_sigma_m, bearing_sigma_rad : float
///     Standard deviations of the noise.
/// range_max_m, range_min_m : float
///     How far the sensor sees, and from where on, m.
/// range_edge_m, bearing_edge_rad : float
///     Half widths of the soft edges, m and rad.
/// bearing_center_rad, bearing_half_width_rad : float
///     Middle of the view and half its width, rad; pi: all around.
/// probability : float
///     Probability of detection, in [0, 1), at range zero.
/// probability_far : float, optional
///     At the greatest range; left out: the same.
/// clutter_per_scan : float
///     False measurements to expect of a scan.
/// births_still, births_moving : float
///     Intensity of births, 1/(m rad), of features that stand still and of those that move. Left out: one still feature in ten
///     scans of a full circle, none that moves.
/// mounting : Mounting, optional
///     Where it sits; left out: where the pose is.
#[pyclass(module = "scphd")]
pub struct RangeBearing(pub Parts<Polar, Vector2<f32>>);

#[pymethods]
impl RangeBearing {
    #[new]
    #[pyo3(signature = (*, range_sigma_m, bearing_sigma_rad, range_max_m, range_min_m=0.0, range_edge_m=0.0,
                        bearing_center_rad=0.0, bearing_half_width_rad=PI, bearing_edge_rad=0.0, probability=0.9,
                        probability_far=None, clutter_per_scan=1.0, births_still=None, births_moving=0.0, mounting=None))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        range_sigma_m: f32,
        bearing_sigma_rad: f32,
        range_max_m: f32,
        range_min_m: f32,
        range_edge_m: f32,
        bearing_center_rad: f32,
        bearing_half_width_rad: f32,
        bearing_edge_rad: f32,
        probability: f32,
        probability_far: Option<f32>,
        clutter_per_scan: f32,
        births_still: Option<f32>,
        births_moving: f32,
        mounting: Option<&Bound<'_, Mounting>>,
    ) -> PyResult<Self> {
        let limits = RangeBearingLimits {
            range_min_m,
            range_max_m,
            range_edge_m,
            bearing_center_rad,
            bearing_half_width_rad,
            bearing_edge_rad,
            probability_near: probability,
            probability_far: probability_far.unwrap_or(probability),
        };
        let sensing = || {
            let field_of_view = RangeBearingWindow::new(limits)?;
            let clutter = UniformClutter::of_scan(clutter_per_scan, field_of_view.measure())?;
            Ok(Sensing {
                sensor: scphd::models::RangeBearing::new(range_sigma_m, bearing_sigma_rad)?,
                field_of_view,
                clutter,
            })
        };
        let sensing = sensing().map_err(|error| of_model(error, &[("probability_near", "probability")]))?;
        let births = Births { of_static: births_still.unwrap_or(0.1 / (range_max_m * TAU)), of_moving: births_moving };
        Parts::new(sensing, births, mounting.map(Bound::get)).map(Self)
    }
}

/// A sensor that measures bearings alone (rad, 0 ahead, growing to the left), such as a camera. For a `Filter`.
///
/// New features are looked for at points of a polar grid around the sensor, for a bearing does not say how far away its feature is.
///
/// Parameters
/// ----------
/// bearing_sigma_rad : float
///     Standard deviation of the noise, rad.
/// range_max_m, range_min_m, range_edge_m, bearing_center_rad, bearing_half_width_rad, bearing_edge_rad, probability, \
/// probability_far, clutter_per_scan, mounting
///     As of a `RangeBearing`.
/// births_nearest_m, births_farthest_m : float, optional
///     First and last ring of the grid, m; left out: a tenth of the greatest range, and all of it.
/// births_rings, births_sectors : int
///     Rings of the grid, and points of each.
/// births_weight : float
///     Weight of each point: features that appear there between two scans.
#[pyclass(module = "scphd")]
pub struct BearingOnly(pub Parts<Direction, Vector1<f32>>);

#[pymethods]
impl BearingOnly {
    #[new]
    #[pyo3(signature = (*, bearing_sigma_rad, range_max_m, range_min_m=0.0, range_edge_m=0.0, bearing_center_rad=0.0,
                        bearing_half_width_rad=PI, bearing_edge_rad=0.0, probability=0.9, probability_far=None,
                        clutter_per_scan=1.0, births_nearest_m=None, births_farthest_m=None, births_rings=4,
                        births_sectors=24, births_weight=0.001, mounting=None))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        bearing_sigma_rad: f32,
        range_max_m: f32,
        range_min_m: f32,
        range_edge_m: f32,
        bearing_center_rad: f32,
        bearing_half_width_rad: f32,
        bearing_edge_rad: f32,
        probability: f32,
        probability_far: Option<f32>,
        clutter_per_scan: f32,
        births_nearest_m: Option<f32>,
        births_farthest_m: Option<f32>,
        births_rings: u16,
        births_sectors: u16,
        births_weight: f32,
        mounting: Option<&Bound<'_, Mounting>>,
    ) -> PyResult<Self> {
        let limits = RangeBearingLimits {
            range_min_m,
            range_max_m,
            range_edge_m,
            bearing_center_rad,
            bearing_half_width_rad,
            bearing_edge_rad,
            probability_near: probability,
            probability_far: probability_far.unwrap_or(probability),
        };
        let grid = PolarGrid {
            nearest_m: births_nearest_m.unwrap_or(0.1 * range_max_m),
            farthest_m: births_farthest_m.unwrap_or(range_max_m),
            rings: births_rings,
            sectors: births_sectors,
            weight: births_weight,
        };
        let sensing = || {
            let field_of_view = RangeBearingWindow::new(limits)?;
            let half_width_rad = bearing_half_width_rad.min(PI);
            let clutter = UniformClutter::of_scan(clutter_per_scan, half_width_rad + half_width_rad)?;
            let sensor = scphd::models::BearingOnly::new(bearing_sigma_rad, PolarBirths::new(grid)?)?;
            Ok(Sensing { sensor, field_of_view, clutter })
        };
        let names = [
            ("probability_near", "probability"),
            ("nearest_m", "births_nearest_m"),
            ("farthest_m", "births_farthest_m"),
            ("rings", "births_rings"),
            ("sectors", "births_sectors"),
            ("weight", "births_weight"),
        ];
        let sensing = sensing().map_err(|error| of_model(error, &names))?;
        Parts::new(sensing, Births::NONE, mounting.map(Bound::get)).map(Self)
    }
}

/// A scan of range and bearing, of shape (n, 2).
pub fn polar_scan(measurements: &Bound<'_, PyAny>) -> PyResult<Vec<Vector2<f32>>> {
    rows("measurements (range_m, bearing_rad)", measurements)
}

/// A scan of bearings, of shape (n,).
pub fn bearing_scan(measurements: &Bound<'_, PyAny>) -> PyResult<Vec<Vector1<f32>>> {
    line("measurements (bearing_rad)", measurements)
}

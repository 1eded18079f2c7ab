//! Sensors that detect features.

use crate::array::{Number, line, rows};
use crate::error::{InputError, Refusal, of_model};
use crate::keywords::{Keywords, object};
use crate::mounting::Mounting;
use nalgebra::{Vector1, Vector2};
use pyo3::prelude::*;
use scphd::models::{ModelError, PlanarPose, PolarGrid, RangeBearingLimits};
use scphd::{Births, Real};
use scphd_vehicle::{Direction, Polar, Sensor, SensorModel, StartError};
use std::f64::consts::PI;

/// The description of a sensor, and whether its birth intensity is the default for its range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Described {
    sensor: Sensor<f64>,
    usual_births: bool,
}

impl Described {
    /// A sensor without a view, for use before the first scan.
    pub const BLIND: Self = Self {
        sensor: Sensor {
            model: SensorModel::RangeBearing,
            range_sigma_m: 1.0,
            range_sigma_ratio: 0.0,
            bearing_sigma_rad: 1.0,
            window: RangeBearingLimits {
                range_min_m: 0.0,
                range_max_m: 1.0,
                range_edge_m: 0.0,
                bearing_center_rad: 0.0,
                bearing_half_width_rad: PI,
                bearing_edge_rad: 0.0,
                probability_near: 0.0,
                probability_far: 0.0,
            },
            clutter_per_scan: 0.0,
            births: Births { of_static: 0.0, of_moving: 0.0 },
            grid: PolarGrid { nearest_m: 0.1, farthest_m: 1.0, rings: 2, sectors: 1, weight: 0.0 },
            seat_m: [0.0; 2],
            yaw_rad: 0.0,
        },
        usual_births: false,
    };

    /// The sensor in the precision of a filter.
    pub fn sensor<T: Real>(&self) -> PyResult<Sensor<T>> {
        let sensor =
            Sensor::of_numbers(&self.sensor.numbers()).map_err(|invalid| StartError::from(invalid).raised())?;
        let mut sensor: Sensor<T> = sensor.ok_or_else(|| InputError::new_err("no sensor"))?;
        if self.usual_births {
            let RangeBearingLimits { range_max_m, probability_near, .. } = sensor.window;
            let sigmas = [sensor.range_sigma_m, sensor.bearing_sigma_rad];
            sensor.births.of_static = Sensor::range_bearing(range_max_m, probability_near, sigmas).births.of_static;
        }
        Ok(sensor)
    }

    fn seat(&self) -> Mounting {
        let [forward_m, left_m] = self.sensor.seat_m;
        Mounting([forward_m, left_m, self.sensor.yaw_rad])
    }

    /// The keywords of the field of view, which all sensors have.
    fn of_view(&self) -> Keywords {
        let Sensor { window, .. } = &self.sensor;
        Keywords::default()
            .number("bearing_sigma_rad", self.sensor.bearing_sigma_rad)
            .number("range_max_m", window.range_max_m)
            .number("range_min_m", window.range_min_m)
            .number("range_edge_m", window.range_edge_m)
            .number("bearing_center_rad", window.bearing_center_rad)
            .number("bearing_half_width_rad", window.bearing_half_width_rad)
            .number("bearing_edge_rad", window.bearing_edge_rad)
            .number("probability", window.probability_near)
            .number("probability_far", window.probability_far)
            .number("clutter_per_scan", self.sensor.clutter_per_scan)
            .object("mounting", Some(self.seat()).filter(|seat| *seat != Mounting::NONE))
    }
}

/// A sensor that measures range (m) and bearing (rad, 0 ahead, positive to the left) of features without labels.
///
/// The probability of detection decreases linearly with range, and to zero over a ramp at every edge of the field of view. A scan
/// has at most 1024 measurements.
///
/// Parameters
/// ----------
/// range_sigma_m, bearing_sigma_rad : float
///     Standard deviations of range and bearing, m and rad.
/// range_sigma_ratio : float
///     Standard deviation of the range divided by the range, in [0, 1]; adds in quadrature.
/// range_max_m, range_min_m : float
///     Greatest and smallest range, m.
/// range_edge_m, bearing_edge_rad : float
///     Half widths of the ramps at the edges of the view, m and rad.
/// bearing_center_rad, bearing_half_width_rad : float
///     Centre and half width of the view, rad; pi: all around.
/// probability : float
///     Probability of detection at range zero, in [0, 1).
/// probability_far : float, optional
///     Probability of detection at the greatest range; by default the same.
/// clutter_per_scan : float
///     Expected number of false measurements in a scan.
/// births_still, births_moving : float
///     Birth intensity, 1/(m rad), of static and of moving features. By default one static feature in ten scans of a full circle,
///     and no moving ones.
/// mounting : Mounting, optional
///     Pose of the sensor on the vehicle; by default that of the vehicle's pose.
#[pyclass(frozen, module = "scphd")]
pub struct RangeBearing(pub Described);

#[pymethods]
impl RangeBearing {
    #[new]
    #[pyo3(signature = (*, range_sigma_m, bearing_sigma_rad, range_max_m, range_sigma_ratio=0.0, range_min_m=0.0,
                        range_edge_m=0.0, bearing_center_rad=0.0, bearing_half_width_rad=PI, bearing_edge_rad=0.0,
                        probability=0.9, probability_far=None, clutter_per_scan=1.0, births_still=None, births_moving=0.0,
                        mounting=None))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        range_sigma_m: f64,
        bearing_sigma_rad: f64,
        range_max_m: f64,
        range_sigma_ratio: f64,
        range_min_m: f64,
        range_edge_m: f64,
        bearing_center_rad: f64,
        bearing_half_width_rad: f64,
        bearing_edge_rad: f64,
        probability: f64,
        probability_far: Option<f64>,
        clutter_per_scan: f64,
        births_still: Option<f64>,
        births_moving: f64,
        mounting: Option<Mounting>,
    ) -> PyResult<Self> {
        let window = RangeBearingLimits {
            range_min_m,
            range_max_m,
            range_edge_m,
            bearing_center_rad,
            bearing_half_width_rad,
            bearing_edge_rad,
            probability_near: probability,
            probability_far: probability_far.unwrap_or(probability),
        };
        let mut sensor = seated(window, [range_sigma_m, bearing_sigma_rad], clutter_per_scan, mounting);
        sensor.range_sigma_ratio = range_sigma_ratio;
        sensor.births.of_static = births_still.unwrap_or_default();
        sensor.births.of_moving = births_moving;
        let described = Described { sensor, usual_births: births_still.is_none() };
        polar(&described)?;
        Ok(Self(described))
    }
}

object! { RangeBearing, |described| {
    let Described { sensor, usual_births } = described;
    let keywords = described.of_view().number("range_sigma_m", sensor.range_sigma_m);
    let keywords = keywords.number("range_sigma_ratio", sensor.range_sigma_ratio);
    let keywords = keywords.number("births_moving", sensor.births.of_moving);
    if *usual_births { keywords } else { keywords.number("births_still", sensor.births.of_static) }
} }

/// A sensor that measures bearings only (rad, 0 ahead, positive to the left), such as a camera. For a `Filter`.
///
/// Features are born at the points of a polar grid around the sensor, because a bearing does not determine the range of its
/// feature.
///
/// Parameters
/// ----------
/// bearing_sigma_rad : float
///     Standard deviation of the noise, rad.
/// range_max_m, range_min_m, range_edge_m, bearing_center_rad, bearing_half_width_rad, bearing_edge_rad, probability, \
/// probability_far, clutter_per_scan, mounting
///     As for `RangeBearing`.
/// births_nearest_m, births_farthest_m : float, optional
///     Radii of the first and the last ring of the grid, m; by default a tenth of the greatest range, and the greatest range.
/// births_rings, births_sectors : int
///     Number of rings of the grid, and of points on each.
/// births_weight : float
///     Weight of each point: expected number of features that appear there between two scans.
#[pyclass(frozen, module = "scphd")]
pub struct BearingOnly(pub Described);

#[pymethods]
impl BearingOnly {
    #[new]
    #[pyo3(signature = (*, bearing_sigma_rad, range_max_m, range_min_m=0.0, range_edge_m=0.0, bearing_center_rad=0.0,
                        bearing_half_width_rad=PI, bearing_edge_rad=0.0, probability=0.9, probability_far=None,
                        clutter_per_scan=1.0, births_nearest_m=None, births_farthest_m=None, births_rings=4,
                        births_sectors=24, births_weight=0.001, mounting=None))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        bearing_sigma_rad: f64,
        range_max_m: f64,
        range_min_m: f64,
        range_edge_m: f64,
        bearing_center_rad: f64,
        bearing_half_width_rad: f64,
        bearing_edge_rad: f64,
        probability: f64,
        probability_far: Option<f64>,
        clutter_per_scan: f64,
        births_nearest_m: Option<f64>,
        births_farthest_m: Option<f64>,
        births_rings: u16,
        births_sectors: u16,
        births_weight: f64,
        mounting: Option<Mounting>,
    ) -> PyResult<Self> {
        let window = RangeBearingLimits {
            range_min_m,
            range_max_m,
            range_edge_m,
            bearing_center_rad,
            bearing_half_width_rad,
            bearing_edge_rad,
            probability_near: probability,
            probability_far: probability_far.unwrap_or(probability),
        };
        let mut sensor = seated(window, [1.0, bearing_sigma_rad], clutter_per_scan, mounting);
        sensor.model = SensorModel::Bearing;
        sensor.grid = PolarGrid {
            nearest_m: births_nearest_m.unwrap_or(sensor.grid.nearest_m),
            farthest_m: births_farthest_m.unwrap_or(range_max_m),
            rings: births_rings,
            sectors: births_sectors,
            weight: births_weight,
        };
        let described = Described { sensor, usual_births: true };
        direction(&described)?;
        Ok(Self(described))
    }
}

object! { BearingOnly, |described| {
    let grid = &described.sensor.grid;
    described.of_view()
        .number("births_nearest_m", grid.nearest_m)
        .number("births_farthest_m", grid.farthest_m)
        .count("births_rings", grid.rings)
        .count("births_sectors", grid.sectors)
        .number("births_weight", grid.weight)
} }

/// A range and bearing sensor with this view, standard deviations, clutter and mounting.
fn seated(
    window: RangeBearingLimits<f64>,
    sigmas: [f64; 2],
    clutter_per_scan: f64,
    mounting: Option<Mounting>,
) -> Sensor<f64> {
    let Mounting([forward_m, left_m, yaw_rad]) = mounting.unwrap_or(Mounting::NONE);
    let sensor = Sensor::range_bearing(window.range_max_m, window.probability_near, sigmas);
    Sensor { window, clutter_per_scan, seat_m: [forward_m, left_m], yaw_rad, ..sensor }
}

/// Converts an error of a model, with the parameter's name in Python.
fn named(error: ModelError) -> PyErr {
    let names = [
        ("births.of_static", "births_still"),
        ("births.of_moving", "births_moving"),
        ("probability_near", "probability"),
        ("nearest_m", "births_nearest_m"),
        ("farthest_m", "births_farthest_m"),
        ("rings", "births_rings"),
        ("sectors", "births_sectors"),
        ("weight", "births_weight"),
    ];
    of_model(error, &names)
}

/// The range and bearing detector.
pub fn polar(described: &Described) -> PyResult<Polar<PlanarPose<f32>, f32>> {
    described.sensor()?.polar::<PlanarPose<f32>>().map_err(named)
}

/// The bearing detector.
pub fn direction(described: &Described) -> PyResult<Direction<PlanarPose<f32>, f32>> {
    described.sensor()?.direction::<PlanarPose<f32>>().map_err(named)
}

/// A scan of ranges and bearings, of shape (n, 2).
pub fn polar_scan<T: Number>(measurements: &Bound<'_, PyAny>) -> PyResult<Vec<Vector2<T>>> {
    rows("measurements (range_m, bearing_rad)", measurements)
}

/// A scan of bearings, of shape (n,).
pub fn bearing_scan<T: Number>(measurements: &Bound<'_, PyAny>) -> PyResult<Vec<Vector1<T>>> {
    let bearings = line("measurements (bearing_rad)", measurements)?;
    Ok(bearings.into_iter().map(Vector1::new).collect())
}

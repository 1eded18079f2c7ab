//! The class `Filter`: `ScPhd`, the mixture.

use crate::array;
use crate::detector::{BearingOnly, Described, RangeBearing, bearing_scan, direction, polar, polar_scan};
use crate::error::{NotStartedError, Refusal, not_started, wrong_type};
use crate::estimate::{Map, Movers, Pose, all};
use crate::fix::{Measured, Single};
use crate::made::{Made, Parts};
use crate::memory::{Mixture, MixtureCell, ScanMemory, mixture, scan_memory};
use crate::report::{FixReport, PredictReport, ScanReport};
use crate::tuning;
use crate::vehicle::Vehicle;
use nalgebra::Vector1;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use scphd::models::PlanarPose;
use scphd::snapshot::from_slice;
use scphd_vehicle::Watched;
use std::convert::Infallible;
use std::sync::Mutex;

/// The filter of the thesis (`ScPhd`) for a vehicle in the plane: particles, each with a Gaussian mixture as its map. In single
/// precision; the same inputs give bit-identical results in firmware, C and Rust.
///
/// Only one thread at a time may use a filter. Different filters may be used by different threads at the same time.
///
/// Parameters
/// ----------
/// vehicle : Unicycle, Ackermann, Holonomic or KnownPose
///     The motion model of the vehicle.
/// proposal : str
///     'informed': few particles, drawn from a proposal density that uses the scan; for sensors whose scan determines the pose
///     among known features. 'blind': many particles, drawn from the motion model and then weighted with the scan.
/// particles, samples : int
///     Number of particles, and number of samples of each in a prediction ('blind').
/// memory : str
///     Capacities: 'DESK' (512 particles with 4 samples, 131 072 components), or those of a set of the C interface: 'PLANE_32X2',
///     'PLANE_INFORMED_4', 'PLANE_INFORMED_4_MOVING'.
/// informed_rounds : int
///     Maximum number of linearisations of the informed proposal, 1 to 16.
/// informed_sampled_fraction : float
///     Fraction of the covariance with which the informed proposal draws its samples, 0 to 1.
/// informed_min_responsibility : float
///     Minimum association probability of a component and a measurement for the measurement to correct the pose.
/// resample_threshold : float
///     The particles are resampled if the effective number of candidates is below this fraction of their number.
/// prune_weight : float
///     Pruning threshold: components with a smaller weight are removed.
/// confirming_detections : float
///     k: a component is confirmed if its covariance is smaller than k measurements would give.
/// unconfirmed_weight : float
///     An unconfirmed component that leaves the field of view is removed if its weight is below this. 0: none is.
/// confirmed_weight : float
///     Lower limit of the weight of a confirmed component after missed detections. 0: no limit.
/// merge_distance : float
///     Merging threshold: components are merged within this squared Mahalanobis distance.
/// extraction : str
///     Estimated features: the 'heaviest' components, the highest 'peaks' of the intensity, or all that are 'confirmed' with the
///     RangeBearing detector of the last scan.
/// max_components : int
///     Maximum number of components in view after a scan, for static and for moving features.
/// extraction_weight : float
///     Minimum weight of an estimated feature.
/// births_wait : bool
///     Whether births of measurements that no component explains wait for the next scan: fewer components.
/// moving_velocity_sigma_mps : float
///     Moving features: standard deviation of the velocity of a new one along each axis, m/s.
/// moving_acceleration_psd : float
///     Moving features: power spectral density of the acceleration, m^2/s^3.
/// moving_lifetime_s : float
///     Moving features: mean time until one disappears, s.
/// moving_spread_max_m : float
///     Moving features: one with a larger standard deviation of the position, m, is removed.
/// moving_extraction_weight : float
///     Moving features: minimum weight of an estimated one.
/// step_max_s, speed_max_mps, turn_rate_max_radps, jump_max_m : float
///     Limits of the motion; a prediction beyond them is refused.
#[pyclass(module = "scphd")]
pub struct Filter {
    vehicle: Vehicle,
    /// Never locked, because every call has exclusive access to the filter. The mutex makes the cell shareable between threads.
    cell: Mutex<MixtureCell>,
    scratch: Box<ScanMemory>,
    last: Option<ScanReport>,
    /// The detector of the last scan of ranges and bearings.
    seen_by: Option<Described>,
    made: Made,
}

impl Filter {
    fn with<R>(&mut self, work: impl FnOnce(&mut Mixture<'_>, &mut ScanMemory) -> R) -> R {
        let cell = self.cell.get_mut().unwrap_or_else(|poisoned| poisoned.into_inner());
        cell.with_dependent_mut(|_, filter| work(filter, &mut self.scratch))
    }
}

#[pymethods]
impl Filter {
    #[new]
    #[pyo3(signature = (vehicle, *, proposal="informed", particles=4, samples=1, memory="DESK", **settings))]
    fn new(
        vehicle: &Bound<'_, PyAny>,
        proposal: &str,
        particles: usize,
        samples: usize,
        memory: &str,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let motion = Vehicle::of(vehicle)?;
        let config = tuning::of_mixture(proposal, particles, samples, settings)?;
        let cell = Mutex::new(mixture(memory, motion, config)?);
        let made = Made::of(vehicle, settings)?;
        made.keep(vehicle.py(), "proposal", proposal)?;
        made.keep(vehicle.py(), "particles", particles)?;
        made.keep(vehicle.py(), "samples", samples)?;
        made.keep(vehicle.py(), "memory", memory)?;
        Ok(Self { vehicle: motion, cell, scratch: scan_memory()?, last: None, seen_by: None, made })
    }

    /// Sets the pose, clears the map and seeds the random numbers.
    ///
    /// Raises InputError if the pose is not finite or farther away than 1e8 m.
    #[pyo3(signature = (x_m=0.0, y_m=0.0, heading_rad=0.0, *, seed=0))]
    fn reset(&mut self, x_m: f32, y_m: f32, heading_rad: f32, seed: u64) -> PyResult<()> {
        let pose = PlanarPose::new(x_m, y_m, heading_rad);
        self.with(|filter, _| filter.reset(pose, seed)).map_err(Refusal::raised)?;
        self.last = None;
        Ok(())
    }

    /// Predicts the pose after `dt_s` seconds.
    ///
    /// Parameters
    /// ----------
    /// control : array_like, shape (2,) or (3,)
    ///     Unicycle: speed m/s, turn rate rad/s. Ackermann: speed m/s, steering angle rad. Holonomic: speed ahead m/s, speed to
    ///     the left m/s, turn rate rad/s. KnownPose: the pose at the end, x m, y m, heading rad.
    /// dt_s : float
    ///     Time step, s.
    ///
    /// Raises InputError if the control is refused. The time of the filter advances nevertheless, and the next report counts the
    /// refusal.
    fn predict(&mut self, py: Python<'_>, control: &Bound<'_, PyAny>, dt_s: f32) -> PyResult<PredictReport> {
        let control = self.vehicle.control(control)?;
        py.detach(|| self.with(|filter, _| filter.predict(&control, dt_s)))
            .map(PredictReport::from)
            .map_err(Refusal::raised)
    }

    /// Updates the filter with a scan of one of the vehicle's detectors. A vehicle may have any number of them.
    ///
    /// Parameters
    /// ----------
    /// detector : RangeBearing or BearingOnly
    ///     The detector that made the scan.
    /// measurements : array_like
    ///     Of a RangeBearing: shape (n, 2), range m and bearing rad. Of a BearingOnly: shape (n,), rad. In single precision.
    ///
    /// Raises InputError if a measurement is not finite or there are more than 1024. The filter is then unchanged.
    fn scan(
        &mut self,
        py: Python<'_>,
        detector: &Bound<'_, PyAny>,
        measurements: &Bound<'_, PyAny>,
    ) -> PyResult<ScanReport> {
        let report = if let Ok(detector) = detector.cast::<RangeBearing>() {
            let scan = polar_scan(measurements)?;
            self.seen_by = Some(detector.get().0);
            let detector = polar(&detector.get().0)?;
            py.detach(|| self.with(|filter, scratch| Ok(filter.scan(&mut detector.over(&mut scratch.polar)?, &scan))))
        } else if let Ok(detector) = detector.cast::<BearingOnly>() {
            let scan = bearing_scan(measurements)?;
            let detector = direction(&detector.get().0)?;
            py.detach(|| {
                self.with(|filter, scratch| Ok(filter.scan(&mut detector.over(&mut scratch.direction)?, &scan)))
            })
        } else {
            return Err(wrong_type("detector", "a RangeBearing or a BearingOnly", detector));
        };
        let report = report.map_err(|error: scphd::errors::SetupError| error.raised())?;
        let report = ScanReport::from(report.map_err(Refusal::raised)?);
        self.last = Some(report);
        Ok(report)
    }

    /// Updates the filter with a fix, a measurement of the pose, at any time between other calls.
    ///
    /// Parameters
    /// ----------
    /// fix : PositionFix or HeadingFix
    ///     The model of the measurement.
    /// measurement : array_like, shape (2,), or float
    ///     The position (x m, y m), or the heading, rad.
    fn observe(&mut self, fix: &Bound<'_, PyAny>, measurement: &Bound<'_, PyAny>) -> PyResult<FixReport> {
        let measured = Measured::of(fix, measurement)?;
        let report = match (measured.model()?, measured) {
            (Single::Position(fix), Measured::Position(_, position)) => {
                self.with(|filter, _| filter.observe(&fix, &position))
            }
            (Single::Heading(fix), Measured::Heading(_, heading)) => {
                self.with(|filter, _| filter.observe(&fix, &Vector1::new(heading)))
            }
            _ => return Err(wrong_type("fix", "a PositionFix or a HeadingFix", fix)),
        };
        let report = report.map_err(Refusal::raised)?;
        Ok(Watched { report, relocated: false }.into())
    }

    /// The pose estimate: mean and covariance over all candidates.
    ///
    /// Raises NotStartedError before the first reset.
    fn estimate(&mut self) -> PyResult<Pose> {
        let estimate = self.with(|filter, _| filter.estimate_pose());
        estimate.map(Pose::from).ok_or_else(not_started)
    }

    /// The static features of the particle with the greatest weight.
    fn map(&mut self) -> PyResult<Map> {
        let detector = polar(&self.seen_by.unwrap_or(Described::BLIND))?;
        Ok(Map::of(self.with(|filter, _| all(|room| filter.estimate_map(&detector, room)))))
    }

    /// The moving features of the particle with the greatest weight, at their present positions.
    fn movers(&mut self) -> Movers {
        Movers::of(self.with(|filter, _| all(|room| filter.estimate_moving(room))))
    }

    /// The report of the last scan; None before the first.
    fn report(&self) -> Option<ScanReport> {
        self.last
    }

    /// Sets the pose and its covariance, shape (3, 3), of (x m, y m, heading rad), and keeps the map.
    fn relocate(&mut self, x_m: f32, y_m: f32, heading_rad: f32, covariance: &Bound<'_, PyAny>) -> PyResult<()> {
        let (pose, spread) = (PlanarPose::new(x_m, y_m, heading_rad), array::covariance("covariance", covariance)?);
        self.with(|filter, _| filter.relocate(pose, &spread)).map_err(Refusal::raised)
    }

    /// Adds this covariance, shape (3, 3), of (x m, y m, heading rad), to that of the pose.
    fn scatter(&mut self, covariance: &Bound<'_, PyAny>) -> PyResult<()> {
        let spread = array::covariance("covariance", covariance)?;
        self.with(|filter, _| filter.scatter(&spread)).map_err(Refusal::raised)
    }

    /// Replaces the map, for example with that of another filter or of an earlier drive.
    fn load_map(&mut self, map: &Map) -> PyResult<()> {
        let features = map.components();
        self.with(|filter, _| filter.load_map(&features)).map_err(Refusal::raised)
    }

    /// A hash of the whole state: the same inputs give the same hash on every machine and in every language.
    fn digest(&mut self) -> u64 {
        self.with(|filter, _| filter.digest())
    }

    /// The whole state as bytes, in the format of the firmware (`docs/snapshot.md`).
    ///
    /// `kind` is a number of the vehicle type; a snapshot can only be restored with the same number.
    #[pyo3(signature = (*, kind=0))]
    fn snapshot<'py>(&mut self, py: Python<'py>, kind: u32) -> PyResult<Bound<'py, PyBytes>> {
        let mut bytes = Vec::new();
        let sink = |chunk: &[u8]| {
            bytes.extend_from_slice(chunk);
            Ok::<(), Infallible>(())
        };
        self.with(|filter, _| filter.save(kind, sink)).map_err(Refusal::raised)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Restores a snapshot of a filter with the same number of particles and the same proposal. It then continues as if
    /// uninterrupted.
    ///
    /// Raises SnapshotError if the bytes are no snapshot of such a filter. The filter is then unchanged.
    #[pyo3(signature = (snapshot, *, kind=0))]
    fn restore(&mut self, snapshot: &[u8], kind: u32) -> PyResult<()> {
        self.with(|filter, _| filter.restore(kind, from_slice(snapshot))).map_err(Refusal::raised)?;
        self.last = None;
        Ok(())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        self.made.written(py, "Filter")
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Parts<'py>> {
        let snapshot = match slf.borrow_mut().snapshot(slf.py(), 0) {
            Ok(snapshot) => Some(snapshot),
            Err(error) if error.is_instance_of::<NotStartedError>(slf.py()) => None,
            Err(error) => return Err(error),
        };
        slf.borrow().made.parts(slf.get_type(), snapshot)
    }
}

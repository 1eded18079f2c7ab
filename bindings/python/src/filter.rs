//! The mixture.

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

/// The filter of the thesis (`ScPhd`) for a vehicle in the plane: particles, each with a Gaussian mixture as its map. Single precision;
/// the same inputs give the same bits as in firmware, in C and in Rust.
///
/// One thread at a time may work with a filter; different filters work in different threads at the same time.
///
/// Parameters
/// ----------
/// vehicle : Unicycle, Ackermann, Holonomic or KnownPose
///     How it moves.
/// proposal : str
///     'informed': a few particles that take the scan in before they are drawn, for sensors whose scan tells where the vehicle is
///     among its features. 'blind': many particles, among whose samples the scan chooses.
/// particles, samples : int
///     Particles kept between scans, and samples of each in a prediction ('blind').
/// memory : str
///     How much room there is: 'DESK' (512 particles of 4 samples, 131 072 components), or as much as a set of the C interface has:
///     'PLANE_32X2', 'PLANE_INFORMED_4', 'PLANE_INFORMED_4_MOVING'.
/// informed_rounds : int
///     Linearisations of the informed proposal, 1 to 16.
/// informed_sampled_fraction : float
///     Share of the covariance that is drawn from, 0 to 1.
/// informed_min_responsibility : float
///     A component speaks for a measurement of which it explains this share.
/// resample_threshold : float
///     Resampled where the effective share of the particles is below.
/// prune_weight : float
///     Components below this weight are dropped.
/// confirming_detections : float
///     A component is confirmed where it is better known than by so many measurements.
/// unconfirmed_weight : float
///     One that leaves the view lighter than this, not confirmed, is forgotten. 0: none is.
/// confirmed_weight : float
///     Misses take a confirmed component no further down. 0: they do.
/// merge_distance : float
///     Squared Mahalanobis distance within which components are merged.
/// extraction : str
///     The estimated features are the 'heaviest' components, the highest 'peaks' of the intensity, or all that are 'confirmed' as the
///     RangeBearing of the last scan sees them.
/// max_components : int
///     The most components in view that a scan leaves, of each kind.
/// extraction_weight : float
///     Least weight of an estimated feature.
/// births_wait : bool
///     Whether births that nothing explains wait for the next scan: fewer components, for filters of a single sensor.
/// moving_velocity_sigma_mps : float
///     Of moving features: standard deviation of a new one's velocity along each axis, m/s.
/// moving_acceleration_psd : float
///     Power spectral density of their acceleration, m^2/s^3.
/// moving_lifetime_s : float
///     Mean time until one vanishes, s.
/// moving_spread_max_m : float
///     One less certain than this, m, is forgotten.
/// moving_extraction_weight : float
///     Least weight of an estimated one.
/// step_max_s, speed_max_mps, turn_rate_max_radps, jump_max_m : float
///     What no vehicle does: a prediction beyond is refused.
#[pyclass(module = "scphd")]
pub struct Filter {
    vehicle: Vehicle,
    /// Nobody ever waits for it: every call has the filter to itself. It makes the cell one that threads may share.
    cell: Mutex<MixtureCell>,
    scratch: Box<ScanMemory>,
    last: Option<ScanReport>,
    /// The detector of the last scan of range and bearing.
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

    /// Puts the vehicle to a pose, with an empty map, and begins the random stream of a seed.
    ///
    /// Raises InputError where the pose is not finite or farther away than 1e8 m.
    #[pyo3(signature = (x_m=0.0, y_m=0.0, heading_rad=0.0, *, seed=0))]
    fn reset(&mut self, x_m: f32, y_m: f32, heading_rad: f32, seed: u64) -> PyResult<()> {
        let pose = PlanarPose::new(x_m, y_m, heading_rad);
        self.with(|filter, _| filter.reset(pose, seed)).map_err(Refusal::raised)?;
        self.last = None;
        Ok(())
    }

    /// Moves the vehicle for `dt_s` seconds.
    ///
    /// Parameters
    /// ----------
    /// control : array_like, shape (2,) or (3,)
    ///     Of a Unicycle (speed m/s, turn rate rad/s), of an Ackermann (speed m/s, steering angle rad), of a Holonomic (ahead m/s, left m/s, turn rate rad/s), of a KnownPose the pose at the
    ///     end (x m, y m, heading rad).
    /// dt_s : float
    ///     s.
    ///
    /// Raises InputError where the control is refused: its time has passed all the same, and the next report says so.
    fn predict(&mut self, py: Python<'_>, control: &Bound<'_, PyAny>, dt_s: f32) -> PyResult<PredictReport> {
        let control = self.vehicle.control(control)?;
        py.detach(|| self.with(|filter, _| filter.predict(&control, dt_s)))
            .map(PredictReport::from)
            .map_err(Refusal::raised)
    }

    /// Takes in one scan of one of the vehicle's detectors, of which there may be any number.
    ///
    /// Parameters
    /// ----------
    /// detector : RangeBearing or BearingOnly
    ///     Whose scan it is.
    /// measurements : array_like
    ///     Of a RangeBearing shape (n, 2), range m and bearing rad; of a BearingOnly shape (n,), rad. In single precision.
    ///
    /// Raises InputError where a measurement is not finite or there are more than 1024; the filter is as it was.
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

    /// Takes in a measurement of the pose itself, between any two steps.
    ///
    /// Parameters
    /// ----------
    /// fix : PositionFix or HeadingFix
    ///     How it is measured.
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

    /// Where the vehicle is: mean and covariance over all candidates.
    ///
    /// Raises NotStartedError before the first reset.
    fn estimate(&mut self) -> PyResult<Pose> {
        let estimate = self.with(|filter, _| filter.estimate_pose());
        estimate.map(Pose::from).ok_or_else(not_started)
    }

    /// The features that stand still, of the heaviest particle.
    fn map(&mut self) -> PyResult<Map> {
        let detector = polar(&self.seen_by.unwrap_or(Described::BLIND))?;
        Ok(Map::of(self.with(|filter, _| all(|room| filter.estimate_map(&detector, room)))))
    }

    /// The features that move, of the heaviest particle, where they are by now.
    fn movers(&mut self) -> Movers {
        Movers::of(self.with(|filter, _| all(|room| filter.estimate_moving(room))))
    }

    /// The report of the last scan; None before the first.
    fn report(&self) -> Option<ScanReport> {
        self.last
    }

    /// Puts the vehicle to a pose with this covariance, shape (3, 3), of (x m, y m, heading rad): the map stays.
    fn relocate(&mut self, x_m: f32, y_m: f32, heading_rad: f32, covariance: &Bound<'_, PyAny>) -> PyResult<()> {
        let (pose, spread) = (PlanarPose::new(x_m, y_m, heading_rad), array::covariance("covariance", covariance)?);
        self.with(|filter, _| filter.relocate(pose, &spread)).map_err(Refusal::raised)
    }

    /// Makes the pose uncertain by a further covariance, shape (3, 3), of (x m, y m, heading rad).
    fn scatter(&mut self, covariance: &Bound<'_, PyAny>) -> PyResult<()> {
        let spread = array::covariance("covariance", covariance)?;
        self.with(|filter, _| filter.scatter(&spread)).map_err(Refusal::raised)
    }

    /// Puts a map in the place of the one that there is: of another filter, or of an earlier drive.
    fn load_map(&mut self, map: &Map) -> PyResult<()> {
        let features = map.components();
        self.with(|filter, _| filter.load_map(&features)).map_err(Refusal::raised)
    }

    /// A hash of all that the filter knows, to the last bit: the same inputs give the same on every machine and in every language.
    fn digest(&mut self) -> u64 {
        self.with(|filter, _| filter.digest())
    }

    /// All that decides how the filter goes on, as bytes: `docs/snapshot.md` has the format, which the firmware's is.
    ///
    /// `kind` tells vehicles apart whose snapshots are not to be mixed up.
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

    /// Goes on from a snapshot of a filter with as many particles and the same proposal, as if nothing had been.
    ///
    /// Raises SnapshotError where the bytes are no snapshot of such a filter; then the filter is as it was.
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

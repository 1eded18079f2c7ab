//! The class `JointFilter`: `JointSlam`, the joint map.

use crate::array::{Number, covariance};
use crate::detector::{Described, RangeBearing, polar_scan};
use crate::error::{NotStartedError, Refusal, SettingError, not_started, wrong_type};
use crate::estimate::{Map, Movers, Odometry, Pose, all};
use crate::fix::Measured;
use crate::joint_memory::{Cell, double, single};
use crate::made::{Made, Parts};
use crate::report::{FixReport, JointReport, PredictReport};
use crate::tuning;
use crate::vehicle::{control, driven};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use scphd::models::PlanarPose;
use scphd_vehicle::{Description, FixSpec, Measurements, Scanned, Sensor, Services, Start, StartError, Watched};
use std::sync::{Mutex, PoisonError};

/// A filter of one precision, with the sensors and fixes it was used with.
struct Running<T: Number> {
    description: Description<T>,
    /// Never locked, because every call has exclusive access to the filter. The mutex makes the cell shareable between threads.
    cell: Mutex<Box<dyn Cell<T>>>,
    /// Index of the sensor that the next new one replaces, if there is no free place.
    oldest: usize,
}

impl<T: Number> Running<T> {
    fn new(description: Description<T>, cell: Box<dyn Cell<T>>) -> Box<Self> {
        Box::new(Self { description, cell: Mutex::new(cell), oldest: 0 })
    }

    fn with<R: Send>(&mut self, work: impl FnOnce(&mut dyn Services<T>) -> R + Send) -> PyResult<R> {
        let cell = self.cell.get_mut().unwrap_or_else(PoisonError::into_inner);
        let (mut work, mut done) = (Some(work), None);
        cell.enter(&mut |slam| done = work.take().map(|work| work(slam)));
        done.ok_or_else(|| SettingError::new_err("the filter was not entered"))
    }

    /// Continues with a changed description.
    fn change(&mut self, description: Description<T>) -> PyResult<()> {
        self.with(|slam| slam.configure(&description))?.map_err(StartError::raised)?;
        self.description = description;
        Ok(())
    }

    /// Index of a sensor in the description; adds it if necessary.
    fn place(&mut self, sensor: Sensor<T>) -> PyResult<usize> {
        let sensors = &self.description.sensors;
        if let Some(place) = sensors.iter().position(|known| *known == Some(sensor)) {
            return Ok(place);
        }
        let place = sensors.iter().position(Option::is_none).unwrap_or(self.oldest);
        let mut description = self.description;
        description.sensors[place] = Some(sensor);
        self.change(description)?;
        self.oldest = (place + 1) % description.sensors.len();
        Ok(place)
    }

    fn predict(&mut self, py: Python<'_>, array: &Bound<'_, PyAny>, dt_s: f64) -> PyResult<PredictReport> {
        let control = control(self.description.vehicle.kind, array)?;
        let report = py.detach(|| self.with(|slam| slam.predict(control, T::from_f64(dt_s))))?;
        report.map(PredictReport::from).map_err(Refusal::raised)
    }

    fn scan(
        &mut self,
        py: Python<'_>,
        sensor: &Described,
        scan: &Bound<'_, PyAny>,
        fixed: bool,
    ) -> PyResult<Scanned<T>> {
        let measurements = polar_scan(scan)?;
        let place = self.place(sensor.sensor()?)?;
        let scan = Measurements::RangeBearing(&measurements);
        let take = |slam: &mut dyn Services<T>| if fixed { slam.localise(place, scan) } else { slam.scan(place, scan) };
        py.detach(|| self.with(take))?.map_err(Refusal::raised)
    }

    fn observe(&mut self, fix: &Bound<'_, PyAny>, measurement: &Bound<'_, PyAny>) -> PyResult<Watched<T>> {
        let measured = Measured::of(fix, measurement)?;
        let mut description = self.description;
        let (known, now): (&mut Option<FixSpec<T>>, _) = match measured {
            Measured::Position(spec, _) => (&mut description.position, spec),
            Measured::Heading(spec, _) => (&mut description.heading, spec),
        };
        if known.replace(now) != Some(now) {
            self.change(description)?;
        }
        let watched = self.with(|slam| match measured {
            Measured::Position(_, position) => slam.watch_position(position.x, position.y),
            Measured::Heading(_, heading) => slam.watch_heading(heading),
        })?;
        watched.map_err(Refusal::raised)
    }

    fn reset(&mut self, pose: [f64; 3], position_sigma_m: f64, heading_sigma_rad: f64) -> PyResult<()> {
        let [x_m, y_m, heading_rad] = pose.map(T::from_f64);
        let start = Start {
            pose: PlanarPose::new(x_m, y_m, heading_rad),
            position_sigma_m: T::from_f64(position_sigma_m),
            heading_sigma_rad: T::from_f64(heading_sigma_rad),
            seed: 1,
        };
        self.with(|slam| slam.reset(&start))?.map_err(Refusal::raised)
    }

    fn relocate(&mut self, pose: [f64; 3], spread: &Bound<'_, PyAny>) -> PyResult<()> {
        let [x_m, y_m, heading_rad] = pose.map(T::from_f64);
        let (pose, spread) = (PlanarPose::new(x_m, y_m, heading_rad), covariance("covariance", spread)?);
        self.with(|slam| slam.relocate(pose, &spread))?.map_err(Refusal::raised)
    }

    fn scatter(&mut self, spread: &Bound<'_, PyAny>) -> PyResult<()> {
        let spread = covariance("covariance", spread)?;
        self.with(|slam| slam.scatter(&spread))?.map_err(Refusal::raised)
    }

    fn snapshot(&mut self, kind: u32) -> PyResult<Vec<u8>> {
        let mut bytes = Vec::new();
        let sink = &mut |chunk: &[u8]| {
            bytes.extend_from_slice(chunk);
            Ok(())
        };
        self.with(|slam| slam.save(kind, sink))?.map_err(Refusal::raised)?;
        Ok(bytes)
    }

    fn restore(&mut self, snapshot: &[u8], kind: u32) -> PyResult<()> {
        let mut source = scphd::snapshot::from_slice(snapshot);
        self.with(|slam| slam.restore(kind, &mut source))?.map(drop).map_err(Refusal::raised)
    }
}

/// A filter of either precision.
enum Either {
    Single(Box<Running<f32>>),
    Double(Box<Running<f64>>),
}

/// Evaluates an expression with a filter of either precision.
macro_rules! each {
    ($either:expr, |$running:ident| $done:expr) => {
        match $either {
            Either::Single($running) => $done,
            Either::Double($running) => $done,
        }
    };
}

/// One Gaussian over the pose and a map of static features (`JointSlam`), with moving-object tracks as an option. In single
/// precision the same inputs give bit-identical results in firmware, C and Rust.
///
/// Only one thread at a time may use a filter. Different filters may be used by different threads at the same time. A filter can
/// be copied and pickled; the monitoring of rejected fixes then starts again.
///
/// Parameters
/// ----------
/// vehicle : Unicycle, Ackermann or Holonomic
///     The motion model of the vehicle.
/// memory : str
///     Capacities: 'DESK' (512 features, 128 moving ones, scans of 256 measurements; with an archive 200 features and 10 000 in
///     the archive; with hypotheses eight of 256 features), or those of a set of the C interface: 'JOINT_40', 'JOINT_100',
///     'JOINT_60_MOVERS', 'JOINT_100_MOVERS', 'JOINT_40_ARCHIVE', 'JOINT_60_LEARNING', 'JOINT_24_HYPOTHESES'.
/// precision : str
///     'single', or 'double', which needs the memory 'DESK'.
#[pyclass(module = "scphd")]
pub struct JointFilter {
    running: Either,
    last: Option<JointReport>,
    made: Made,
}

#[pymethods]
impl JointFilter {
    #[new]
    #[pyo3(signature = (vehicle, *, memory="DESK", precision="single", **settings))]
    fn new(
        vehicle: &Bound<'_, PyAny>,
        memory: &str,
        precision: &str,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let motion =
            driven(vehicle).ok_or_else(|| wrong_type("vehicle", "a Unicycle, an Ackermann or a Holonomic", vehicle))?;
        let description = tuning::of_joint_map(motion, settings)?;
        let running = match precision {
            "single" => {
                let description = tuning::cast(&description)?;
                Either::Single(Running::new(description, single(memory, &description)?))
            }
            "double" => Either::Double(Running::new(description, double(memory, &description)?)),
            other => {
                return Err(SettingError::new_err(format!("precision must be 'single' or 'double', not '{other}'")));
            }
        };
        let made = Made::of(vehicle, settings)?;
        made.keep(vehicle.py(), "memory", memory)?;
        made.keep(vehicle.py(), "precision", precision)?;
        Ok(Self { running, last: None, made })
    }

    /// Sets the pose and clears the map. The default standard deviations, m and rad, are zero: the pose is known exactly.
    ///
    /// Raises InputError if the pose is not finite or farther away than 1e8 m.
    #[pyo3(signature = (x_m=0.0, y_m=0.0, heading_rad=0.0, *, position_sigma_m=0.0, heading_sigma_rad=0.0))]
    fn reset(
        &mut self,
        x_m: f64,
        y_m: f64,
        heading_rad: f64,
        position_sigma_m: f64,
        heading_sigma_rad: f64,
    ) -> PyResult<()> {
        let pose = [x_m, y_m, heading_rad];
        each!(&mut self.running, |running| running.reset(pose, position_sigma_m, heading_sigma_rad))?;
        self.last = None;
        Ok(())
    }

    /// Predicts the pose after `dt_s` seconds, as `Filter.predict` does.
    fn predict(&mut self, py: Python<'_>, control: &Bound<'_, PyAny>, dt_s: f64) -> PyResult<PredictReport> {
        each!(&mut self.running, |running| running.predict(py, control, dt_s))
    }

    /// Updates the filter with a scan of one of the vehicle's detectors. Any number may be used; up to four are kept configured.
    ///
    /// Parameters
    /// ----------
    /// detector : RangeBearing
    ///     The detector that made the scan. Its births of moving features are ignored unless the filter has movers.
    /// measurements : array_like, shape (n, 2)
    ///     Range m and bearing rad.
    ///
    /// Raises InputError if a measurement is not finite or there are more than the memory holds. The filter is then unchanged.
    fn scan(
        &mut self,
        py: Python<'_>,
        detector: &Bound<'_, PyAny>,
        measurements: &Bound<'_, PyAny>,
    ) -> PyResult<JointReport> {
        self.take(py, detector, measurements, false)
    }

    /// Updates only the pose with a scan; the map does not change.
    fn localise(
        &mut self,
        py: Python<'_>,
        detector: &Bound<'_, PyAny>,
        measurements: &Bound<'_, PyAny>,
    ) -> PyResult<JointReport> {
        self.take(py, detector, measurements, true)
    }

    /// Updates the filter with a fix, as `Filter.observe` does. If the fix has `watch_patience_s`, the filter may be moved to it.
    fn observe(&mut self, fix: &Bound<'_, PyAny>, measurement: &Bound<'_, PyAny>) -> PyResult<FixReport> {
        each!(&mut self.running, |running| running.observe(fix, measurement).map(FixReport::from))
    }

    /// The pose estimate.
    ///
    /// Raises NotStartedError before the first reset.
    fn estimate(&mut self) -> PyResult<Pose> {
        each!(&mut self.running, |running| running.with(|slam| slam.pose())?.map(Pose::from)).ok_or_else(not_started)
    }

    /// The estimated odometry error, with `odometry=True`; None otherwise and before the first reset.
    fn odometry(&mut self) -> PyResult<Option<Odometry>> {
        Ok(each!(&mut self.running, |running| running.with(|slam| slam.odometry())?.map(Odometry::from)))
    }

    /// The static features detected at least twice, with an existence probability of at least `extraction_existence`.
    fn map(&mut self) -> PyResult<Map> {
        each!(&mut self.running, |running| running.with(|slam| all(|room| slam.features(room))).map(Map::of))
    }

    /// The moving features, at their present positions.
    fn movers(&mut self) -> PyResult<Movers> {
        each!(&mut self.running, |running| running.with(|slam| all(|room| slam.movers(room))).map(Movers::of))
    }

    /// Sets the pose and its covariance, shape (3, 3), of (x m, y m, heading rad), and keeps the map.
    fn relocate(&mut self, x_m: f64, y_m: f64, heading_rad: f64, covariance: &Bound<'_, PyAny>) -> PyResult<()> {
        each!(&mut self.running, |running| running.relocate([x_m, y_m, heading_rad], covariance))
    }

    /// Adds this covariance, shape (3, 3), of (x m, y m, heading rad), to that of the pose.
    fn scatter(&mut self, covariance: &Bound<'_, PyAny>) -> PyResult<()> {
        each!(&mut self.running, |running| running.scatter(covariance))
    }

    /// Replaces the map, for example with that of another filter or of an earlier drive.
    fn load_map(&mut self, map: &Map) -> PyResult<()> {
        each!(&mut self.running, |running| {
            let features = map.components();
            running.with(|slam| slam.load_map(&features))?.map_err(Refusal::raised)
        })
    }

    /// The report of the last scan; None before the first.
    fn report(&self) -> Option<JointReport> {
        self.last
    }

    /// A hash of the whole state: the same inputs give the same hash on every machine and in every language.
    fn digest(&mut self) -> PyResult<u64> {
        each!(&mut self.running, |running| running.with(|slam| slam.digest()))
    }

    /// The whole state as bytes, as `Filter.snapshot`; without the monitoring of rejected fixes.
    #[pyo3(signature = (*, kind=0))]
    fn snapshot<'py>(&mut self, py: Python<'py>, kind: u32) -> PyResult<Bound<'py, PyBytes>> {
        each!(&mut self.running, |running| running.snapshot(kind)).map(|bytes| PyBytes::new(py, &bytes))
    }

    /// Restores a snapshot. The filter then continues as if uninterrupted.
    ///
    /// Raises SnapshotError if the bytes are no snapshot of such a filter. The filter is then unchanged.
    #[pyo3(signature = (snapshot, *, kind=0))]
    fn restore(&mut self, snapshot: &[u8], kind: u32) -> PyResult<()> {
        each!(&mut self.running, |running| running.restore(snapshot, kind))?;
        self.last = None;
        Ok(())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        self.made.written(py, "JointFilter")
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

impl JointFilter {
    fn take(
        &mut self,
        py: Python<'_>,
        detector: &Bound<'_, PyAny>,
        measurements: &Bound<'_, PyAny>,
        fixed: bool,
    ) -> PyResult<JointReport> {
        let Ok(detector) = detector.cast::<RangeBearing>() else {
            return Err(wrong_type("detector", "a RangeBearing", detector));
        };
        let sensor = &detector.get().0;
        let report = each!(&mut self.running, |running| match running.scan(py, sensor, measurements, fixed)? {
            Scanned::Joint(report) => JointReport::from(report),
            Scanned::Mixture(_) => return Err(SettingError::new_err("this is no joint map")),
        });
        self.last = Some(report);
        Ok(report)
    }
}

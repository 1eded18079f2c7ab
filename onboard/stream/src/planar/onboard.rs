//! The filter of a planar vehicle on board: that of `scphd-vehicle` in its memory.

use super::{Odometry, Planar};
use crate::Parameters;
use crate::black_box::{KIND, Saves, loaded, placed, unrestored};
use crate::head::Head;
use crate::onboard::{Filter, Refusal, Scan, Seen, lower, moved, zero};
use crate::record::{How, Measurements, Part, Place, Record};
use crate::snapshot::Snapshot;
use crate::writer::Writer;
use nalgebra::Vector2;
use scphd::diagnostics::Probe;
use scphd::models::PlanarPose;
use scphd::snapshot::{SaveError, SliceEnd};
use scphd::{Component, PoseEstimate, Real};
use scphd_vehicle::{self as vehicle, Backing, Description, Fixes, Recordable, Scanned, Start, StartError};

/// Maximum number of measurements of a scan.
pub const MEASUREMENTS: usize = 64;

/// The noise of the sensors.
#[cfg(not(feature = "same-noise"))]
pub(super) type Noise<T> = scphd::models::RangeNoise<T>;
#[cfg(feature = "same-noise")]
pub(super) type Noise<T> = vehicle::SameNoise<T>;

/// All memory of a filter: that of `scphd-vehicle`, a received scan, and an estimated or loaded map.
#[derive(Debug)]
pub struct Memory<B, T: Real, const FEATURES: usize> {
    backing: B,
    measurements: [Vector2<T>; MEASUREMENTS],
    features: [Component<Vector2<T>>; FEATURES],
}

impl<B, T: Real, const FEATURES: usize> Memory<B, T, FEATURES> {
    /// With this memory of the filter, and without data.
    pub(super) const fn with(backing: B) -> Self {
        Self { backing, measurements: [zero(); MEASUREMENTS], features: [Component::ZERO; FEATURES] }
    }

    /// Builds and starts the filter of a head, whose map has room for this number of features.
    pub(super) fn start<const BOX: bool>(
        &mut self,
        head: &impl Parameters<Planar>,
        room: usize,
    ) -> Result<OnBoard<'_, B::Slam<'_>, T, BOX>, Refusal>
    where
        B: Backing<T>,
    {
        let mut description = Description::robot();
        head.describe(&mut description)?;
        self.build(&description, room)
    }

    /// Not inlined, so that the decoded head is not on the stack beside its temporaries.
    #[inline(never)]
    fn build<const BOX: bool>(
        &mut self,
        description: &Description<T>,
        room: usize,
    ) -> Result<OnBoard<'_, B::Slam<'_>, T, BOX>, Refusal>
    where
        B: Backing<T>,
    {
        let Self { backing, measurements, features } = self;
        description.check_ranges()?;
        // The record of a fix has its own numbers.
        let mut started = backing.without_sensors(description, Fixes::NONE);
        if let Ok(slam) = &mut started {
            slam.add_sensors(description)?;
            vehicle::Slam::reset(slam, &description.start)?;
        }
        OnBoard::of(started, measurements, features, room)
    }
}

/// A filter of `scphd-vehicle` with memory for its inputs and outputs; with `BOX` it processes all records of a black box.
#[derive(Debug)]
pub struct OnBoard<'m, S, T: Real, const BOX: bool> {
    pub(super) slam: S,
    measurements: &'m mut [Vector2<T>],
    features: &'m mut [Component<Vector2<T>>],
    /// Capacity of a joint map for features.
    room: usize,
}

impl<'m, S: Recordable<T>, T: Real, const BOX: bool> OnBoard<'m, S, T, BOX> {
    /// Not inlined, so that the temporaries of the filter's start are not on the stack beside the copy.
    #[inline(never)]
    fn of(
        started: Result<S, StartError>,
        measurements: &'m mut [Vector2<T>],
        features: &'m mut [Component<Vector2<T>>],
        room: usize,
    ) -> Result<Self, Refusal> {
        Ok(Self { slam: started?, measurements, features, room })
    }

    #[inline(never)]
    fn taken(&mut self, record: &Record<'_, Planar>) -> Result<(), Refusal> {
        match record {
            Record::Fix(fix) => fix.get().ok_or(Refusal::NotAboard)?.shown(&mut self.slam),
            Record::Detector(which, models) => {
                let sensor = vehicle::Sensor::of_numbers(&models.get())?.ok_or(Refusal::NotAboard)?;
                Ok(self.slam.replace(usize::from(which.get()), &sensor)?)
            }
            Record::Place(place) => self.place(place),
            Record::Map(features) => {
                let count = loaded(features.clone(), self.features)?;
                self.slam.load_map(self.features.get(..count).unwrap_or(&[])).map_err(Refusal::Map)
            }
            Record::Head(head) => self.configured(head),
            Record::Predict(_) | Record::Scan(_) => Err(Refusal::NotAboard),
        }
    }

    #[inline(never)]
    fn configured(&mut self, head: &Head<'_, Planar>) -> Result<(), Refusal> {
        let mut description = Description::robot();
        head.describe(&mut description)?;
        Ok(self.slam.configure(&description)?)
    }

    #[inline(never)]
    fn restored(&mut self, snapshot: &Snapshot<'_, Planar>) -> Result<(), Refusal> {
        let mut source = snapshot.part(Part::Filter).ok_or(Refusal::NotAboard)?;
        let mut read = |at, into: &mut [u8]| source(at, into).map_err(|_| SliceEnd);
        self.slam.restore(snapshot.user_kind(Part::Filter), &mut read).map(drop).map_err(unrestored)
    }

    fn place(&mut self, place: &Place<'_, Planar>) -> Result<(), Refusal> {
        let (pose, covariance, seed): (PlanarPose<T>, _, _) = placed(place);
        let exact = Start { pose, position_sigma_m: T::ZERO, heading_sigma_rad: T::ZERO, seed };
        Ok(match place.how {
            How::Reset => self.slam.reset(&exact),
            How::ResetWithin => self.slam.reset_within(pose, &covariance, seed),
            How::Relocate => self.slam.relocate(pose, &covariance),
            How::Scatter => self.slam.scatter(&covariance),
        }?)
    }
}

impl<S: Recordable<T>, T: Real, const BOX: bool> Filter<Planar> for OnBoard<'_, S, T, BOX> {
    const BLACK_BOX: bool = BOX;

    fn predict(&mut self, odometry: &Odometry) -> Result<(), Refusal> {
        let (control, dt_s) = odometry.input();
        moved(self.slam.predict(control, dt_s))
    }

    fn receive(&mut self, measurements: Measurements<'_, Planar>) -> Scan {
        Scan::received(measurements, self.measurements)
    }

    fn scan_with(&mut self, scan: Scan, probe: &mut impl Probe) -> Result<Seen, Refusal> {
        let measurements = vehicle::Measurements::RangeBearing(scan.of(self.measurements)?);
        let scanned = match scan.localising {
            false => self.slam.scan_with(scan.detector, measurements, probe)?,
            true if BOX => self.slam.localise(scan.detector, measurements)?,
            true => return Err(Refusal::NotAboard),
        };
        Ok(match &scanned {
            Scanned::Mixture(report) => Seen::of(report),
            Scanned::Joint(report) => Seen::of_joint(report, self.slam.held(), self.room),
        })
    }

    fn take(&mut self, record: &Record<'_, Planar>) -> Result<(), Refusal> {
        if BOX { self.taken(record) } else { Err(Refusal::NotAboard) }
    }

    fn restore(&mut self, snapshot: &Snapshot<'_, Planar>) -> Result<(), Refusal> {
        if BOX { self.restored(snapshot) } else { Err(Refusal::NotAboard) }
    }

    fn estimate(&mut self) -> ([f64; 3], usize) {
        (self.estimate_pose().0, self.slam.count(self.features))
    }

    fn estimate_pose(&self) -> ([f64; 3], [f64; 6]) {
        let Some(PoseEstimate { mean, covariance }) = self.slam.pose() else { return ([0.0; 3], [0.0; 6]) };
        ([mean.x_m, mean.y_m, mean.heading_rad].map(T::to_f64), lower::<Planar, _>(covariance.as_lower()))
    }

    fn digest(&self) -> u64 {
        self.slam.digest()
    }
}

impl<S: Recordable<T>, T: Real> Saves<Planar> for OnBoard<'_, S, T, true> {
    fn save<E, F: FnMut(&[u8]) -> Result<(), E>>(&mut self, log: &mut Writer<Planar, F>) -> Result<(), SaveError<E>> {
        log.snapshot(&[Part::Filter], self.digest()).map_err(SaveError::Sink)?;
        let saved = log.save(Part::Filter, |sink| {
            let mut failed = None;
            let mut write = |piece: &[u8]| sink(piece).map_err(|error| failed.insert(error)).map_err(|_| SliceEnd);
            self.slam.save(KIND, &mut write).map_err(|error| match (failed, error) {
                (Some(error), _) => SaveError::Sink(error),
                (None, SaveError::Damaged(flaw)) => SaveError::Damaged(flaw),
                _ => SaveError::NotStarted,
            })
        });
        saved.map(drop)
    }
}

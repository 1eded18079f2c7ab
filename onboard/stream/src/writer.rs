//! Writes a stream, on a host or in flight.

use crate::bytes::Checked;
use crate::front::{Begins, Mark};
use crate::kind::{Input, Kind};
use crate::numbers::Numbers;
use crate::record::{DETECTOR, END, FIX, How, LOCALISING, MAP, PLACE, PREDICT, Part, Raw, Record, SCAN, SLICE, Which};
use crate::{Header, Scalar};
use scphd::models::{Pose, TangentOf};
use scphd::numerics::{Symmetric, Vector};
use scphd::snapshot::SaveError;
use scphd::{Component, Real};
use scphd_vehicle::numbers_of_sensor;

/// Number of bytes in a slice of a snapshot by [`Writer::save`].
const SLICE_BYTES: usize = 256;

/// Writes a stream in pieces to any sink of bytes: a file, a flash chip, a link.
///
/// ```
/// use scphd_stream::planar::{Odometry, Planar};
/// use scphd_stream::{Header, Reader, Record, Writer};
///
/// let mut log = Vec::new();
/// let head = Header::<Planar>::EMPTY;
/// let mut writer = Writer::start(&head, |bytes: &[u8]| Ok::<(), ()>(log.extend_from_slice(bytes)))?;
/// let moved = Odometry { control: [1.0, 0.1, 0.0], dt_s: 0.05 };
/// writer.predict(&moved)?;
/// writer.scan(&[[4.0, 0.5]])?;
/// writer.end()?;
/// let mut reader = Reader::<Planar>::open(&log).unwrap();
/// assert!(matches!(reader.read(), Ok(Some(Record::Predict(input))) if input == moved));
/// # Ok::<(), ()>(())
/// ```
///
/// A black box has snapshots among the records. It is a ring, or an area that may be full before the flight ends: its content can
/// be replayed from its first snapshot on.
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::models::{ControlNoise, PlanarPose, RangeBearing, RangeBearingWindow, Sensing};
/// use scphd::{Births, Detector, JointConfig, JointSlam};
/// use scphd::models::{Step, Unicycle, UnicycleControl, UniformClutter};
/// use scphd::snapshot::into_slice;
/// use scphd::joint_memory;
/// use scphd_stream::planar::{Odometry, Planar};
/// use scphd_stream::{Header, Part, Writer};
///
/// joint_memory! { type Memory: Unicycle<f32> { measurement: Vector2<f32>, features: 8, measurements: 16 } }
/// # let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02))?;
/// # let window = RangeBearingWindow::full_circle(15.0, 0.9)?;
/// # let clutter = UniformClutter::of_scan(0.1, window.measure())?;
/// # let sensing = Sensing { sensor: RangeBearing::new(0.1, 0.02)?, field_of_view: window, clutter };
/// # let lidar = Detector::new(sensing, Births::of_static(0.001))?;
/// # let mut state = Box::new(Memory::new());
/// let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state)?;
/// slam.reset(PlanarPose::new(0.0, 0.0, 0.0))?;
///
/// // The head describes how the filter was constructed; see the example of `scphd-stream`.
/// let head = Header::<Planar>::EMPTY;
/// let mut log = Vec::new();
/// let mut log = Writer::start(&head, |bytes: &[u8]| Ok::<(), &str>(log.extend_from_slice(bytes)))?;
/// let mut bytes = [0; 8192]; // a static: what the state takes at most
/// let mut saved = 0..0; // of it, what is still to be written
/// for scan in 0..60 {
///     let (speed_mps, rate_radps, dt) = (1.0, 0.1, 0.1);
///     log.predict(&Odometry { control: [speed_mps, rate_radps, 0.0].map(f64::from), dt_s: f64::from(dt) })?;
///     slam.predict(&UnicycleControl { speed_mps, rate_radps }, dt)?;
///     let seen = [Vector2::new(4.0, 0.5)];
///     log.scan(&[[4.0, 0.5]])?;
///     slam.scan(&lidar, &seen)?;
///     if scan % 50 == 0 {
///         // The state of this moment, into RAM; from there to the log a little after every scan.
///         saved = 0..slam.save(7, into_slice(&mut bytes))?;
///         log.snapshot(&[Part::Filter], slam.digest())?;
///     }
///     let now = saved.start..saved.end.min(saved.start + 512);
///     if !now.is_empty() {
///         log.slice(Part::Filter, &bytes[now.clone()])?;
///         saved.start = now.end;
///     }
/// }
/// assert!(saved.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Writer<K: Kind, F> {
    sink: F,
    /// The models and the tuning in force.
    header: Header<K>,
    /// Checksum of the last record or head.
    check: u32,
    scans: u32,
}

impl<K: Kind, E, F: FnMut(&[u8]) -> Result<(), E>> Writer<K, F> {
    /// Writes the head of a start.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn start(header: &Header<K>, mut sink: F) -> Result<Self, E> {
        let header = Header { begins: Begins::Start, ..*header };
        let check = header.write(0, &mut sink)?;
        Ok(Self { sink, header, check, scans: 0 })
    }

    /// Records a prediction.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn predict(&mut self, input: &K::Input) -> Result<(), E> {
        let scalar = K::Input::scalar(self.header.scalar);
        self.numbers([PREDICT, input.parts()], 1, scalar, |mut number| input.put(&mut number))
    }

    /// Records a scan of the first detector. Measurements beyond the 65535th are left out.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn scan(&mut self, measurements: &[K::Measurement]) -> Result<(), E> {
        self.scan_of(Which::FIRST, measurements)
    }

    /// Records a scan of a detector.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn scan_of(&mut self, which: Which<K>, measurements: &[K::Measurement]) -> Result<(), E> {
        self.measured(which.get(), measurements)
    }

    /// Records a scan of a detector that updates the pose only.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn localise(&mut self, which: Which<K>, measurements: &[K::Measurement]) -> Result<(), E> {
        self.measured(which.get() | LOCALISING, measurements)
    }

    fn measured(&mut self, parts: u8, measurements: &[K::Measurement]) -> Result<(), E> {
        let count = u16::try_from(measurements.len()).unwrap_or(u16::MAX);
        let kept = measurements.iter().take(usize::from(count));
        self.scans = self.scans.saturating_add(1);
        self.numbers([SCAN, parts], count, self.header.scalar, |mut number| {
            kept.for_each(|measurement| measurement.put(&mut number));
        })
    }

    /// Records a measurement of the pose.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn fix(&mut self, fix: &K::Fix) -> Result<(), E> {
        self.numbers([FIX, fix.parts()], 1, Scalar::F64, |mut number| fix.put(&mut number))
    }

    /// Records that a detector was added, or its models were changed, after the filter has accepted it: the head of the next snapshot
    /// has these models.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn detector(&mut self, which: Which<K>, models: &K::Sensor) -> Result<(), E> {
        let slots = self.header.settings.get_mut(numbers_of_sensor(usize::from(which.get()))).unwrap_or_default();
        let mut slots = slots.iter_mut();
        models.put(&mut |number| slots.next().into_iter().for_each(|slot| *slot = number));
        self.numbers([DETECTOR, which.get()], 1, Scalar::F64, |mut number| models.put(&mut number))
    }

    /// Records a change of the models or the tuning to those of this head, after the filter has accepted it. Its initial pose, seed and number type are not used.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn retune(&mut self, header: &Header<K>) -> Result<(), E> {
        self.header = Header { begins: Begins::Retuned, scalar: self.header.scalar, ..*header };
        self.head()
    }

    /// Records that the pose is set from outside. [`How::Scatter`] does not use the pose, [`How::Reset`] not the covariance, and
    /// only the two resets use the seed: arguments that are not used may have any value.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn place<T: Real, P: Pose<Scalar = T>>(
        &mut self,
        how: How,
        pose: &P,
        covariance: &Symmetric<TangentOf<P>>,
        seed: u64,
    ) -> Result<(), E> {
        let (mut full, mut lower) = (K::Full::ZERO, K::Covariance::ZERO);
        let mut slots = full.as_mut().iter_mut();
        pose.to_numbers(|number| slots.next().into_iter().for_each(|slot| *slot = number.to_f64()));
        for (slot, number) in lower.as_mut().iter_mut().zip(covariance.as_lower()) {
            *slot = number.to_f64();
        }
        let mut record = self.record([PLACE, how as u8], 1);
        full.put(&mut |number| record.put(&number.to_le_bytes()));
        lower.put(&mut |number| record.put(&number.to_le_bytes()));
        record.put(&seed.to_le_bytes());
        self.check = record.end()?;
        Ok(())
    }

    /// Records that a map is loaded. Features beyond the 65535th are left out.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn map<T: Real, D: Vector<Scalar = T>>(&mut self, features: &[Component<D>]) -> Result<(), E> {
        const { assert!(2 + D::DIMENSION + D::DIMENSION * (D::DIMENSION + 1) / 2 == K::Feature::COUNT) };
        let count = u16::try_from(features.len()).unwrap_or(u16::MAX);
        self.numbers([MAP, 0], count, Scalar::F64, |number| {
            for Component { label, ln_weight, mean, covariance } in features.iter().take(usize::from(count)) {
                number(f64::from(*label));
                number(ln_weight.to_f64());
                mean.as_slice().iter().chain(covariance.as_lower()).for_each(|x| number(x.to_f64()));
            }
        })
    }

    /// Begins a snapshot of the state after the last record, at which a replay may begin. `digest` is that of the filter. Its
    /// bytes follow, at once by [`save`](Self::save) or in slices with other records between them. Readers skip an incomplete
    /// snapshot.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn snapshot(&mut self, parts: &[Part], digest: u64) -> Result<(), E> {
        let parts = parts.iter().fold(0, |bits, part| bits | part.bit());
        self.header.begins = Begins::Snapshot(Mark { scans: self.scans, parts, digest });
        self.head()
    }

    /// Records the next bytes of a part of the last snapshot, at most 65535.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn slice(&mut self, part: Part, bytes: &[u8]) -> Result<(), E> {
        let count = u16::try_from(bytes.len()).unwrap_or(u16::MAX);
        self.whole([SLICE, part.code()], count, bytes.get(..usize::from(count)).unwrap_or(bytes))
    }

    /// Records a part of a snapshot while it is saved, in slices of 256 bytes.
    ///
    /// ```no_run
    /// # fn example<K: scphd_stream::Kind, M: scphd::models::Motion<Pose: scphd::models::Pose<Scalar = f32>>>(
    /// #     log: &mut scphd_stream::Writer<K, impl FnMut(&[u8]) -> Result<(), ()>>,
    /// #     slam: &mut scphd::ScPhd<'_, M>,
    /// # ) -> Result<(), scphd::snapshot::SaveError<()>> {
    /// # use scphd_stream::Part;
    /// # const KIND: u32 = 7;
    /// log.save(Part::Filter, |sink| slam.save(KIND, sink))?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// The error of the sink, or of the function that saves.
    pub fn save(
        &mut self,
        part: Part,
        save: impl FnOnce(&mut dyn FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>>,
    ) -> Result<usize, SaveError<E>> {
        let (mut buffer, mut len) = ([0; SLICE_BYTES], 0);
        let saved = save(&mut |piece| {
            for &byte in piece {
                if len == SLICE_BYTES {
                    self.slice(part, &buffer)?;
                    len = 0;
                }
                if let Some(slot) = buffer.get_mut(len) {
                    *slot = byte;
                    len += 1;
                }
            }
            Ok(())
        })?;
        self.slice(part, buffer.get(..len).unwrap_or(&buffer)).map_err(SaveError::Sink)?;
        Ok(saved)
    }

    /// Marks the end; without it readers report a truncated stream.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn end(mut self) -> Result<(), E> {
        self.numbers([END, 0], 0, self.header.scalar, |_| ())
    }

    /// Records again a record that was read from another stream, except snapshots.
    pub(crate) fn again(&mut self, raw: &Raw<'_, K>, record: &Record<'_, K>) -> Result<(), E> {
        match (raw, record) {
            (Raw::Head(head), _) => {
                if head.mark().is_none() {
                    self.retune(&head.decode())
                } else {
                    Ok(())
                }
            }
            (_, Record::Detector(which, models)) => self.detector(*which, &models.get()),
            (&Raw::Record { kind, parts, count, payload }, _) => {
                self.scans = self.scans.saturating_add(u32::from(kind == SCAN));
                self.whole([kind, parts], count, payload)
            }
        }
    }

    /// Writes a head with the models and the tuning in force.
    fn head(&mut self) -> Result<(), E> {
        self.check = self.header.write(self.check, &mut self.sink)?;
        Ok(())
    }

    fn record(&mut self, kind: [u8; 2], count: u16) -> Checked<&mut F, E> {
        let mut record = Checked::behind(self.check, &mut self.sink);
        record.put(&kind);
        record.put(&count.to_le_bytes());
        record
    }

    fn whole(&mut self, kind: [u8; 2], count: u16, payload: &[u8]) -> Result<(), E> {
        let mut record = self.record(kind, count);
        record.put(payload);
        self.check = record.end()?;
        Ok(())
    }

    fn numbers(
        &mut self,
        kind: [u8; 2],
        count: u16,
        scalar: Scalar,
        numbers: impl FnOnce(&mut dyn FnMut(f64)),
    ) -> Result<(), E> {
        let mut record = self.record(kind, count);
        numbers(&mut |number| match scalar {
            Scalar::F32 => record.put(&(number as f32).to_le_bytes()),
            Scalar::F64 => record.put(&number.to_le_bytes()),
        });
        self.check = record.end()?;
        Ok(())
    }
}

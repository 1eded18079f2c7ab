//! Simulates a vehicle's instruments from a stream: what they deliver, and when. Each task reads its own records of the stream.

use crate::timer::TICKS_PER_S;
use scphd_stream::planar::{Odometry, Planar};
use scphd_stream::{Measurements, Reader, Record};

/// Factor by which the vehicle is faster than in the stream. In QEMU an instruction takes 1 ns; a processor that needs 10 ns for
/// an instruction has the same load at the speed of the stream.
const HASTE: u64 = if cfg!(feature = "too-fast") { 200 } else { 10 };

/// Delay from the measurement of a scan to its arrival, ns.
pub const SCAN_DELAY_NS: u64 = 30_000_000;

/// An odometry sample: a control that is valid from its stamp to that of the next sample.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Time of measurement and of arrival, ns.
    pub stamp_ns: u64,
    /// The control.
    pub odometry: Odometry,
}

/// A scan, measured at its stamp.
#[derive(Debug, Clone)]
pub struct Scan {
    /// Time of measurement, ns.
    pub stamp_ns: u64,
    /// Time of arrival, ns.
    pub arrived_ns: u64,
    /// The measurements remain in the stream's memory; a driver would hand over its buffer.
    pub measurements: Measurements<'static, Planar>,
}

/// Time for which an odometry sample is valid, ns.
fn ns(odometry: &Odometry) -> u64 {
    (odometry.dt_s * 1e9 + 0.5) as u64
}

/// Least number of ticks, so that a timer does not expire again while its interrupt sets it.
const SOON: u32 = 250;

/// Converts a time of the stream to ticks of a timer.
fn ticks(ns: u64) -> u32 {
    const TICK_NS: u64 = HASTE * 1_000_000_000 / TICKS_PER_S;
    u32::try_from(ns / TICK_NS).unwrap_or(u32::MAX).max(SOON)
}

/// The wheel odometry.
#[derive(Debug)]
pub struct Wheels {
    source: Reader<'static, Planar>,
    next: Option<Sample>,
    /// Time from the previous sample to the next one, ns.
    wait_ns: u64,
}

impl Wheels {
    /// Starts before the first sample of a stream.
    pub fn of(source: Reader<'static, Planar>) -> Self {
        let mut wheels = Self { source, next: None, wait_ns: 0 };
        wheels.next = wheels.read(0);
        wheels
    }

    fn read(&mut self, stamp_ns: u64) -> Option<Sample> {
        loop {
            match self.source.read() {
                Ok(Some(Record::Predict(odometry))) => return Some(Sample { stamp_ns, odometry }),
                // Other records are not odometry.
                Ok(Some(_)) => (),
                Ok(None) | Err(_) => return None,
            }
        }
    }

    /// Ticks from the last sample to the next one; `None` after the last one.
    pub fn due(&self) -> Option<u32> {
        self.next.map(|_| ticks(self.wait_ns))
    }

    /// Takes the present sample.
    pub fn sample(&mut self) -> Option<Sample> {
        let sample = self.next?;
        self.wait_ns = ns(&sample.odometry);
        self.next = self.read(sample.stamp_ns + self.wait_ns);
        Some(sample)
    }
}

/// The sensor.
#[derive(Debug)]
pub struct Sensor {
    source: Reader<'static, Planar>,
    next: Option<Scan>,
    /// Time of the reader's position in the stream, ns.
    time_ns: u64,
    /// Time of arrival of the last scan, ns.
    now_ns: u64,
}

impl Sensor {
    /// Starts before the first scan of a stream.
    pub fn of(source: Reader<'static, Planar>) -> Self {
        let mut sensor = Self { source, next: None, time_ns: 0, now_ns: 0 };
        sensor.next = sensor.read();
        sensor
    }

    fn read(&mut self) -> Option<Scan> {
        loop {
            match self.source.read() {
                Ok(Some(Record::Predict(odometry))) => self.time_ns += ns(&odometry),
                Ok(Some(Record::Scan(measurements))) => {
                    let (stamp_ns, arrived_ns) = (self.time_ns, self.time_ns + SCAN_DELAY_NS);
                    return Some(Scan { stamp_ns, arrived_ns, measurements });
                }
                Ok(Some(_)) => (),
                Ok(None) | Err(_) => return None,
            }
        }
    }

    /// Ticks from the arrival of the last scan to that of the next one; `None` after the last one.
    pub fn due(&self) -> Option<u32> {
        self.next.as_ref().map(|scan| ticks(scan.arrived_ns - self.now_ns))
    }

    /// Takes the scan that arrives now.
    pub fn scan(&mut self) -> Option<Scan> {
        let scan = self.next.take()?;
        self.now_ns = scan.arrived_ns;
        self.next = self.read();
        Some(scan)
    }
}

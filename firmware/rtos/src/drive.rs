//! What the instruments of a vehicle deliver, and when: a stream stands for them. Each task reads its own records of it, and
//! knows nothing of the other's.

use crate::timer::TICKS_PER_S;
use scphd_stream::planar::{Odometry, Planar};
use scphd_stream::{Measurements, Reader, Record};

/// So many times as fast as in the stream does the vehicle drive. To QEMU an instruction is a nanosecond; a processor that needs
/// 10 ns for each would be as busy with the vehicle at its own speed.
const HASTE: u64 = if cfg!(feature = "too-fast") { 200 } else { 10 };

/// How long after its measurement a scan arrives, ns.
pub const SCAN_DELAY_NS: u64 = 30_000_000;

/// An odometry sample: a control that is in force from its stamp on, until the next one.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// When it was measured, and arrived, ns.
    pub stamp_ns: u64,
    /// What it says.
    pub odometry: Odometry,
}

/// A scan, measured at its stamp.
#[derive(Debug, Clone)]
pub struct Scan {
    /// When it was measured, ns.
    pub stamp_ns: u64,
    /// When it arrived, ns.
    pub arrived_ns: u64,
    /// The measurements stay where they arrived; a driver would hand over its buffer.
    pub measurements: Measurements<'static, Planar>,
}

/// How long an odometry sample is in force, ns.
fn ns(odometry: &Odometry) -> u64 {
    (odometry.dt_s * 1e9 + 0.5) as u64
}

/// Ticks until what is due at once: a timer must not come to zero again while its interrupt is told what to wait for.
const SOON: u32 = 250;

/// So long a time in ticks of a timer, on the vehicle in its haste.
fn ticks(ns: u64) -> u32 {
    const TICK_NS: u64 = HASTE * 1_000_000_000 / TICKS_PER_S;
    u32::try_from(ns / TICK_NS).unwrap_or(u32::MAX).max(SOON)
}

/// The wheels.
#[derive(Debug)]
pub struct Wheels {
    source: Reader<'static, Planar>,
    next: Option<Sample>,
    /// From the sample before to the next one.
    wait_ns: u64,
}

impl Wheels {
    /// Before the first sample of a stream.
    #[must_use]
    pub fn of(source: Reader<'static, Planar>) -> Self {
        let mut wheels = Self { source, next: None, wait_ns: 0 };
        wheels.next = wheels.read(0);
        wheels
    }

    fn read(&mut self, stamp_ns: u64) -> Option<Sample> {
        loop {
            match self.source.read() {
                Ok(Some(Record::Predict(odometry))) => return Some(Sample { stamp_ns, odometry }),
                // Of other records the wheels know nothing.
                Ok(Some(_)) => (),
                Ok(None) | Err(_) => return None,
            }
        }
    }

    /// Ticks from the last sample to the next; none after the last.
    #[must_use]
    pub fn due(&self) -> Option<u32> {
        self.next.map(|_| ticks(self.wait_ns))
    }

    /// The sample of now.
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
    /// The time that the reader has come to.
    time_ns: u64,
    /// When the last scan arrived.
    now_ns: u64,
}

impl Sensor {
    /// Before the first scan of a stream.
    #[must_use]
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

    /// Ticks from the last scan's arrival to the next one's; none after the last.
    #[must_use]
    pub fn due(&self) -> Option<u32> {
        self.next.as_ref().map(|scan| ticks(scan.arrived_ns - self.now_ns))
    }

    /// The scan that arrives now.
    pub fn scan(&mut self) -> Option<Scan> {
        let scan = self.next.take()?;
        self.now_ns = scan.arrived_ns;
        self.next = self.read();
        Some(scan)
    }
}

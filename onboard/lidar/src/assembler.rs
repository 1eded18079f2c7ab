//! Packets to revolutions.

use crate::packet::{FULL_CIRCLE, Packet, Point};
use crate::scan::{Beam, MISSING_STEPS, Scan};
use heapless::Vec;

/// One turn of the lidar: its points in the order of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Revolution<const POINTS: usize> {
    /// The points, clockwise from the seam on.
    pub points: Vec<Point, POINTS>,
    /// Points that there was no room for: those at the end.
    pub beyond: u32,
    /// How fast it turned, degrees/s, by the last packet.
    pub speed_degps: u16,
    /// From a point to the next, hundredths of a degree, the mean of its packets.
    pub step_cdeg: f32,
    /// How much of the circle was not received, hundredths of a degree.
    pub missing_cdeg: u32,
    /// Clock of the lidar when it ended, to within a packet, ms; after 30 000 it begins at 0.
    pub time_ms: u16,
}

impl<const POINTS: usize> Revolution<POINTS> {
    const EMPTY: Self =
        Self { points: Vec::new(), beyond: 0, speed_degps: 0, step_cdeg: 0.0, missing_cdeg: 0, time_ms: 0 };

    fn angle_cdeg(&self, number: usize) -> u16 {
        self.points.get(number).map_or(0, |point| point.angle_cdeg)
    }
}

/// The view has its ends at the seam: what is on both sides of it was seen a revolution apart.
impl<const POINTS: usize> Scan for Revolution<POINTS> {
    fn beams(&self) -> usize {
        self.points.len()
    }

    fn beam(&self, number: usize) -> Option<Beam> {
        let Point { angle_cdeg, reading } = *self.points.get(number)?;
        Some(Beam {
            bearing_rad: -radians(f32::from(angle_cdeg)),
            range_m: f32::from(reading.range_mm) * 1e-3,
            intensity: f32::from(reading.intensity),
        })
    }

    fn step_rad(&self) -> f32 {
        -radians(self.step_cdeg)
    }

    fn between_rad(&self, from: usize, to: usize) -> f32 {
        radians(clockwise(self.angle_cdeg(from), self.angle_cdeg(to)) as f32)
    }

    fn before_end_s(&self, number: usize) -> f32 {
        let end = self.points.len().saturating_sub(1);
        let left_cdeg = clockwise(self.angle_cdeg(number), self.angle_cdeg(end));
        if self.speed_degps > 0 { left_cdeg as f32 / (100.0 * f32::from(self.speed_degps)) } else { 0.0 }
    }
}

fn radians(cdeg: f32) -> f32 {
    cdeg * (core::f32::consts::PI / 18_000.0)
}

/// From one angle on to another, hundredths of a degree.
fn clockwise(from: u16, to: u16) -> u32 {
    (u32::from(to) + FULL_CIRCLE - u32::from(from) % FULL_CIRCLE) % FULL_CIRCLE
}

/// Makes revolutions of packets. What stands across the seam, where one ends and the next begins, is not found: the two halves were
/// seen a revolution apart.
#[derive(Debug)]
pub struct Assembler<const POINTS: usize> {
    /// Where a revolution begins.
    seam_cdeg: u16,
    revolution: Revolution<POINTS>,
    /// Of the packet in which a revolution ended, what belongs to the next.
    carried: Vec<Point, { Packet::POINTS }>,
    /// Whether the revolution has been handed out.
    is_done: bool,
    /// Whether the revolution began at the seam: the first one does not.
    is_whole: bool,
    /// The last point, by its angle from the seam.
    last: Option<u32>,
    packets: u32,
}

impl<const POINTS: usize> Assembler<POINTS> {
    /// An assembler whose revolutions begin behind, opposite of the arrow. An LD06 at 10 Hz has 450 points in a revolution, at 5 Hz 900.
    #[must_use]
    pub const fn new() -> Self {
        Self::with_seam(18_000)
    }

    /// An assembler whose revolutions begin at this angle, hundredths of a degree clockwise from the arrow: where nothing is to be seen.
    #[must_use]
    pub const fn with_seam(seam_cdeg: u16) -> Self {
        Self {
            seam_cdeg: (seam_cdeg as u32 % FULL_CIRCLE) as u16,
            revolution: Revolution::EMPTY,
            carried: Vec::new(),
            is_done: false,
            is_whole: false,
            last: None,
            packets: 0,
        }
    }

    /// Takes a packet; the revolution that it ends, if it does. The one in which the assembler was started is not whole, and is left out.
    pub fn push(&mut self, packet: &Packet) -> Option<&Revolution<POINTS>> {
        if self.is_done {
            self.begin();
        }
        let revolution = &mut self.revolution;
        // A motor that is held fast ends no revolution.
        self.packets = self.packets.saturating_add(1);
        revolution.step_cdeg += (packet.step_cdeg() - revolution.step_cdeg) / self.packets as f32;
        let mut ended = false;
        for point in packet.points() {
            let from_seam = clockwise(self.seam_cdeg, point.angle_cdeg);
            // Angles that go back by less than half a circle are of a motor that is held fast.
            if self.last.is_some_and(|last| last > from_seam && last - from_seam > FULL_CIRCLE / 2) && !ended {
                ended = true;
                revolution.missing_cdeg =
                    revolution.missing_cdeg.saturating_add(missing(self.last, FULL_CIRCLE, revolution.step_cdeg));
                self.last = Some(0);
            }
            if ended {
                // There are as many as a packet has.
                let _always = self.carried.push(point);
                continue;
            }
            revolution.missing_cdeg =
                revolution.missing_cdeg.saturating_add(missing(self.last, from_seam, revolution.step_cdeg));
            self.last = Some(from_seam);
            if revolution.points.push(point).is_err() {
                revolution.beyond = revolution.beyond.saturating_add(1);
            }
        }
        revolution.speed_degps = packet.speed_degps;
        revolution.time_ms = packet.time_ms;
        if !ended {
            return None;
        }
        self.is_done = true;
        core::mem::replace(&mut self.is_whole, true).then_some(&self.revolution)
    }

    /// A new revolution begins with what was carried over.
    fn begin(&mut self) {
        self.is_done = false;
        self.packets = 0;
        let step_cdeg = self.revolution.step_cdeg;
        let Revolution { points, beyond, missing_cdeg, .. } = &mut self.revolution;
        points.clear();
        (*beyond, *missing_cdeg) = (0, 0);
        for &point in &self.carried {
            let from_seam = clockwise(self.seam_cdeg, point.angle_cdeg);
            *missing_cdeg += missing(self.last, from_seam, step_cdeg);
            self.last = Some(from_seam);
            if points.push(point).is_err() {
                *beyond += 1;
            }
        }
        self.carried.clear();
    }
}

impl<const POINTS: usize> Default for Assembler<POINTS> {
    fn default() -> Self {
        Self::new()
    }
}

/// What was not received between two angles from the seam, hundredths of a degree.
fn missing(last: Option<u32>, next: u32, step_cdeg: f32) -> u32 {
    let gap = next.saturating_sub(last.unwrap_or(0));
    if gap as f32 > MISSING_STEPS * step_cdeg { gap } else { 0 }
}

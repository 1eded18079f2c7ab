//! Assembles packets to revolutions.

use crate::packet::{FULL_CIRCLE, Packet, Point};
use crate::scan::{Beam, MISSING_STEPS, Scan};
use heapless::Vec;

/// One revolution of the lidar: its points in the order of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Revolution<const POINTS: usize> {
    /// The points, clockwise from the seam.
    pub points: Vec<Point, POINTS>,
    /// Number of points at the end that were left out for lack of room.
    pub beyond: u32,
    /// Rotation speed of the last packet, degrees/s.
    pub speed_degps: u16,
    /// Mean step between points over its packets, hundredths of a degree.
    pub step_cdeg: f32,
    /// The part of the circle that was not received, hundredths of a degree.
    pub missing_cdeg: u32,
    /// Time of the lidar's clock at the end, within the duration of a packet, ms; it wraps at 30 000.
    pub time_ms: u16,
}

impl<const POINTS: usize> Revolution<POINTS> {
    const EMPTY: Self =
        Self { points: Vec::new(), beyond: 0, speed_degps: 0, step_cdeg: 0.0, missing_cdeg: 0, time_ms: 0 };

    fn angle_cdeg(&self, number: usize) -> u16 {
        self.points.get(number).map_or(0, |point| point.angle_cdeg)
    }
}

/// The view ends at the seam, because the beams on both sides of it were measured a revolution apart.
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

/// Clockwise angle from one direction to another, hundredths of a degree.
fn clockwise(from: u16, to: u16) -> u32 {
    (u32::from(to) + FULL_CIRCLE - u32::from(from) % FULL_CIRCLE) % FULL_CIRCLE
}

/// Assembles packets to revolutions. A post across the seam, where revolutions begin and end, is not found: its halves were
/// measured a revolution apart.
#[derive(Debug)]
pub struct Assembler<const POINTS: usize> {
    /// The angle at which revolutions begin.
    seam_cdeg: u16,
    revolution: Revolution<POINTS>,
    /// Points of the last packet that belong to the next revolution.
    carried: Vec<Point, { Packet::POINTS }>,
    /// Whether the revolution is complete and was returned.
    is_done: bool,
    /// Whether the revolution began at the seam; the first one does not.
    is_whole: bool,
    /// Angle of the last point from the seam.
    last: Option<u32>,
    packets: u32,
}

impl<const POINTS: usize> Assembler<POINTS> {
    /// An assembler whose revolutions begin at the rear, opposite to the arrow. An LD06 has 450 points in a revolution at 10 Hz,
    /// 900 at 5 Hz.
    pub const fn new() -> Self {
        Self::with_seam(18_000)
    }

    /// An assembler whose revolutions begin at this angle, hundredths of a degree clockwise from the arrow. Choose a direction
    /// without posts.
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

    /// Adds a packet. Returns the revolution that it completes, if any. The first, incomplete revolution is left out.
    pub fn push(&mut self, packet: &Packet) -> Option<&Revolution<POINTS>> {
        if self.is_done {
            self.begin();
        }
        let revolution = &mut self.revolution;
        // A blocked motor completes no revolution.
        self.packets = self.packets.saturating_add(1);
        revolution.step_cdeg += (packet.step_cdeg() - revolution.step_cdeg) / self.packets as f32;
        let mut ended = false;
        for point in packet.points() {
            let from_seam = clockwise(self.seam_cdeg, point.angle_cdeg);
            // Angles that decrease by less than half a circle come from a blocked motor.
            if self.last.is_some_and(|last| last > from_seam && last - from_seam > FULL_CIRCLE / 2) && !ended {
                ended = true;
                revolution.missing_cdeg =
                    revolution.missing_cdeg.saturating_add(missing(self.last, FULL_CIRCLE, revolution.step_cdeg));
                self.last = Some(0);
            }
            if ended {
                // The capacity is that of a packet.
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

    /// Begins a new revolution with the carried points.
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

/// The angle between two points that was not received, hundredths of a degree from the seam.
fn missing(last: Option<u32>, next: u32, step_cdeg: f32) -> u32 {
    let gap = next.saturating_sub(last.unwrap_or(0));
    if gap as f32 > MISSING_STEPS * step_cdeg { gap } else { 0 }
}

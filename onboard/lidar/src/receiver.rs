//! Finds packets in a stream of bytes.

use crate::packet::{HEADER, Packet, PacketError};
use embedded_io::Read;

/// Counts of a receiver. Every byte belongs to a packet, was skipped, or waits for the rest of its packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ReceiverReport {
    /// Number of complete packets.
    pub packets: u32,
    /// Number of packets with a wrong checksum: damaged, or other bytes that begin like a packet.
    pub damaged: u32,
    /// Number of packets with a correct checksum and angles that the lidar does not send: another model.
    pub unlikely: u32,
    /// Number of bytes that belong to no packet.
    pub skipped: u32,
}

/// Finds packets. After damage it continues at the next byte that may begin a packet, which may be in the damaged one.
#[derive(Debug)]
pub struct Receiver {
    held: [u8; Packet::LENGTH],
    len: usize,
    report: ReceiverReport,
}

impl Receiver {
    /// A receiver without any bytes.
    pub const fn new() -> Self {
        Self {
            held: [0; Packet::LENGTH],
            len: 0,
            report: ReceiverReport { packets: 0, damaged: 0, unlikely: 0, skipped: 0 },
        }
    }

    /// Adds a byte. Returns the packet that it completes, if any.
    pub fn push(&mut self, byte: u8) -> Option<Packet> {
        if let Some(slot) = self.held.get_mut(self.len) {
            *slot = byte;
            self.len += 1;
        }
        if self.len < Packet::LENGTH {
            if !self.may_begin(0) {
                self.skip();
            }
            return None;
        }
        match Packet::parse(&self.held) {
            Ok(packet) => {
                self.len = 0;
                count(&mut self.report.packets, 1);
                Some(packet)
            }
            Err(error) => {
                match error {
                    PacketError::Angles => count(&mut self.report.unlikely, 1),
                    PacketError::Header | PacketError::Check => count(&mut self.report.damaged, 1),
                }
                self.skip();
                None
            }
        }
    }

    /// Whether a packet may begin at this index of the stored bytes.
    fn may_begin(&self, at: usize) -> bool {
        let held = self.held.get(at..self.len).unwrap_or(&[]);
        held.iter().zip(&HEADER).all(|(byte, mark)| byte == mark)
    }

    /// Removes the first byte, and the following ones up to the next that may begin a packet.
    fn skip(&mut self) {
        let begin = (1..self.len).find(|&at| self.may_begin(at)).unwrap_or(self.len);
        if let Some(held) = self.held.get_mut(..self.len) {
            held.copy_within(begin.min(held.len()).., 0);
        }
        self.len = self.len.saturating_sub(begin);
        count(&mut self.report.skipped, begin as u32);
    }

    /// Reads from a line until a packet is complete; `None` if the line ends.
    ///
    /// # Errors
    /// The errors of the line. The bytes of an incomplete packet are kept.
    pub fn read<L: Read>(&mut self, line: &mut L) -> Result<Option<Packet>, L::Error> {
        loop {
            // At most the rest of the packet is read, so that no other bytes must be stored.
            let mut bytes = [0; Packet::LENGTH];
            let wanted = bytes.get_mut(self.len..).unwrap_or_default();
            let count = line.read(wanted)?;
            if count == 0 {
                return Ok(None);
            }
            let mut whole = None;
            for &byte in wanted.iter().take(count) {
                // Only the last byte can complete a packet.
                whole = self.push(byte).or(whole);
            }
            if whole.is_some() {
                return Ok(whole);
            }
        }
    }

    /// The counts so far.
    pub fn report(&self) -> ReceiverReport {
        self.report
    }

    /// Number of bytes that wait for the rest of their packet.
    pub fn waiting(&self) -> usize {
        self.len
    }
}

impl Default for Receiver {
    fn default() -> Self {
        Self::new()
    }
}

fn count(counter: &mut u32, by: u32) {
    *counter = counter.saturating_add(by);
}

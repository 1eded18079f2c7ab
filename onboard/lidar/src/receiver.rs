//! Finds packets in bytes as they come.

use crate::packet::{HEADER, Packet, PacketError};
use embedded_io::Read;

/// What has come so far. Every byte is of a packet, or skipped, or still waits for the rest of its packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ReceiverReport {
    /// Whole packets.
    pub packets: u32,
    /// Packets whose check was wrong: damaged on the line, or no packets at all but bytes that began like one.
    pub damaged: u32,
    /// Packets with the right check and angles that the lidar does not send: another model.
    pub unlikely: u32,
    /// Bytes that belong to no whole packet.
    pub skipped: u32,
}

/// Finds packets. After damage it goes on with the next place at which a packet may begin, which may lie in the damaged one.
#[derive(Debug)]
pub struct Receiver {
    held: [u8; Packet::LENGTH],
    len: usize,
    report: ReceiverReport,
}

impl Receiver {
    /// A receiver that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            held: [0; Packet::LENGTH],
            len: 0,
            report: ReceiverReport { packets: 0, damaged: 0, unlikely: 0, skipped: 0 },
        }
    }

    /// Takes a byte; the packet that it ends, if it does.
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

    /// Whether a packet may begin at this place of what is held.
    fn may_begin(&self, at: usize) -> bool {
        let held = self.held.get(at..self.len).unwrap_or(&[]);
        held.iter().zip(&HEADER).all(|(byte, mark)| byte == mark)
    }

    /// Leaves out the first byte, and what follows up to where a packet may begin.
    fn skip(&mut self) {
        let begin = (1..self.len).find(|&at| self.may_begin(at)).unwrap_or(self.len);
        if let Some(held) = self.held.get_mut(..self.len) {
            held.copy_within(begin.min(held.len()).., 0);
        }
        self.len = self.len.saturating_sub(begin);
        count(&mut self.report.skipped, begin as u32);
    }

    /// Reads from a line until a packet is whole; `None` where the line ends.
    ///
    /// # Errors
    /// Those of the line. What has been read of a packet is kept.
    pub fn read<L: Read>(&mut self, line: &mut L) -> Result<Option<Packet>, L::Error> {
        loop {
            // No more than the packet can still have: nothing is read that would have to be kept.
            let mut bytes = [0; Packet::LENGTH];
            let wanted = bytes.get_mut(self.len..).unwrap_or_default();
            let count = line.read(wanted)?;
            if count == 0 {
                return Ok(None);
            }
            let mut whole = None;
            for &byte in wanted.iter().take(count) {
                // Only the last of them can end one.
                whole = self.push(byte).or(whole);
            }
            if whole.is_some() {
                return Ok(whole);
            }
        }
    }

    /// What has come so far.
    #[must_use]
    pub fn report(&self) -> ReceiverReport {
        self.report
    }

    /// Bytes that wait for the rest of their packet.
    #[must_use]
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

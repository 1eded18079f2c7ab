//! Buffers, as on a device; and races: two threads of a launch that use the same byte, where one of them writes it.

use crate::errors::Fault;

/// log₂ of the distance between the addresses of two buffers. The first range of addresses has no buffer.
const SPACING: u32 = 40;
/// First address of a thread's own memory, its stack.
pub(crate) const LOCAL: u64 = 0xffff << SPACING;

/// The address space that an instruction names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Space {
    Any,
    Global,
    Local,
}

/// How an instruction uses bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Use {
    Read,
    Write,
    /// In one step, which several threads may do.
    Change,
}

#[derive(Debug, Clone)]
struct Buffer {
    bytes: Vec<u8>,
    touched: Option<Touched>,
}

/// All buffers. An address is a number, as on a device.
#[derive(Debug, Clone, Default)]
pub struct Memory {
    buffers: Vec<Buffer>,
    watched: bool,
    launches: u32,
}

impl Memory {
    /// From now on, it is an error if two threads of a launch use the same byte of a buffer made later and one of them writes it.
    /// This takes 16 more bytes for each byte.
    pub fn watch(&mut self) {
        self.watched = true;
    }

    /// Makes a buffer with these bytes. Returns its address.
    pub fn allocate(&mut self, bytes: Vec<u8>) -> u64 {
        let touched = self.watched.then(|| Touched::new(bytes.len()));
        self.buffers.push(Buffer { bytes, touched });
        (self.buffers.len() as u64) << SPACING
    }

    /// All bytes of the buffer at this address; none if there is no such buffer.
    pub fn bytes(&self, address: u64) -> &[u8] {
        self.buffers.get(buffer_of(address)).map_or(&[], |buffer| &buffer.bytes)
    }

    pub(crate) fn begin_launch(&mut self) {
        self.launches += 1;
    }

    /// The bytes at an address, for a thread.
    pub(crate) fn at(&mut self, address: u64, bytes: usize, used: Use, thread: u32) -> Result<&mut [u8], Fault> {
        let who = Who { launch: self.launches, thread };
        let Buffer { bytes: all, touched } = self.buffers.get_mut(buffer_of(address)).ok_or(Fault::Outside(address))?;
        let at = (address & ((1 << SPACING) - 1)) as usize;
        let found = part(all, at, bytes, address)?;
        let is_free = match (touched, used) {
            (Some(touched), Use::Read) => touched.may_read(at, bytes, who),
            (Some(touched), Use::Write) => touched.may_write(at, bytes, who),
            _ => true,
        };
        if is_free { Ok(found) } else { Err(Fault::Race(address)) }
    }
}

/// A thread of a launch, or none. The upper half is the number of the launch.
type Stamp = u64;
/// Lower half of a stamp that stands for several threads.
const SEVERAL: u64 = u32::MAX as u64;

/// The threads that have read and written each byte of a buffer in the present launch.
#[derive(Debug, Clone)]
struct Touched {
    read: Vec<Stamp>,
    written: Vec<Stamp>,
}

/// The thread that uses memory, and its launch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Who {
    launch: u32,
    thread: u32,
}

impl Who {
    fn stamp(self) -> Stamp {
        u64::from(self.launch) << 32 | u64::from(self.thread)
    }

    /// Whether another thread of the same launch has left this stamp.
    fn is_in_the_way(self, stamp: Stamp) -> bool {
        stamp >> 32 == u64::from(self.launch) && stamp & SEVERAL != u64::from(self.thread)
    }
}

impl Touched {
    fn new(bytes: usize) -> Self {
        Self { read: vec![0; bytes], written: vec![0; bytes] }
    }

    /// Records a read. Returns whether no other thread of this launch has written there.
    fn may_read(&mut self, at: usize, bytes: usize, who: Who) -> bool {
        let free = self.written[at..at + bytes].iter().all(|&stamp| !who.is_in_the_way(stamp));
        for stamp in &mut self.read[at..at + bytes] {
            *stamp = if who.is_in_the_way(*stamp) { who.stamp() | SEVERAL } else { who.stamp() };
        }
        free
    }

    /// Records a write. Returns whether no other thread of this launch has read or written there.
    fn may_write(&mut self, at: usize, bytes: usize, who: Who) -> bool {
        let both = self.read[at..at + bytes].iter().chain(&self.written[at..at + bytes]);
        let free = both.into_iter().all(|&stamp| !who.is_in_the_way(stamp));
        self.written[at..at + bytes].fill(who.stamp());
        free
    }
}

/// The index of a buffer.
fn buffer_of(address: u64) -> usize {
    ((address >> SPACING) as usize).wrapping_sub(1)
}

/// The bytes from `at` on, which must exist and be aligned; they have this address.
pub(crate) fn part(all: &mut [u8], at: usize, bytes: usize, address: u64) -> Result<&mut [u8], Fault> {
    let found = all.get_mut(at..).and_then(|rest| rest.get_mut(..bytes)).ok_or(Fault::Outside(address))?;
    if at.is_multiple_of(bytes) { Ok(found) } else { Err(Fault::Unaligned(address)) }
}

/// Up to eight bytes as a number, lowest byte first.
pub(crate) fn number(bytes: &[u8]) -> u64 {
    let mut all = [0; 8];
    all[..bytes.len()].copy_from_slice(bytes);
    u64::from_le_bytes(all)
}

pub(crate) fn put(bytes: &mut [u8], value: u64) {
    let len = bytes.len();
    bytes.copy_from_slice(&value.to_le_bytes()[..len]);
}

#[cfg(test)]
mod tests {
    use super::{Touched, Who};

    #[test]
    fn a_byte_is_for_one_writer_or_for_many_readers() {
        let who = |launch, thread| Who { launch, thread };
        let mut touched = Touched::new(8);
        assert!(touched.may_read(0, 4, who(1, 0)) && touched.may_read(0, 4, who(1, 1)));
        // One of two readers writes.
        assert!(!touched.may_write(3, 1, who(1, 1)));
        // Its own bytes, and a neighbour's.
        assert!(touched.may_write(4, 2, who(1, 5)) && touched.may_read(4, 2, who(1, 5)));
        assert!(touched.may_write(6, 2, who(1, 6)));
        assert!(!touched.may_read(4, 4, who(1, 5)));
        // The next launch starts without stamps.
        assert!(touched.may_write(0, 8, who(2, 3)));
        assert!(!touched.may_write(0, 1, who(2, 4)));
    }
}

//! Buffers, as on a device.

use crate::errors::Fault;
use crate::races::{Touched, Who};

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

impl Space {
    /// Whether the address is in the thread's own memory.
    pub(crate) fn is_local(self, address: u64) -> Result<bool, Fault> {
        let local = address >= LOCAL;
        match (self, local) {
            (Self::Global, true) | (Self::Local, false) => Err(Fault::Space(address)),
            _ => Ok(local),
        }
    }
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
        buffer_of(address).and_then(|index| self.buffers.get(index)).map_or(&[], |buffer| &buffer.bytes)
    }

    pub(crate) fn begin_launch(&mut self) {
        self.launches += 1;
    }

    fn who(&self, thread: u32) -> Who {
        Who { launch: self.launches, thread }
    }

    pub(crate) fn read(&mut self, address: u64, bytes: usize, thread: u32) -> Result<u64, Fault> {
        let who = self.who(thread);
        let (buffer, at) = place(&mut self.buffers, address, bytes)?;
        if buffer.touched.as_mut().is_some_and(|touched| !touched.may_read(at, bytes, who)) {
            return Err(Fault::Race(address));
        }
        Ok(number(&buffer.bytes[at..at + bytes]))
    }

    pub(crate) fn write(&mut self, address: u64, bytes: usize, value: u64, thread: u32) -> Result<(), Fault> {
        let who = self.who(thread);
        let (buffer, at) = place(&mut self.buffers, address, bytes)?;
        if buffer.touched.as_mut().is_some_and(|touched| !touched.may_write(at, bytes, who)) {
            return Err(Fault::Race(address));
        }
        put(&mut buffer.bytes[at..at + bytes], value);
        Ok(())
    }

    /// Replaces a value by a function of it, atomically. Returns the old value.
    pub(crate) fn change(
        &mut self,
        address: u64,
        bytes: usize,
        function: impl FnOnce(u64) -> u64,
    ) -> Result<u64, Fault> {
        let (buffer, at) = place(&mut self.buffers, address, bytes)?;
        let there = &mut buffer.bytes[at..at + bytes];
        let old = number(there);
        put(there, function(old));
        Ok(old)
    }
}

fn buffer_of(address: u64) -> Option<usize> {
    usize::try_from(address >> SPACING).ok()?.checked_sub(1)
}

fn place(buffers: &mut [Buffer], address: u64, bytes: usize) -> Result<(&mut Buffer, usize), Fault> {
    let outside = Fault::Outside(address);
    let buffer = buffer_of(address).and_then(|index| buffers.get_mut(index)).ok_or(outside)?;
    let at = (address & ((1 << SPACING) - 1)) as usize;
    check(at, address, bytes, buffer.bytes.len())?;
    Ok((buffer, at))
}

/// Checks that the bytes exist and are aligned.
pub(crate) fn check(at: usize, address: u64, bytes: usize, end: usize) -> Result<(), Fault> {
    if at > end || bytes > end - at {
        return Err(Fault::Outside(address));
    }
    if !at.is_multiple_of(bytes) {
        return Err(Fault::Unaligned(address));
    }
    Ok(())
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

//! Symbols of the memory map.

use core::ptr::addr_of;
use core::slice;

unsafe extern "C" {
    static _stream_start: u8;
    static _stream_end: u8;
    static _stack_start: u32;
    static _stack_end: u32;
}

/// The region for a stream, which the debugger or flash tool loads on a board, and the loader in QEMU.
pub fn stream() -> &'static [u8] {
    let (start, end) = (addr_of!(_stream_start), addr_of!(_stream_end));
    // SAFETY: the memory map reserves these addresses for the stream; nothing in the program writes to them.
    unsafe { slice::from_raw_parts(start, end as usize - start as usize) }
}

/// Greatest use of the stack since the start, bytes: from the lowest word whose paint was overwritten.
pub fn stack_used() -> usize {
    let (end, start) = (addr_of!(_stack_end), addr_of!(_stack_start));
    let mut lowest = end;
    // SAFETY: the words lie between the symbols, which bound the stack; volatile, because the compiler writes the frames there.
    while lowest < start && unsafe { lowest.read_volatile() } == cortex_m_rt::STACK_PAINT_VALUE {
        lowest = lowest.wrapping_add(1);
    }
    start as usize - lowest as usize
}

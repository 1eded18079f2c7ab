//! Detects races: two threads of a launch that use the same byte, where one of them writes it.

/// A thread of a launch, or none. The upper half is the number of the launch.
type Stamp = u64;
/// Lower half of a stamp that stands for several threads.
const SEVERAL: u64 = u32::MAX as u64;

/// The threads that have read and written each byte of a buffer in the present launch.
#[derive(Debug, Clone)]
pub(crate) struct Touched {
    read: Vec<Stamp>,
    written: Vec<Stamp>,
}

/// The thread that uses memory, and its launch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Who {
    pub(crate) launch: u32,
    pub(crate) thread: u32,
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
    pub(crate) fn new(bytes: usize) -> Self {
        Self { read: vec![0; bytes], written: vec![0; bytes] }
    }

    /// Records a read. Returns whether no other thread of this launch has written there.
    pub(crate) fn may_read(&mut self, at: usize, bytes: usize, who: Who) -> bool {
        let free = self.written[at..at + bytes].iter().all(|&stamp| !who.is_in_the_way(stamp));
        for stamp in &mut self.read[at..at + bytes] {
            *stamp = if who.is_in_the_way(*stamp) { who.stamp() | SEVERAL } else { who.stamp() };
        }
        free
    }

    /// Records a write. Returns whether no other thread of this launch has read or written there.
    pub(crate) fn may_write(&mut self, at: usize, bytes: usize, who: Who) -> bool {
        let both = self.read[at..at + bytes].iter().chain(&self.written[at..at + bytes]);
        let free = both.into_iter().all(|&stamp| !who.is_in_the_way(stamp));
        self.written[at..at + bytes].fill(who.stamp());
        free
    }
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

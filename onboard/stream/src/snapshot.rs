//! Snapshots in a stream.

use crate::error::StreamError;
use crate::front::Mark;
use crate::kind::Kind;
use crate::record::{END, Part, Raw, Records, SLICE};
use core::marker::PhantomData;

/// A snapshot in a stream: its slices, which are behind its head, with other records between them.
#[derive(Debug, Clone)]
pub struct Snapshot<'a, K> {
    mark: Mark,
    records: Records<'a>,
    kind: PhantomData<K>,
}

impl<'a, K: Kind> Snapshot<'a, K> {
    pub(crate) fn behind(mark: Mark, records: Records<'a>) -> Self {
        Self { mark, records, kind: PhantomData }
    }

    /// Its description.
    #[must_use]
    pub fn mark(&self) -> Mark {
        self.mark
    }

    /// The bytes of a part, as a source for [`scphd::ScPhd::restore`]; `None` if the snapshot does not have the part.
    #[must_use]
    pub fn part(&self, part: Part) -> Option<impl FnMut(usize, &mut [u8]) -> Result<(), StreamError> + use<'a, K>> {
        if self.mark.parts & part.bit() == 0 {
            return None;
        }
        let mut slices = Slices::of(self.records.clone(), part);
        Some(move |at, into: &mut [u8]| slices.read::<K>(at, into))
    }

    /// The type id that the user gave a part; 0 if it cannot be read.
    #[must_use]
    pub fn user_kind(&self, part: Part) -> u32 {
        let mut kind = [0; 4];
        let read = self.part(part).map(|mut source| source(8, &mut kind));
        if read == Some(Ok(())) { u32::from_le_bytes(kind) } else { 0 }
    }

    /// Whether it is complete: the last byte of every part can be read.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        (0..32).filter(|code| self.mark.parts >> code & 1 != 0).all(|code| {
            let mut slices = Slices::new(self.records.clone(), code);
            let mut length = [0; 4];
            let last = |length| usize::try_from(u32::from_le_bytes(length)).ok()?.checked_sub(1);
            slices.read::<K>(16, &mut length).is_ok()
                && last(length).is_some_and(|last| slices.read::<K>(last, &mut [0]).is_ok())
        })
    }
}

/// Reads one part of a snapshot, forward, and again from its beginning if necessary.
#[derive(Debug, Clone)]
struct Slices<'a> {
    /// The records behind the head.
    first: Records<'a>,
    code: u8,
    /// The records behind the present slice.
    rest: Records<'a>,
    slice: &'a [u8],
    /// Position of the present slice in the part.
    begins: usize,
}

impl<'a> Slices<'a> {
    fn of(records: Records<'a>, part: Part) -> Self {
        Self::new(records, part.code())
    }

    fn new(records: Records<'a>, code: u8) -> Self {
        Self { first: records.clone(), code, rest: records, slice: &[], begins: 0 }
    }

    /// Fills `into` with the bytes of the part from a position on.
    ///
    /// # Errors
    /// A record is damaged, or the part ends before.
    fn read<K: Kind>(&mut self, mut at: usize, into: &mut [u8]) -> Result<(), StreamError> {
        if at < self.begins {
            *self = Self::new(self.first.clone(), self.code);
        }
        let mut left = into;
        while !left.is_empty() {
            let found = at.checked_sub(self.begins).and_then(|within| self.slice.get(within..)).unwrap_or(&[]);
            if found.is_empty() {
                self.turn::<K>()?;
                continue;
            }
            let len = found.len().min(left.len());
            let Some((now, later)) = core::mem::take(&mut left).split_at_mut_checked(len) else { break };
            now.iter_mut().zip(found).for_each(|(slot, &byte)| *slot = byte);
            (at, left) = (at + len, later);
        }
        Ok(())
    }

    /// Continues with the next slice of the part. The next snapshot ends this one.
    fn turn<K: Kind>(&mut self) -> Result<(), StreamError> {
        loop {
            let (raw, rest) = self.rest.next::<K>()?;
            match raw {
                Raw::Head(head) if head.mark().is_some() => return Err(StreamError::Truncated),
                Raw::Record { kind: END, .. } => return Err(StreamError::Truncated),
                Raw::Record { kind: SLICE, parts, payload, .. } if parts == self.code => {
                    self.begins = self.begins.saturating_add(self.slice.len());
                    (self.slice, self.rest) = (payload, rest);
                    return Ok(());
                }
                _ => self.rest = rest,
            }
        }
    }
}

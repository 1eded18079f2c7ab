//! Reading a snapshot in two passes: the first checks all bytes, the second restores them.

use super::RestoreError;
use super::frame::{CHUNK, Check, HEAD, Head, Shape, WORDS, check};
use crate::{Pose, Real, Vector};

/// The words between a head and the checksum of the whole snapshot; zeros after an error.
pub(crate) struct Reader<'s, S, E> {
    source: &'s mut S,
    chunk: [[u8; 4]; CHUNK / 4],
    /// Index of the next word of the chunk, and number of its words.
    next: usize,
    len: usize,
    /// Number of bytes read from the source, and position of the checksum of the whole snapshot.
    at: usize,
    end: usize,
    check: Check,
    failed: Option<RestoreError<E>>,
}

/// Reads a whole snapshot of this shape and checks it. Returns its head.
///
/// # Errors
/// The bytes are not a snapshot of this shape, are damaged or truncated, or the source fails.
pub(crate) fn checked<S, E>(source: &mut S, shape: Shape) -> Result<Head, RestoreError<E>>
where
    S: FnMut(usize, &mut [u8]) -> Result<(), E>,
{
    let mut bytes = [[0; 4]; WORDS + 1];
    source(0, bytes.as_flattened_mut()).map_err(RestoreError::Source)?;
    let (words, check) = match bytes {
        [a, b, c, d, e, f, g, h, check] => ([a, b, c, d, e, f, g, h], check),
    };
    let head = Head::parse(&words, check, shape)?;
    let mut reader = Reader::behind(&head, source);
    reader.pass_over();
    reader.end()?;
    Ok(head)
}

impl<'s, E, S: FnMut(usize, &mut [u8]) -> Result<(), E>> Reader<'s, S, E> {
    /// A reader of the words behind a head.
    pub(crate) fn behind(head: &Head, source: &'s mut S) -> Self {
        let mut check = check();
        check.update(head.words().as_flattened());
        let chunk = [[0; 4]; CHUNK / 4];
        Self { source, chunk, next: 0, len: 0, at: HEAD, end: HEAD + head.body(), check, failed: None }
    }

    /// The next word; 0 after an error. Not inlined, because it is called from many places.
    #[inline(never)]
    pub(crate) fn word(&mut self) -> u32 {
        if self.next == self.len {
            self.refill();
        }
        let Some(word) = self.chunk.get(self.next).filter(|_| self.next < self.len) else { return 0 };
        self.next += 1;
        u32::from_le_bytes(*word)
    }

    /// Reads all remaining words, until the source fails.
    fn pass_over(&mut self) {
        while self.at < self.end && self.failed.is_none() {
            self.refill();
        }
        self.next = self.len;
    }

    fn refill(&mut self) {
        (self.next, self.len) = (0, 0);
        let len = (self.end - self.at).min(CHUNK) / 4;
        if self.failed.is_some() {
            return;
        }
        let Some(words) = self.chunk.get_mut(..len).filter(|words| !words.is_empty()) else {
            // There are fewer words than requested.
            self.failed = Some(RestoreError::Damaged);
            return;
        };
        let bytes = words.as_flattened_mut();
        match (self.source)(self.at, bytes) {
            Ok(()) => {
                self.check.update(bytes);
                self.at += bytes.len();
                self.len = len;
            }
            Err(error) => self.failed = Some(RestoreError::Source(error)),
        }
    }

    /// The next number.
    pub(crate) fn scalar<T: Real>(&mut self) -> T {
        let low = u64::from(self.word());
        let high = if size_of::<T>() > 4 { u64::from(self.word()) } else { 0 };
        T::from_bits(high << 32 | low)
    }

    /// The next pose.
    pub(crate) fn pose<P: Pose>(&mut self) -> P {
        P::of_numbers(|| self.scalar())
    }

    /// The next vector.
    pub(crate) fn vector<V: Vector>(&mut self) -> V {
        V::with(|_| self.scalar())
    }

    /// Checks that there was no error so far.
    ///
    /// # Errors
    /// The first error.
    pub(crate) fn so_far(&mut self) -> Result<(), RestoreError<E>> {
        self.failed.take().map_or(Ok(()), Err)
    }

    /// Checks that everything was read and the checksum is correct.
    ///
    /// # Errors
    /// The error of the source, or a wrong checksum.
    pub(crate) fn end(mut self) -> Result<(), RestoreError<E>> {
        self.so_far()?;
        let mut written = [0; 4];
        (self.source)(self.end, &mut written).map_err(RestoreError::Source)?;
        let all = self.at == self.end && self.next == self.len;
        if all && self.check.finalize() == u32::from_le_bytes(written) { Ok(()) } else { Err(RestoreError::Damaged) }
    }
}

/// Number of numbers of a pose.
pub(crate) fn numbers<P: Pose>() -> u8 {
    let mut count = 0;
    P::ZERO.to_numbers(|_| count += 1);
    count
}

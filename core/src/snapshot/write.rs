//! Writing a snapshot in two traversals: the first measures its length, the second writes it.

use super::SaveError;
use super::frame::{CHUNK, Check, Head, check};
use super::pages::{Met, Numbering};
use super::visit::{Visit, Walk};
use crate::map::PageId;
use crate::{Pose, Real};

/// Flag in the word of a page at its first visit, together with the number of its components.
pub(crate) const NEW_PAGE: u32 = 1 << 31;

/// Writes a snapshot with this head, except its length, which is measured. Returns the number of bytes. `pages` is scratch: an
/// element for every page of the static features, and of the moving ones.
///
/// # Errors
/// The error of the sink.
pub(crate) fn write<E>(
    head: Head,
    content: &impl Walk,
    pages: [&mut [u16]; 2],
    sink: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<usize, SaveError<E>> {
    let [of_static, of_moving] = pages;
    let mut measure =
        AsWords { words: Measure::default(), pages: [&mut *of_static, &mut *of_moving].map(Numbering::over) };
    content.walk(&mut measure);
    let head = head.with_body(measure.words.words);
    let mut writer = AsWords { words: Writer::new(&head, sink), pages: [of_static, of_moving].map(Numbering::over) };
    content.walk(&mut writer);
    writer.words.end()
}

/// A sink for words.
trait Words {
    /// Writes one word.
    fn put(&mut self, word: u32);
}

/// Measures the length of a traversal.
#[derive(Debug, Default)]
struct Measure {
    words: u32,
}

impl Words for Measure {
    fn put(&mut self, _word: u32) {
        self.words = self.words.saturating_add(1);
    }
}

/// Writes words to a sink, with the checksum of all of them; after the sink's first error, nothing more.
struct Writer<F, E> {
    sink: F,
    chunk: [[u8; 4]; CHUNK / 4],
    /// Number of words in the chunk.
    len: usize,
    check: Check,
    written: usize,
    result: Result<(), E>,
}

impl<E, F: FnMut(&[u8]) -> Result<(), E>> Writer<F, E> {
    /// Begins with the head.
    fn new(head: &Head, sink: F) -> Self {
        let mut writer = Self { sink, chunk: [[0; 4]; CHUNK / 4], len: 0, check: check(), written: 0, result: Ok(()) };
        let words = head.words();
        words.iter().for_each(|word| writer.put_bytes(*word));
        // The checksum of the head is not part of the checksum of the whole: otherwise the latter would not depend on the head.
        writer.queue(Head::check(&words));
        writer
    }

    /// Ends with the checksum. Returns the number of bytes.
    ///
    /// # Errors
    /// The first error of the sink.
    fn end(mut self) -> Result<usize, SaveError<E>> {
        let check = core::mem::replace(&mut self.check, check()).finalize();
        self.queue(check.to_le_bytes());
        self.flush();
        self.result.map(|()| self.written).map_err(SaveError::Sink)
    }

    fn put_bytes(&mut self, word: [u8; 4]) {
        self.check.update(&word);
        self.queue(word);
    }

    fn queue(&mut self, word: [u8; 4]) {
        if let Some(slot) = self.chunk.get_mut(self.len) {
            *slot = word;
            self.len += 1;
        }
        if self.len == self.chunk.len() {
            self.flush();
        }
    }

    fn flush(&mut self) {
        let bytes = self.chunk.get(..self.len).unwrap_or(&[]).as_flattened();
        if self.result.is_ok() && !bytes.is_empty() {
            self.result = (self.sink)(bytes);
            self.written = self.written.saturating_add(bytes.len());
        }
        self.len = 0;
    }
}

impl<E, F: FnMut(&[u8]) -> Result<(), E>> Words for Writer<F, E> {
    // Not inlined, because it is called from many places.
    #[inline(never)]
    fn put(&mut self, word: u32) {
        self.put_bytes(word.to_le_bytes());
    }
}

/// Converts a traversal to words; the components of a page are written at its first visit.
#[derive(Debug)]
struct AsWords<'n, W> {
    words: W,
    /// Of the static and of the moving features.
    pages: [Numbering<'n>; 2],
}

impl<W: Words> Visit for AsWords<'_, W> {
    fn word(&mut self, word: u32) {
        self.words.put(word);
    }

    fn scalar<T: Real>(&mut self, number: T) {
        let bits = number.bits();
        self.words.put(bits as u32);
        if size_of::<T>() > 4 {
            self.words.put((bits >> 32) as u32);
        }
    }

    fn pose<P: Pose>(&mut self, pose: &P) {
        pose.to_numbers(|number| self.scalar(number));
    }

    fn snapshot_word(&mut self, word: u32) {
        self.word(word);
    }

    fn snapshot_scalar<T: Real>(&mut self, number: T) {
        self.scalar(number);
    }

    fn page(&mut self, moves: bool, id: PageId, components: usize) -> bool {
        let [of_static, of_moving] = &mut self.pages;
        match (if moves { of_moving } else { of_static }).meet(id) {
            Met::First => {
                self.words.put(NEW_PAGE | components as u32);
                true
            }
            Met::Before(number) => {
                self.words.put(u32::from(number));
                false
            }
        }
    }
}

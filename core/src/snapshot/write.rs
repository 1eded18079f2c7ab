//! Writing a snapshot in two traversals: the first measures its length, the second writes it.

use super::SaveError;
use super::frame::{CHUNK, Check, Head, check};
use super::pages::{Met, Numbering};
use super::visit::{Visit, Walk};
use crate::map::PageId;
use crate::{Pose, Real};

/// In the word of a page that comes for the first time, beside the number of its components.
pub(crate) const NEW_PAGE: u32 = 1 << 31;

/// Writes a snapshot, of which the head lacks the length alone; how many bytes it takes. `pages` is scratch: a place for every page of
/// the features that stand still, and of those that move.
///
/// # Errors
/// The sink takes no more.
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

/// A walk of which only the length counts.
#[derive(Debug, Default)]
struct Measure {
    words: u32,
}

impl Words for Measure {
    fn put(&mut self, _word: u32) {
        self.words = self.words.saturating_add(1);
    }
}

/// Words on their way to a sink, with the check of all of them; after the sink's first error, nothing more.
struct Writer<F, E> {
    sink: F,
    chunk: [[u8; 4]; CHUNK / 4],
    /// Words in the chunk.
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
        // Were the head's own check taken into that of the whole, the head would leave no trace in it.
        writer.queue(Head::check(&words));
        writer
    }

    /// Ends with the check; how many bytes there were.
    ///
    /// # Errors
    /// The sink's first one.
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
    // Wanted in many places, and once in flash.
    #[inline(never)]
    fn put(&mut self, word: u32) {
        self.put_bytes(word.to_le_bytes());
    }
}

/// A walk that becomes words, the components of a page where it comes for the first time.
#[derive(Debug)]
struct AsWords<'n, W> {
    words: W,
    /// Of the features that stand still, and of those that move.
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

    fn beside(&mut self, word: u32) {
        self.word(word);
    }

    fn beside_scalar<T: Real>(&mut self, number: T) {
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

// A NOR flash in RAM with simulated power failures.

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

/// Effect of a power failure on the word that is being written, or the page that is being erased.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)]
pub enum Cut {
    /// No effect.
    Before,
    /// Some of the bits, or the first half of the page.
    First,
    /// The other bits, or the second half.
    Second,
    /// Every bit of a page partly erased; some of the bits of a word.
    Faint,
    /// Arbitrary content.
    Noise,
    /// The operation is complete, but returns an error.
    After,
}

/// The power has failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PowerLost;

impl NorFlashError for PowerLost {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chip<const WORD: usize, const PAGE: usize, const PAGES: usize> {
    bytes: Vec<u8>,
    /// Number of words or pages until the power fails, and the effect.
    left: Option<(usize, Cut)>,
    /// A worn page, whose bits cannot be written.
    worn: Option<usize>,
    /// Number of words written and pages erased so far.
    done: usize,
}

/// Words of 4 bytes, 16 pages of 1 KiB.
#[allow(dead_code)]
pub type Flash = Chip<4, 1024, 16>;

#[allow(dead_code)]
impl<const WORD: usize, const PAGE: usize, const PAGES: usize> Chip<WORD, PAGE, PAGES> {
    pub const LEN: u32 = (PAGE * PAGES) as u32;

    pub fn new() -> Self {
        Self { bytes: vec![0xff; PAGE * PAGES], left: None, worn: None, done: 0 }
    }

    /// The same chip, with a power failure after this number of words and pages.
    pub fn failing(&self, after: usize, cut: Cut) -> Self {
        Self { left: Some((after, cut)), done: 0, ..self.clone() }
    }

    /// The chip after the power has returned.
    pub fn restarted(mut self) -> Self {
        self.left = None;
        self
    }

    /// Number of words written and pages erased since the last call of `failing`, or since its construction.
    pub fn done(&self) -> usize {
        self.done
    }

    /// The same chip with a worn page.
    pub fn worn(self, page: usize) -> Self {
        Self { worn: Some(page), ..self }
    }

    /// Its content, to be damaged.
    pub fn bytes(&mut self) -> &mut [u8] {
        &mut self.bytes
    }

    /// Writes a word or erases a page; the error is the effect of a power failure, if any.
    fn step(&mut self) -> Result<(), Option<Cut>> {
        match &mut self.left {
            None => self.done += 1,
            Some((usize::MAX, _)) => return Err(None),
            Some((0, cut)) => {
                let cut = *cut;
                self.left = Some((usize::MAX, cut));
                return Err(Some(cut));
            }
            Some((left, _)) => {
                *left -= 1;
                self.done += 1;
            }
        }
        Ok(())
    }
}

/// Pseudo-random bytes that depend only on the seed.
fn noise(seed: usize, bytes: &mut [u8]) {
    let mut state = seed as u32 | 1;
    for byte in bytes {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *byte = (state >> 24) as u8;
    }
}

impl<const WORD: usize, const PAGE: usize, const PAGES: usize> ErrorType for Chip<WORD, PAGE, PAGES> {
    type Error = PowerLost;
}

impl<const WORD: usize, const PAGE: usize, const PAGES: usize> ReadNorFlash for Chip<WORD, PAGE, PAGES> {
    const READ_SIZE: usize = WORD;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerLost> {
        if matches!(self.left, Some((usize::MAX, _))) {
            return Err(PowerLost);
        }
        assert!((offset as usize).is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD));
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const WORD: usize, const PAGE: usize, const PAGES: usize> NorFlash for Chip<WORD, PAGE, PAGES> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerLost> {
        let (from, to) = (from as usize, to as usize);
        assert!(from.is_multiple_of(PAGE) && to.is_multiple_of(PAGE) && from <= to);
        for start in (from..to).step_by(PAGE) {
            let step = self.step();
            let page = &mut self.bytes[start..start + PAGE];
            match step {
                Ok(()) | Err(Some(Cut::After)) => page.fill(0xff),
                Err(Some(Cut::First)) => page[..PAGE / 2].fill(0xff),
                Err(Some(Cut::Second)) => page[PAGE / 2..].fill(0xff),
                Err(Some(Cut::Faint)) => page.iter_mut().for_each(|byte| *byte |= 0xa5),
                Err(Some(Cut::Noise)) => noise(start, page),
                Err(Some(Cut::Before) | None) => (),
            }
            step.map_err(|_| PowerLost)?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerLost> {
        let offset = offset as usize;
        assert!(offset.is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD));
        for (place, word) in bytes.chunks(WORD).enumerate() {
            let step = self.step();
            let start = offset + place * WORD;
            let there = &mut self.bytes[start..start + WORD];
            if step.is_ok() {
                assert!(there.iter().all(|&byte| byte == 0xff), "a word of a NOR flash is written once: {start:#x}");
            }
            if step == Err(Some(Cut::Noise)) {
                noise(start, there);
            }
            let missing = match step {
                Ok(()) if self.worn == Some(start / PAGE) => 0xff,
                Ok(()) | Err(Some(Cut::After)) => 0,
                Err(Some(Cut::First)) => 0xf0,
                Err(Some(Cut::Second)) => 0x0f,
                Err(Some(Cut::Faint)) => 0xa5,
                Err(Some(Cut::Before | Cut::Noise) | None) => 0xff,
            };
            there.iter_mut().zip(word).for_each(|(there, &byte)| *there &= byte | missing);
            step.map_err(|_| PowerLost)?;
        }
        Ok(())
    }
}

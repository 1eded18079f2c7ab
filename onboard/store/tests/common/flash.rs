// A NOR flash in RAM, whose power fails when it is told to.

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

/// What the flash has done of the word that it was writing, or of the page that it was erasing, when its power failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)]
pub enum Cut {
    /// Nothing.
    Before,
    /// Some of the bits, or the first half of the page.
    First,
    /// The others.
    Second,
    /// Of a page every bit by halves; of a word some of the bits.
    Faint,
    /// Anything.
    Noise,
    /// All of it, but nobody was told.
    After,
}

/// The power is gone.
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
    /// Words that can be written or pages that can be erased before the power fails, and how it fails.
    left: Option<(usize, Cut)>,
    /// A page that takes no bit any more.
    worn: Option<usize>,
    /// Words written and pages erased so far.
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

    /// The same chip, whose power will fail after so many words and pages.
    pub fn failing(&self, after: usize, cut: Cut) -> Self {
        Self { left: Some((after, cut)), done: 0, ..self.clone() }
    }

    /// The power is back.
    pub fn restarted(mut self) -> Self {
        self.left = None;
        self
    }

    /// Words written and pages erased since it was told to fail, or since it was made.
    pub fn done(&self) -> usize {
        self.done
    }

    /// The same chip, with a page that takes no bit any more.
    pub fn worn(self, page: usize) -> Self {
        Self { worn: Some(page), ..self }
    }

    /// What is in it, to be spoilt.
    pub fn bytes(&mut self) -> &mut [u8] {
        &mut self.bytes
    }

    /// Writes a word or erases a page, if the power lasts; what is done of it otherwise.
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

/// Bytes that hang on nothing but where they are.
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

//! Which field is refused, and what it must be, in words.

use crate::pointer::Out;
use crate::scphd_status;
use core::ffi::c_char;
use scphd::errors::{ConfigError, SetupError};
use scphd::models::ModelError;

/// Bytes of the text, with the zero at its end.
const TEXT: usize = 124;

/// Why a configuration was refused.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_reason {
    /// `sizeof(scphd_reason)`, set by the caller.
    pub struct_size: u32,
    /// One line in UTF-8 that ends with a zero, as "prune_weight must be above 0 and below 1". Empty where no field is to blame.
    pub text: [c_char; 124],
}

const _: () = assert!(size_of::<scphd_reason>() == 4 + TEXT);

impl scphd_reason {
    fn tell(&mut self, words: [&str; 3]) {
        self.text = [0; TEXT];
        let (room, _end) = self.text.split_at_mut(TEXT - 1);
        let bytes = words.iter().flat_map(|word| word.bytes());
        room.iter_mut().zip(bytes).for_each(|(slot, byte)| *slot = byte.cast_signed() as c_char);
    }
}

/// Where the reason of a refusal goes, if the caller asks for it.
#[derive(Debug)]
pub(crate) struct Reason<'a>(Option<&'a mut scphd_reason>);

impl<'a> Reason<'a> {
    /// The caller's place for it, which may be none, empty.
    pub(crate) fn of(place: &'a mut Out<scphd_reason>) -> Result<Self, scphd_status> {
        let mut reason = Self(place.wanted()?);
        reason.tell([""; 3]);
        Ok(reason)
    }

    /// Nobody asks for it.
    #[cfg(test)]
    pub(crate) fn none() -> Self {
        Self(None)
    }

    fn tell(&mut self, words: [&str; 3]) {
        if let Some(reason) = &mut self.0 {
            reason.tell(words);
        }
    }

    /// Writes it, and says what it is called.
    pub(crate) fn setup(&mut self, error: SetupError) -> scphd_status {
        match error {
            SetupError::Config(error) => self.config(error),
            SetupError::Model(error) => self.model(error),
            other => other.into(),
        }
    }

    /// The same of a model's parameter.
    pub(crate) fn model(&mut self, error: ModelError) -> scphd_status {
        self.tell([error.field, " must be ", error.range]);
        scphd_status::OutOfRange
    }

    fn config(&mut self, error: ConfigError) -> scphd_status {
        self.tell([error.field, " must be ", error.range]);
        scphd_status::OutOfRange
    }

    /// A field of this interface.
    pub(crate) fn field(&mut self, field: &str, range: &str) -> scphd_status {
        self.tell([field, " must be ", range]);
        scphd_status::OutOfRange
    }
}

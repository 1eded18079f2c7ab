//! Which field is refused, and what it must be, in words.

use crate::pointer::Out;
use crate::scphd_status;
use core::ffi::c_char;
use scphd::errors::{ConfigError, SetupError};
use scphd::models::ModelError;
use scphd_vehicle::{Invalid, StartError};

/// Bytes of the text, with the zero at its end.
const TEXT: usize = 124;

/// Why a configuration was refused.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_reason {
    /// `sizeof(scphd_reason)`, set by the caller.
    pub struct_size: u32,
    /// One line in UTF-8 that ends with a zero, as "joint.gate must be finite and at least 0". Empty where no setting is to blame.
    pub text: [c_char; 124],
}

const _: () = assert!(size_of::<scphd_reason>() == 4 + TEXT);

impl scphd_reason {
    fn tell(&mut self, words: &[&str]) {
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
        reason.tell(&[]);
        Ok(reason)
    }

    fn tell(&mut self, words: &[&str]) {
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
        self.tell(&[error.field, " must be ", error.range]);
        scphd_status::OutOfRange
    }

    fn config(&mut self, error: ConfigError) -> scphd_status {
        self.tell(&[error.field, " must be ", error.range]);
        scphd_status::OutOfRange
    }

    /// The same of a setting of a description.
    pub(crate) fn invalid(&mut self, Invalid { field, range, sensor }: Invalid) -> scphd_status {
        let sensor =
            sensor.and_then(|sensor| [" of sensor 0", " of sensor 1", " of sensor 2", " of sensor 3"].get(sensor));
        self.tell(&[field, sensor.unwrap_or(&""), " must be ", range.words()]);
        scphd_status::OutOfRange
    }

    /// Why no filter is made by a description.
    pub(crate) fn start(&mut self, error: StartError) -> scphd_status {
        let (words, status) = match error {
            StartError::Invalid(invalid) => return self.invalid(invalid),
            StartError::Setup(error) => return self.setup(error),
            StartError::NoRoom { part } => (["the memory has no room for ", part], scphd_status::NoRoom),
            StartError::NotDescribed { part } => (["the description lacks ", part], scphd_status::NotDescribed),
            StartError::Fixed { part } => (["not while the filter goes on: ", part], scphd_status::NotPossible),
            _ => return scphd_status::Refused,
        };
        self.tell(&words);
        status
    }
}

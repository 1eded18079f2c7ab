//! Which setting is refused.

use crate::pointer::Out;
use crate::report::count;
use crate::scphd_status;
use core::ffi::c_char;
use scphd::errors::SetupError;
use scphd::models::ModelError;
use scphd_vehicle::{Invalid, Setting, StartError};

/// Bytes of the text, with the zero at its end.
const TEXT: usize = 116;

/// Why a description or a setting was refused. All is 0 where none of them is to blame.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_reason {
    /// `sizeof(scphd_reason)`, set by the caller.
    pub struct_size: u32,
    /// The setting, as `SCPHD_JOINT_GATE`; `scphd_setting_name` and `scphd_setting_range` have its texts. 0 where `text` says more.
    pub setting: u32,
    /// Of a setting of a sensor: which sensor.
    pub sensor: u32,
    /// One line in UTF-8 that ends with a zero, as "range_sigma_m must be finite and above 0", where settings do not fit each other, and of a
    /// sonar. Empty where `setting` says it.
    pub text: [c_char; 116],
}

const _: () = assert!(size_of::<scphd_reason>() == 12 + TEXT);

impl scphd_reason {
    fn tell(&mut self, words: [&str; 3]) {
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
        let mut reason = place.wanted()?;
        if let Some(reason) = &mut reason {
            (reason.setting, reason.sensor, reason.text) = (0, 0, [0; TEXT]);
        }
        Ok(Self(reason))
    }

    fn blame(&mut self, setting: Setting, sensor: Option<usize>, status: scphd_status) -> scphd_status {
        if let Some(reason) = &mut self.0 {
            (reason.setting, reason.sensor) = (setting.number(), sensor.map_or(0, count));
        }
        status
    }

    fn tell(&mut self, field: &str, range: &str) -> scphd_status {
        if let Some(reason) = &mut self.0 {
            reason.tell([field, " must be ", range]);
        }
        scphd_status::OutOfRange
    }

    /// Writes it, and says what it is called.
    pub(crate) fn setup(&mut self, error: SetupError) -> scphd_status {
        match error {
            SetupError::Config(error) => self.tell(error.field, error.range),
            SetupError::Model(error) => self.model(error),
            other => other.into(),
        }
    }

    /// The same of a model's parameter.
    pub(crate) fn model(&mut self, error: ModelError) -> scphd_status {
        self.tell(error.field, error.range)
    }

    /// The same of a setting of a description.
    pub(crate) fn invalid(&mut self, Invalid { setting, sensor }: Invalid) -> scphd_status {
        self.blame(setting, sensor, scphd_status::OutOfRange)
    }

    /// Why no filter is made by a description.
    pub(crate) fn start(&mut self, error: StartError) -> scphd_status {
        match error {
            StartError::Invalid(invalid) => self.invalid(invalid),
            StartError::Setup(error) => self.setup(error),
            StartError::NoRoom { part } => self.blame(part, None, scphd_status::NoRoom),
            StartError::NotDescribed { part } => self.blame(part, None, scphd_status::NotDescribed),
            StartError::Fixed { part } => self.blame(part, None, scphd_status::NotPossible),
            _ => scphd_status::Refused,
        }
    }
}

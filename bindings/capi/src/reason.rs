//! The reason why a description or a setting was refused.

use crate::pointer::Out;
use crate::report::count;
use crate::scphd_status;
use core::ffi::c_char;
use scphd::errors::SetupError;
use scphd::models::ModelError;
use scphd_vehicle::{Invalid, Setting, StartError};

/// Bytes of the text, with the terminating zero.
const TEXT: usize = 116;

/// The reason why a description or a setting was refused. All zero if the call failed for another reason.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_reason {
    /// `sizeof(scphd_reason)`, set by the caller.
    pub struct_size: u32,
    /// Number of the setting, such as `SCPHD_JOINT_GATE`; `scphd_setting_name` and `scphd_setting_range` return its texts. 0 if
    /// there is a `text`.
    pub setting: u32,
    /// Index of the sensor, for a setting of a sensor.
    pub sensor: u32,
    /// A line of UTF-8 that ends with a zero, such as "range_sigma_m must be finite and above 0", for settings that do not fit
    /// together and for sonars. Empty if there is a `setting`.
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

/// The caller's memory for the reason, if there is any.
#[derive(Debug)]
pub(crate) struct Reason<'a>(Option<&'a mut scphd_reason>);

impl<'a> Reason<'a> {
    /// The caller's memory, cleared; its pointer may be null.
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

    /// Writes the error of a filter's configuration. Returns its status.
    pub(crate) fn setup(&mut self, error: SetupError) -> scphd_status {
        match error {
            SetupError::Config(error) => self.tell(error.field, error.range),
            SetupError::Model(error) => self.model(error),
            other => other.into(),
        }
    }

    /// Writes the error of a model's parameter. Returns its status.
    pub(crate) fn model(&mut self, error: ModelError) -> scphd_status {
        self.tell(error.field, error.range)
    }

    /// Writes the error of a setting of a description. Returns its status.
    pub(crate) fn invalid(&mut self, Invalid { setting, sensor }: Invalid) -> scphd_status {
        self.blame(setting, sensor, scphd_status::OutOfRange)
    }

    /// Writes the error of starting a filter. Returns its status.
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

//! Settings of the sequencer.

/// Reordering window, and limits beyond which missing inputs and time stamps are faults.
///
/// ```
/// use scphd_sequencer::Settings;
///
/// // A bus that delays by at most 50 ms, wheels that report every 20 ms.
/// let settings = Settings { window_ns: 50_000_000, gap_ns: 100_000_000, ..Settings::DEFAULT };
/// assert!(settings.check().is_ok());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// Reordering window: greatest delay of an input relative to newer ones, ns. It is also the delay of the estimate. Up to 2⁶²
    /// ns; 200 ms by default.
    pub window_ns: u64,
    /// Time for which a control holds without a newer one, ns: above 0. 500 ms by default.
    pub gap_ns: u64,
    /// A time stamp that differs from the newest time by more than this, ns, counts as a jump of the clock. Above `window_ns`, up
    /// to 2⁶² ns; 10 s by default. A silence of this length without calls of [`tick`](crate::Sequencer::tick) cannot be
    /// distinguished from a jump.
    pub jump_ns: u64,
    /// Number of inputs in a row from beyond a jump, each within `jump_ns` of the previous one, after which the clock counts as
    /// set: at least 1. It must be above the number of inputs that one instrument sends while the others send none, otherwise an
    /// instrument with a wrong clock sets the time; 20 by default.
    pub jumps_believed: u32,
    /// Number of inputs in a row that are not newer than all before, after which the clock of the time stamps counts as frozen:
    /// at least 1. It must be above the number of inputs within the window; 200 by default.
    pub frozen_inputs: u32,
}

/// Limit within which the sign of a difference of two times is unambiguous.
const GREATEST_NS: u64 = 1 << 62;

impl Settings {
    /// The defaults, for constants.
    pub const DEFAULT: Self = Self {
        window_ns: 200_000_000,
        gap_ns: 500_000_000,
        jump_ns: 10_000_000_000,
        jumps_believed: 20,
        frozen_inputs: 200,
    };

    /// The placeholder before the start, all zero, so that a static is in `.bss`.
    pub(crate) const UNSET: Self = Self { window_ns: 0, gap_ns: 0, jump_ns: 0, jumps_believed: 0, frozen_inputs: 0 };

    /// Checks all fields.
    ///
    /// # Errors
    /// Names the field that is out of range.
    pub fn check(&self) -> Result<(), SettingsError> {
        let wrong = |field, range| Err(SettingsError { field, range });
        match *self {
            Self { window_ns, .. } if window_ns > GREATEST_NS => wrong("window_ns", "at most 2^62"),
            Self { gap_ns: 0, .. } => wrong("gap_ns", "above 0"),
            Self { jump_ns, .. } if jump_ns > GREATEST_NS => wrong("jump_ns", "at most 2^62"),
            Self { jump_ns, window_ns, .. } if jump_ns <= window_ns => wrong("jump_ns", "above window_ns"),
            Self { jumps_believed: 0, .. } => wrong("jumps_believed", "at least 1"),
            Self { frozen_inputs: 0, .. } => wrong("frozen_inputs", "at least 1"),
            _ => Ok(()),
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A field of the settings is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[error("{field} must be {range}")]
pub struct SettingsError {
    /// Name of the field.
    pub field: &'static str,
    /// Its valid range.
    pub range: &'static str,
}

#[cfg(test)]
mod tests {
    use super::Settings;

    #[test]
    fn fields_are_checked() {
        let default = Settings::DEFAULT;
        assert_eq!((default.check(), Settings::default()), (Ok(()), default));
        for (settings, field) in [
            (Settings { window_ns: u64::MAX, jump_ns: u64::MAX, ..default }, "window_ns"),
            (Settings { gap_ns: 0, ..default }, "gap_ns"),
            (Settings { jump_ns: default.window_ns, ..default }, "jump_ns"),
            (Settings { jump_ns: u64::MAX, ..default }, "jump_ns"),
            (Settings { jumps_believed: 0, ..default }, "jumps_believed"),
            (Settings { frozen_inputs: 0, ..default }, "frozen_inputs"),
        ] {
            assert_eq!(settings.check().unwrap_err().field, field);
        }
    }
}

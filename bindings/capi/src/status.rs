//! Results of calls.

use core::ffi::{CStr, c_char};
use scphd::errors::{LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError};
use scphd::snapshot::{RestoreError, SaveError};
use scphd_vehicle::Refused;

/// The result of a call. A refused call leaves the filter unchanged, except for its time: see `scphd_slam_predict`.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum scphd_status {
    /// Success.
    Ok = 0,
    /// A pointer is null, but must not be.
    NullPointer = 1,
    /// A pointer is not aligned for its type.
    Misaligned = 2,
    /// The memory is smaller than the set requires.
    MemoryTooSmall = 3,
    /// There is already a filter, detector or description in this memory. Release it first.
    AlreadyStarted = 5,
    /// There is nothing in this memory, or it was copied from another address.
    NotStarted = 6,
    /// The memory contains another kind, or another set.
    WrongMemory = 7,
    /// Another call uses the same memory, from an interrupt or a second thread.
    Busy = 8,
    /// The last call did not finish, so that its state cannot be resumed. Start again.
    Interrupted = 9,
    /// `struct_size` is not the size in this library: it was not set, or the header is of another version.
    WrongStructSize = 10,
    /// The header and the library have different versions.
    WrongVersion = 11,
    /// An array is longer than the address space.
    ArrayTooLong = 12,
    /// A field is out of range; the reason names it.
    OutOfRange = 20,
    /// The configuration has more particles or candidates than the set.
    TooManyParticles = 21,
    /// The birth intensity of moving features is above 0, but the set has no memory for them.
    NoRoomForMoving = 22,
    /// The memory was left by a filter with another configuration.
    OtherConfiguration = 23,
    /// The contents of the memory are damaged.
    Damaged = 24,
    /// A pose is not finite, or a coordinate above 1e8.
    BadPose = 25,
    /// The filter has not been reset to a pose yet.
    NotReset = 26,
    /// The time step is negative or not finite.
    BadTimeStep = 27,
    /// A control is not finite, outside of the motion's domain, or of another vehicle.
    BadControl = 28,
    /// The step is beyond the limits of the motion.
    Implausible = 29,
    /// The scan has more measurements than its detector has memory for.
    TooManyMeasurements = 30,
    /// A measurement is not finite.
    BadMeasurement = 31,
    /// The noise of a sensor or a fix is not positive definite.
    BadNoise = 32,
    /// There is no setting with this number.
    UnknownSetting = 33,
    /// The description has no such sensor, fix or part, or the sensor is of another type.
    NotDescribed = 34,
    /// This filter does not support the call.
    NotPossible = 35,
    /// The memory has no capacity for a part of the description; the reason names it.
    NoRoom = 36,
    /// A map cannot be loaded: it is too long, or a feature is out of range.
    BadMap = 37,
    /// The bytes are not a snapshot for this filter and memory, or damaged; or the memory for a snapshot is too small.
    BadSnapshot = 38,
    /// The function is a service: call `scphd_services_...` of the filter's set first.
    NoServices = 39,
    /// Refused for another reason.
    Refused = 99,
}

impl scphd_status {
    fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"ok",
            Self::NullPointer => c"a pointer is null",
            Self::Misaligned => c"a pointer is not aligned",
            Self::MemoryTooSmall => c"the memory is too small for its set",
            Self::AlreadyStarted => c"something runs in this memory already: release it first",
            Self::NotStarted => c"nothing was started in this memory",
            Self::WrongMemory => c"what runs in this memory is of another kind or set",
            Self::Busy => c"another call works on the same memory",
            Self::Interrupted => c"the last call did not come to its end: start anew",
            Self::WrongStructSize => c"struct_size is not the size that the library knows",
            Self::WrongVersion => c"header and library are of different versions",
            Self::ArrayTooLong => c"an array is longer than memory can be",
            Self::OutOfRange => c"a field is out of range",
            Self::TooManyParticles => c"more particles or candidates than the set has room for",
            Self::NoRoomForMoving => c"births of moving features, and no room for them",
            Self::OtherConfiguration => c"the memory holds a filter of another configuration",
            Self::Damaged => c"what the memory holds is damaged",
            Self::BadPose => c"a pose is not finite or too far away",
            Self::NotReset => c"the filter has not been reset to a pose yet",
            Self::BadTimeStep => c"the time step is negative or not finite",
            Self::BadControl => c"a control is not finite, out of its domain or of another vehicle",
            Self::Implausible => c"no vehicle makes such a step",
            Self::TooManyMeasurements => c"more measurements than the detector has room for",
            Self::BadMeasurement => c"a measurement is not finite",
            Self::BadNoise => c"noise is not positive definite",
            Self::UnknownSetting => c"there is no setting of this number",
            Self::NotDescribed => c"the description has no such sensor, fix or part",
            Self::NotPossible => c"this filter cannot do that",
            Self::NoRoom => c"the memory has no room for a part of the description",
            Self::BadMap => c"the map is too long, or a feature is out of range",
            Self::BadSnapshot => c"not a snapshot for this filter, or damaged, or too little room for it",
            Self::NoServices => c"a service: call scphd_services_... of the filter's set first",
            Self::Refused => c"refused",
        }
    }

    /// All statuses.
    const ALL: [Self; 33] = [
        Self::Ok,
        Self::NullPointer,
        Self::Misaligned,
        Self::MemoryTooSmall,
        Self::AlreadyStarted,
        Self::NotStarted,
        Self::WrongMemory,
        Self::Busy,
        Self::Interrupted,
        Self::WrongStructSize,
        Self::WrongVersion,
        Self::ArrayTooLong,
        Self::OutOfRange,
        Self::TooManyParticles,
        Self::NoRoomForMoving,
        Self::OtherConfiguration,
        Self::Damaged,
        Self::BadPose,
        Self::NotReset,
        Self::BadTimeStep,
        Self::BadControl,
        Self::Implausible,
        Self::TooManyMeasurements,
        Self::BadMeasurement,
        Self::BadNoise,
        Self::UnknownSetting,
        Self::NotDescribed,
        Self::NotPossible,
        Self::NoRoom,
        Self::BadMap,
        Self::BadSnapshot,
        Self::NoServices,
        Self::Refused,
    ];

    /// `Ok` as a status.
    pub(crate) fn of(result: Result<(), Self>) -> Self {
        result.map_or_else(|status| status, |()| Self::Ok)
    }
}

/// The meaning of a status, a line of English; any number is allowed. The text is static.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_error_text(status: i32) -> *const c_char {
    let known = scphd_status::ALL.iter().find(|known| **known as i32 == status);
    known.map_or(c"not a status of this library", |known| known.text()).as_ptr()
}

impl From<SetupError> for scphd_status {
    fn from(error: SetupError) -> Self {
        match error {
            SetupError::Config(_) | SetupError::Model(_) => Self::OutOfRange,
            SetupError::TooManyParticles { .. } | SetupError::TooManyCandidates { .. } => Self::TooManyParticles,
            SetupError::NoRoomForMoving => Self::NoRoomForMoving,
            SetupError::HeldParticles { .. } | SetupError::HeldSamples { .. } | SetupError::HeldCovariance => {
                Self::OtherConfiguration
            }
            SetupError::HeldDamaged(_) => Self::Damaged,
            _ => Self::Refused,
        }
    }
}

impl From<ResetError> for scphd_status {
    fn from(error: ResetError) -> Self {
        match error {
            ResetError::NonFinitePose => Self::BadPose,
            ResetError::Covariance => Self::BadNoise,
            ResetError::NotStarted => Self::NotReset,
            _ => Self::Refused,
        }
    }
}

impl From<PredictError> for scphd_status {
    fn from(error: PredictError) -> Self {
        match error {
            PredictError::NotStarted => Self::NotReset,
            PredictError::TimeStep => Self::BadTimeStep,
            PredictError::Control => Self::BadControl,
            PredictError::Implausible(_) => Self::Implausible,
            _ => Self::Refused,
        }
    }
}

impl From<ScanError> for scphd_status {
    fn from(error: ScanError) -> Self {
        match error {
            ScanError::NotStarted => Self::NotReset,
            ScanError::TooManyMeasurements { .. } => Self::TooManyMeasurements,
            ScanError::NonFinite { .. } => Self::BadMeasurement,
            ScanError::SensorNoise => Self::BadNoise,
            ScanError::NoRoomForMoving => Self::NoRoomForMoving,
            _ => Self::Refused,
        }
    }
}

impl From<ObserveError> for scphd_status {
    fn from(error: ObserveError) -> Self {
        match error {
            ObserveError::NotStarted => Self::NotReset,
            ObserveError::NonFinite => Self::BadMeasurement,
            ObserveError::Noise => Self::BadNoise,
            _ => Self::Refused,
        }
    }
}

impl From<LoadMapError> for scphd_status {
    fn from(error: LoadMapError) -> Self {
        match error {
            LoadMapError::NotStarted => Self::NotReset,
            _ => Self::BadMap,
        }
    }
}

impl<E> From<SaveError<E>> for scphd_status {
    fn from(error: SaveError<E>) -> Self {
        match error {
            SaveError::NotStarted => Self::NotReset,
            SaveError::Damaged(_) => Self::Damaged,
            _ => Self::BadSnapshot,
        }
    }
}

impl<E> From<RestoreError<E>> for scphd_status {
    fn from(_: RestoreError<E>) -> Self {
        Self::BadSnapshot
    }
}

impl<E: Into<Self>> From<Refused<E>> for scphd_status {
    fn from(refused: Refused<E>) -> Self {
        match refused {
            Refused::Filter(error) => error.into(),
            Refused::NotDescribed => Self::NotDescribed,
            Refused::Watched => Self::NoServices,
            _ => Self::NotPossible,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_has_a_text_and_a_number_of_its_own() {
        for (place, status) in scphd_status::ALL.iter().enumerate() {
            for other in &scphd_status::ALL[..place] {
                assert!(*status as i32 != *other as i32 && status.text() != other.text());
            }
        }
        let source = include_str!("status.rs");
        let (_, after) = source.split_once("pub enum scphd_status {").unwrap();
        let (variants, _) = after.split_once("\n}").unwrap();
        assert_eq!(variants.matches(" = ").count(), scphd_status::ALL.len());
    }
}

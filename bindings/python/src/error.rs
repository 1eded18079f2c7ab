//! Exceptions, and their assignment to the errors of the library.

use crate::setting_name::keyword;
use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyValueError};
use pyo3::types::{PyAnyMethods, PyTypeMethods};
use pyo3::{Bound, PyAny, PyErr, create_exception};
use scphd::errors::{ConfigError, LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError};
use scphd::models::ModelError;
use scphd::snapshot::{RestoreError, SaveError};
use scphd_vehicle::{Refused, StartError};
use std::fmt::Display;

create_exception!(scphd, SettingError, PyValueError, "A setting is out of range, or does not fit the memory.");
create_exception!(
    scphd,
    InputError,
    PyValueError,
    "A control, a measurement or a pose is refused; the filter is as it was."
);
create_exception!(scphd, NotStartedError, PyRuntimeError, "The filter has not been reset to a pose yet.");
create_exception!(scphd, SnapshotError, PyValueError, "Bytes that are no snapshot of such a filter.");

/// An error of the library that Python sees as an exception.
pub trait Refusal {
    /// The exception, with the error message of the library.
    fn raised(self) -> PyErr;
}

macro_rules! refusals {
    ($($of:ty => |$error:ident| $exception:expr;)+) => {
        $(impl Refusal for $of {
            fn raised(self) -> PyErr {
                let $error = self;
                $exception
            }
        })+
    };
}

refusals! {
    ModelError => |error| setting(error);
    ConfigError => |error| setting(error);
    SetupError => |error| setting(error);
    ResetError => |error| match error {
        ResetError::NotStarted => NotStartedError::new_err(error.to_string()),
        _ => input(error),
    };
    PredictError => |error| match error {
        PredictError::NotStarted => not_started(),
        _ => input(error),
    };
    ScanError => |error| match error {
        ScanError::NotStarted => not_started(),
        ScanError::NoRoomForMoving => setting(error),
        _ => input(error),
    };
    ObserveError => |error| match error {
        ObserveError::NotStarted => not_started(),
        _ => input(error),
    };
    LoadMapError => |error| match error {
        LoadMapError::NotStarted => not_started(),
        _ => input(error),
    };
    StartError => |error| match error {
        StartError::Invalid(invalid) => setting(format!("{} must be {}", keyword(invalid.setting), invalid.setting.range())),
        _ => setting(error),
    };
}

impl<E: Refusal + Display> Refusal for Refused<E> {
    fn raised(self) -> PyErr {
        match self {
            Self::Filter(error) => error.raised(),
            error => setting(error),
        }
    }
}

impl<E: Display> Refusal for SaveError<E> {
    fn raised(self) -> PyErr {
        match self {
            Self::NotStarted => not_started(),
            error => SnapshotError::new_err(error.to_string()),
        }
    }
}

impl<E: Display> Refusal for RestoreError<E> {
    fn raised(self) -> PyErr {
        SnapshotError::new_err(self.to_string())
    }
}

fn setting(error: impl Display) -> PyErr {
    SettingError::new_err(error.to_string())
}

fn input(error: impl Display) -> PyErr {
    InputError::new_err(error.to_string())
}

/// The exception of a call before the first reset.
pub fn not_started() -> PyErr {
    NotStartedError::new_err("the filter has not been reset to a pose yet: call reset() first")
}

/// The exception of a parameter out of range, with its name in Python.
fn renamed(field: &str, range: &str, names: &[(&str, &str)]) -> PyErr {
    let name = names.iter().find(|(of_library, _)| *of_library == field).map_or(field, |(_, name)| name);
    SettingError::new_err(format!("{name} must be {range}"))
}

/// The exception of a model's parameter out of range.
pub fn of_model(error: ModelError, names: &[(&str, &str)]) -> PyErr {
    renamed(error.field, error.range, names)
}

/// The exception of an argument of the wrong type.
pub fn wrong_type(argument: &str, wanted: &str, found: &Bound<'_, PyAny>) -> PyErr {
    let found = found.get_type().name().map_or_else(|_| "another type".to_owned(), |name| name.to_string());
    PyTypeError::new_err(format!("{argument} must be {wanted}, not {found}"))
}

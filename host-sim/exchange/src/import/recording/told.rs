//! A message, and where it is.

use crate::import::ImportError;
use scphd_ros::{Channel, Message};
use std::fmt::Display;

/// A message and where it is, for errors.
pub(super) struct Told<'m> {
    pub(super) channel: &'m Channel,
    pub(super) data: &'m [u8],
    pub(super) log_time_ns: u64,
    pub(super) number: usize,
}

impl Told<'_> {
    pub(super) fn decode<M: Message>(&self) -> Result<M, ImportError> {
        self.channel.decode(self.data).map_err(|error| self.error(error))
    }

    pub(super) fn error(&self, what: impl Display) -> ImportError {
        ImportError::at(format_args!("{}, message {}", self.channel.topic, self.number), what)
    }

    /// A number that has to be one.
    pub(super) fn finite(&self, name: &str, number: f64) -> Result<f64, ImportError> {
        if number.is_finite() { Ok(number) } else { Err(self.error(format_args!("{name} is {number}"))) }
    }
}

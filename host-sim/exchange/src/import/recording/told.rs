//! A message, and where it is.

use crate::import::ImportError;
use scphd_ros::{Channel, Message};
use std::fmt::Display;

/// A message and where it is, for errors.
#[derive(Debug)]
pub struct Told<'m> {
    /// Its topic and its type.
    pub channel: &'m Channel,
    /// Its bytes.
    pub data: &'m [u8],
    /// When it was recorded, ns.
    pub log_time_ns: u64,
    /// Which of its topic, from 1.
    pub number: usize,
}

impl Told<'_> {
    /// The message.
    ///
    /// # Errors
    /// The bytes are none of this type.
    pub fn decode<M: Message>(&self) -> Result<M, ImportError> {
        self.channel.decode(self.data).map_err(|error| self.error(error))
    }

    /// An error that names the place.
    #[must_use]
    pub fn error(&self, what: impl Display) -> ImportError {
        ImportError::at(format_args!("{}, message {}", self.channel.topic, self.number), what)
    }

    /// A number that has to be one.
    ///
    /// # Errors
    /// It is infinite or NaN.
    pub fn finite(&self, name: &str, number: f64) -> Result<f64, ImportError> {
        if number.is_finite() { Ok(number) } else { Err(self.error(format_args!("{name} is {number}"))) }
    }
}

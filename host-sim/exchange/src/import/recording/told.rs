//! A message and its place in the file.

use crate::import::ImportError;
use scphd_ros::{Channel, Message};
use std::fmt::Display;

/// A message and its place, for errors.
#[derive(Debug)]
pub struct Told<'m> {
    /// Its topic and its type.
    pub channel: &'m Channel,
    pub data: &'m [u8],
    /// Time of recording, ns.
    pub log_time_ns: u64,
    /// Number of the message in its topic, from 1.
    pub number: usize,
}

impl Told<'_> {
    /// Decodes the message.
    pub fn decode<M: Message>(&self) -> Result<M, ImportError> {
        self.channel.decode(self.data).map_err(|error| self.error(error))
    }

    pub fn error(&self, what: impl Display) -> ImportError {
        ImportError::at(format_args!("{}, message {}", self.channel.topic, self.number), what)
    }

    /// Checks that a number is finite.
    pub fn finite(&self, name: &str, number: f64) -> Result<f64, ImportError> {
        if number.is_finite() { Ok(number) } else { Err(self.error(format_args!("{name} is {number}"))) }
    }
}

//! Writes an MCAP file.

use crate::cdr::{CdrError, encode};
use crate::definition::{Message, full_text};
use crate::time::Time;
use mcap::records::MessageHeader;
use mcap::{Attachment, McapError, WriteOptions};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Seek, Write};

#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// Error of the file system, or too many topics.
    #[error("{0}")]
    File(#[from] McapError),
    #[error("{0}")]
    Message(#[from] CdrError),
}

/// An MCAP file of the profile `ros2`, with uncompressed chunks and an index.
pub struct Writer<W: Write + Seek> {
    file: mcap::Writer<W>,
    /// By topic: the channel, and the number of messages.
    channels: BTreeMap<String, (u16, u32)>,
}

impl<W: Write + Seek> std::fmt::Debug for Writer<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Writer").field("channels", &self.channels).finish_non_exhaustive()
    }
}

impl<W: Write + Seek> Writer<W> {
    /// Starts an empty file; `library` is the name of the program.
    pub fn new(out: W, library: &str) -> Result<Self, WriteError> {
        let file = WriteOptions::new().compression(None).profile("ros2").library(library).create(out)?;
        Ok(Self { file, channels: BTreeMap::new() })
    }

    /// Adds a topic, which is in the file even without messages. With `latched`, late readers receive its last message.
    pub fn topic<M: Message>(&mut self, topic: &str, latched: bool) -> Result<(), WriteError> {
        if self.channels.contains_key(topic) {
            return Ok(());
        }
        let definition = M::DEFINITION;
        let schema = self.file.add_schema(definition.name, "ros2msg", full_text(definition).as_bytes())?;
        // As written by recorders: reliable, volatile or transient local.
        let quality = format!(
            "- history: 1\n  depth: 10\n  reliability: 1\n  durability: {}\n  deadline:\n    sec: 9223372036\n    nsec: 854775807\n  \
             lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  liveliness_lease_duration:\n    sec: 9223372036\n    \
             nsec: 854775807\n  avoid_ros_namespace_conventions: false\n",
            if latched { 1 } else { 2 }
        );
        let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), quality)]);
        let channel = self.file.add_channel(schema, topic, "cdr", &metadata)?;
        self.channels.insert(topic.to_owned(), (channel, 0));
        Ok(())
    }

    /// Writes a message that was sent and received at this time; adds its topic if necessary.
    pub fn write<M: Message>(&mut self, topic: &str, at: Time, message: &M) -> Result<(), WriteError> {
        self.topic::<M>(topic, false)?;
        let data = encode(message)?;
        let Some((channel, count)) = self.channels.get_mut(topic) else { return Ok(()) };
        let (log_time, sequence) = (at.nanoseconds(), *count);
        let header = MessageHeader { channel_id: *channel, sequence, log_time, publish_time: log_time };
        *count += 1;
        Ok(self.file.write_to_known_channel(&header, &data)?)
    }

    pub fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), WriteError> {
        let (name, media_type) = (name.to_owned(), media_type.to_owned());
        let attachment = Attachment { log_time: 0, create_time: 0, name, media_type, data: Cow::Borrowed(data) };
        Ok(self.file.attach(&attachment)?)
    }

    /// Ends the file, which cannot be read otherwise.
    pub fn finish(mut self) -> Result<W, WriteError> {
        self.file.finish()?;
        Ok(self.file.into_inner())
    }
}

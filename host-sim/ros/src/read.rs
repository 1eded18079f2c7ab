//! Reads an MCAP file from beginning to end, message by message.

use crate::cdr::{CdrError, decode};
use crate::definition::Message;
use crate::unpack::{self, LIMIT, unpack};
use mcap::records::{self, ChunkHeader, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Read};

/// Number of bytes that are requested from a file at once: a wrong length does not allocate memory for missing data.
const PIECE: usize = 1 << 16;
/// Size of the header of a record: its opcode and its length.
const HEAD: usize = 9;

/// Why a file cannot be read, with the place.
#[derive(Debug)]
pub struct ReadError {
    /// Number of bytes that had been read.
    pub byte: u64,
    pub messages: u64,
    pub problem: ReadProblem,
}

#[derive(Debug)]
pub enum ReadProblem {
    Io(io::Error),
    /// It does not begin with the magic bytes of MCAP.
    NoMcap,
    /// It is truncated.
    Torn,
    /// Any other violation of the format.
    Damaged(String),
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { byte, messages, problem } = self;
        match problem {
            ReadProblem::Io(error) => write!(f, "cannot be read after byte {byte}: {error}"),
            ReadProblem::NoMcap => write!(f, "no MCAP file: it does not begin as one"),
            ReadProblem::Torn => write!(f, "torn off at byte {byte}, after {messages} messages: it has no end"),
            ReadProblem::Damaged(what) => {
                write!(f, "damaged at or before byte {byte}, after {messages} messages: {what}")
            }
        }
    }
}

impl std::error::Error for ReadError {}

/// A topic with its message type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Channel {
    /// Its name.
    pub topic: String,
    /// The type of its messages, for example `nav_msgs/msg/Odometry`; empty if the file does not state it.
    pub kind: String,
    /// The encoding of its messages: `cdr` for ROS 2.
    pub encoding: String,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Record {
    Channel(u16),
    Message {
        channel: u16,
        /// Time of reception, ns.
        log_time_ns: u64,
        data: Vec<u8>,
    },
    Attachment {
        name: String,
        data: Vec<u8>,
    },
}

/// Reads a file; call [`next`](Self::next) until it returns `None`.
pub struct Reader<R> {
    source: R,
    file: LinearReader,
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    /// The records of the present chunk, and the number of bytes read from it.
    chunk: (Vec<u8>, usize),
    byte: u64,
    messages: u64,
}

impl<R> fmt::Debug for Reader<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { channels, byte, messages, .. } = self;
        f.debug_struct("Reader").field("channels", channels).field("byte", byte).field("messages", messages).finish()
    }
}

/// A record of the file, copied out of the reader.
enum Raw {
    Asks(usize),
    Record(u8, Vec<u8>),
    End,
}

impl<R: Read> Reader<R> {
    /// Reads `source` from its present position.
    pub fn new(source: R) -> Self {
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            // A limit for chunks too, because data are read in pieces.
            .with_record_length_limit(LIMIT as usize);
        Self {
            source,
            file: LinearReader::new_with_options(options),
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            chunk: (Vec::new(), 0),
            byte: 0,
            messages: 0,
        }
    }

    /// The channel with this number; there is one for every [`Record`] that refers to it.
    pub fn channel(&self, number: u16) -> Option<&Channel> {
        self.channels.get(&number)
    }

    /// The next topic, message or attached file; `None` at the end.
    #[expect(clippy::should_implement_trait, reason = "an iterator would go on after an error")]
    pub fn next(&mut self) -> Result<Option<Record>, ReadError> {
        loop {
            if let Some((opcode, body)) = self.of_chunk()? {
                if let Some(record) = self.record(opcode, &body)? {
                    return Ok(Some(record));
                }
                continue;
            }
            match self.raw()? {
                Raw::Asks(bytes) => {
                    let room = self.file.insert(bytes.min(PIECE));
                    let read = loop {
                        match self.source.read(room) {
                            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                            other => break other,
                        }
                    };
                    let read = read.map_err(|error| self.error(ReadProblem::Io(error)))?;
                    self.file.notify_read(read);
                    self.byte += read as u64;
                }
                Raw::Record(op::CHUNK, body) => self.open(&body)?,
                Raw::Record(opcode, body) => {
                    if let Some(record) = self.record(opcode, &body)? {
                        return Ok(Some(record));
                    }
                }
                Raw::End => return Ok(None),
            }
        }
    }

    fn error(&self, problem: ReadProblem) -> ReadError {
        ReadError { byte: self.byte, messages: self.messages, problem }
    }

    fn damaged(&self, what: impl Into<String>) -> ReadError {
        self.error(ReadProblem::Damaged(what.into()))
    }

    fn raw(&mut self) -> Result<Raw, ReadError> {
        let raw = match self.file.next_event() {
            None => return Ok(Raw::End),
            Some(Ok(LinearReadEvent::ReadRequest(bytes))) => return Ok(Raw::Asks(bytes)),
            Some(Ok(LinearReadEvent::Record { opcode, data })) => Ok(Raw::Record(opcode, data.to_vec())),
            Some(Err(error)) => Err(error),
        };
        raw.map_err(|error| match error {
            mcap::McapError::BadMagic if self.byte <= mcap::MAGIC.len() as u64 => self.error(ReadProblem::NoMcap),
            mcap::McapError::UnexpectedEof if self.byte < mcap::MAGIC.len() as u64 => self.error(ReadProblem::NoMcap),
            mcap::McapError::UnexpectedEof => self.error(ReadProblem::Torn),
            other => self.damaged(other.to_string()),
        })
    }

    fn open(&mut self, body: &[u8]) -> Result<(), ReadError> {
        let record = mcap::parse_record(op::CHUNK, body).map_err(|error| self.damaged(error.to_string()))?;
        let records::Record::Chunk { header, data } = record else { return Ok(()) };
        let ChunkHeader { compression, uncompressed_size, uncompressed_crc, .. } = header;
        let inside = unpack(&compression, &data, uncompressed_size).map_err(|what| self.damaged(what))?;
        if uncompressed_crc != 0 && crc32fast::hash(&inside) != uncompressed_crc {
            return Err(self.damaged("a chunk is not what its checksum says"));
        }
        self.chunk = (inside, 0);
        Ok(())
    }

    /// The next record of the present chunk.
    fn of_chunk(&mut self) -> Result<Option<(u8, Vec<u8>)>, ReadError> {
        let (inside, at) = (&self.chunk.0, self.chunk.1);
        let rest = inside.get(at..).unwrap_or_default();
        if rest.is_empty() {
            return Ok(None);
        }
        let torn = || self.damaged("a chunk ends in the middle of a record");
        let (head, rest) = rest.split_first_chunk::<HEAD>().ok_or_else(torn)?;
        let [opcode, length @ ..] = *head;
        let length = usize::try_from(u64::from_le_bytes(length)).map_err(|_| torn())?;
        let body = rest.get(..length).ok_or_else(torn)?.to_vec();
        self.chunk.1 = at + HEAD + length;
        Ok(Some((opcode, body)))
    }

    /// The content of a record; `None` if it is not used.
    fn record(&mut self, opcode: u8, body: &[u8]) -> Result<Option<Record>, ReadError> {
        let read = match opcode {
            op::SCHEMA | op::CHANNEL | op::MESSAGE | op::ATTACHMENT => mcap::parse_record(opcode, body),
            _ => return Ok(None),
        };
        match read.map_err(|error| self.damaged(error.to_string()))? {
            records::Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
                Ok(None)
            }
            records::Record::Channel(channel) => {
                let records::Channel { id, schema_id, topic, message_encoding, .. } = channel;
                let kind = match self.schemas.get(&schema_id) {
                    Some(kind) => kind.clone(),
                    None if schema_id == 0 => String::new(),
                    None => {
                        return Err(self.damaged(format!("topic '{topic}' is of a type that the file does not have")));
                    }
                };
                let channel = Channel { topic, kind, encoding: message_encoding };
                // At the end of a file all channels are repeated.
                if self.channels.get(&id) == Some(&channel) {
                    return Ok(None);
                }
                self.channels.insert(id, channel);
                Ok(Some(Record::Channel(id)))
            }
            records::Record::Message { header, data } => {
                if !self.channels.contains_key(&header.channel_id) {
                    return Err(self.damaged(format!("a message of the unknown topic {}", header.channel_id)));
                }
                self.messages += 1;
                let data = data.into_owned();
                Ok(Some(Record::Message { channel: header.channel_id, log_time_ns: header.log_time, data }))
            }
            records::Record::Attachment { header, data, .. } => {
                Ok(Some(Record::Attachment { name: header.name, data: data.into_owned() }))
            }
            _ => Ok(None),
        }
    }
}

impl Channel {
    /// Decodes a message, which may be compressed separately with zstd or lz4.
    pub fn decode<M: Message>(&self, data: &[u8]) -> Result<M, CdrError> {
        if self.encoding != "cdr" {
            let what = format!("messages are encoded as '{}', where ROS 2 has 'cdr'", self.encoding);
            return Err(CdrError::Content(what));
        }
        if self.kind != M::DEFINITION.name {
            return Err(CdrError::Content(format!("messages are {}, not {}", self.kind, M::DEFINITION.name)));
        }
        decode(&unpack::message(data).map_err(CdrError::Content)?)
    }
}

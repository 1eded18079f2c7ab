//! Decompression of chunks, messages and files, for the compressions that recorders use.

use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};
use std::borrow::Cow;
use std::io::{self, Read};

/// Greatest size of a decompressed chunk or message, bytes.
pub(crate) const LIMIT: u64 = 1 << 30;
/// The first bytes of a frame of Zstandard (RFC 8878) and of LZ4. No message begins with them: the first byte of its header is 0.
const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];
const LZ4: [u8; 4] = [0x04, 0x22, 0x4d, 0x18];

/// The records of a chunk; its header states their size.
pub(crate) fn unpack(compression: &str, packed: &[u8], size: u64) -> Result<Vec<u8>, String> {
    if size > LIMIT {
        return Err(format!("a chunk of {size} bytes, more than {LIMIT}"));
    }
    let mut records = Vec::new();
    // One byte more is requested to check that there is none.
    let read = match compression {
        "" => packed.take(size + 1).read_to_end(&mut records),
        "lz4" => lz4_flex::frame::FrameDecoder::new(packed).take(size + 1).read_to_end(&mut records),
        "zstd" => Frames::new(packed).take(size + 1).read_to_end(&mut records),
        other => return Err(format!("a chunk is compressed with '{other}'; known are zstd and lz4")),
    };
    read.map_err(|error| format!("a chunk cannot be unpacked: {error}"))?;
    if records.len() as u64 == size {
        Ok(records)
    } else {
        Err(format!("a chunk has not the {size} bytes that its head says"))
    }
}

/// The bytes of a message, which `ros2 bag record --compression-mode message` compresses separately.
pub fn message(data: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    if !(data.starts_with(&ZSTD) || data.starts_with(&LZ4)) {
        return Ok(Cow::Borrowed(data));
    }
    let mut bytes = Vec::new();
    let cannot = |error| format!("a compressed message cannot be unpacked: {error}");
    let source = unpacked(io::Cursor::new(data.to_vec())).map_err(cannot)?;
    source.take(LIMIT + 1).read_to_end(&mut bytes).map_err(cannot)?;
    if bytes.len() as u64 > LIMIT {
        return Err(format!("a compressed message of more than {LIMIT} bytes"));
    }
    Ok(Cow::Owned(bytes))
}

/// The contents of a file, decompressed if the whole file is compressed with zstd or lz4, as by
/// `ros2 bag record --compression-mode file`.
pub fn unpacked<R: Read + 'static>(mut source: R) -> io::Result<Box<dyn Read>> {
    let mut head = Vec::new();
    source.by_ref().take(4).read_to_end(&mut head)?;
    let (zstd, lz4) = (head == ZSTD, head == LZ4);
    let whole = io::Cursor::new(head).chain(source);
    Ok(if zstd {
        Box::new(Frames::new(whole))
    } else if lz4 {
        Box::new(lz4_flex::frame::FrameDecoder::new(whole))
    } else {
        Box::new(whole)
    })
}

/// Consecutive frames of Zstandard. Skippable frames between them are skipped.
struct Frames<R> {
    source: R,
    frame: FrameDecoder,
    /// Whether a frame has been started and not read completely.
    begun: bool,
}

impl<R: Read> Frames<R> {
    fn new(source: R) -> Self {
        Self { source, frame: FrameDecoder::new(), begun: false }
    }

    /// Starts the next frame. Returns whether there is one.
    fn begin(&mut self) -> io::Result<bool> {
        loop {
            let mut head = Vec::new();
            self.source.by_ref().take(4).read_to_end(&mut head)?;
            if head.is_empty() {
                return Ok(false);
            }
            match self.frame.init(head.as_slice().chain(self.source.by_ref())) {
                Ok(()) => return Ok(true),
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame { length, .. })) => {
                    let length = u64::from(length);
                    if io::copy(&mut self.source.by_ref().take(length), &mut io::sink())? < length {
                        return Err(io::ErrorKind::UnexpectedEof.into());
                    }
                }
                Err(error) => return Err(io::Error::other(error)),
            }
        }
    }
}

impl<R: Read> Read for Frames<R> {
    fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
        if room.is_empty() {
            return Ok(0);
        }
        loop {
            if !self.begun {
                if !self.begin()? {
                    return Ok(0);
                }
                self.begun = true;
            }
            let read = self.frame.read(room)?;
            if read > 0 {
                return Ok(read);
            }
            if self.frame.is_finished() {
                self.begun = false;
            } else {
                let one = BlockDecodingStrategy::UptoBlocks(1);
                self.frame.decode_blocks(&mut self.source, one).map_err(io::Error::other)?;
            }
        }
    }
}

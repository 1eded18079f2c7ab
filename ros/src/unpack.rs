//! What a chunk holds, of the compressions that recorders use.

use std::io::Read;

/// Bytes of a chunk that are made room for, at most.
pub(crate) const LIMIT: u64 = 1 << 30;

/// The records of a chunk, of which its head says how many bytes they are.
pub(crate) fn unpack(compression: &str, packed: &[u8], size: u64) -> Result<Vec<u8>, String> {
    if size > LIMIT {
        return Err(format!("a chunk of {size} bytes, more than {LIMIT}"));
    }
    let mut records = Vec::new();
    // One more, to see that there is none.
    let read = match compression {
        "" => packed.take(size + 1).read_to_end(&mut records),
        "lz4" => lz4_flex::frame::FrameDecoder::new(packed).take(size + 1).read_to_end(&mut records),
        "zstd" => {
            let frame = ruzstd::decoding::StreamingDecoder::new(packed).map_err(|error| error.to_string())?;
            frame.take(size + 1).read_to_end(&mut records)
        }
        other => return Err(format!("a chunk is compressed with '{other}'; known are zstd and lz4")),
    };
    read.map_err(|error| format!("a chunk cannot be unpacked: {error}"))?;
    if records.len() as u64 == size {
        Ok(records)
    } else {
        Err(format!("a chunk has not the {size} bytes that its head says"))
    }
}

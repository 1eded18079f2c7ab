//! Files are written and read; damaged data give an error with its place, never a panic.

use scphd_ros::messages::{Header, PointCloud2, PoseStamped};
use scphd_ros::{Channel, ReadError, ReadProblem, Reader, Record, Time, Writer, cloud, encode, unpacked};
use std::io::{Cursor, Read, Write};

fn pose(k: u32) -> (Time, PoseStamped) {
    let at = Time { sec: 7, nanosec: k };
    let mut message = PoseStamped { header: Header::new(at, "map"), ..PoseStamped::default() };
    message.pose.position.x = f64::from(k);
    (at, message)
}

fn file(poses: u32) -> Vec<u8> {
    let mut writer = Writer::new(Cursor::new(Vec::new()), "test").unwrap();
    writer.attach("log.toml", "application/toml", b"name = \"n\"").unwrap();
    writer.topic::<PointCloud2>("/silent", true).unwrap();
    for k in 0..poses {
        let (at, message) = pose(k);
        writer.write("/pose", at, &message).unwrap();
        let points = [([1.0, 2.0, 3.0], [f64::from(k)])];
        writer.write("/cloud", at, &cloud(message.header, ["x", "y", "z"], ["range"], points)).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

#[derive(Debug, Default, PartialEq)]
struct Content {
    channels: Vec<(u16, Channel)>,
    messages: Vec<(u16, u64, Vec<u8>)>,
    attachments: Vec<(String, Vec<u8>)>,
}

fn read(bytes: &[u8]) -> Result<Content, ReadError> {
    let (mut reader, mut content) = (Reader::new(bytes), Content::default());
    while let Some(record) = reader.next()? {
        match record {
            Record::Channel(id) => content.channels.push((id, reader.channel(id).unwrap().clone())),
            Record::Message { channel, log_time_ns, data } => content.messages.push((channel, log_time_ns, data)),
            Record::Attachment { name, data } => content.attachments.push((name, data)),
        }
    }
    Ok(content)
}

#[test]
fn everything_written_is_read() {
    let content = read(&file(3)).unwrap();
    let topics: Vec<&str> = content.channels.iter().map(|(_, channel)| &channel.topic[..]).collect();
    assert_eq!(topics, ["/silent", "/pose", "/cloud"]);
    assert_eq!(content.messages.len(), 6);
    assert_eq!(content.attachments, [("log.toml".to_owned(), b"name = \"n\"".to_vec())]);
    let (id, channel) = &content.channels[1];
    let mine = content.messages.iter().filter(|(of, ..)| of == id);
    for ((_, log_time_ns, data), k) in mine.zip(0..) {
        let (at, message) = pose(k);
        assert_eq!((*log_time_ns, channel.decode::<PoseStamped>(data).unwrap()), (at.nanoseconds(), message));
        assert!(channel.decode::<PointCloud2>(data).unwrap_err().to_string().contains("geometry_msgs/msg/PoseStamped"));
    }
}

#[test]
fn many_messages_are_in_several_chunks() {
    assert_eq!(read(&file(20_000)).unwrap().messages.len(), 40_000);
}

#[test]
fn a_truncated_file_gives_an_error_with_the_place() {
    let whole = file(3);
    let mut most = 0;
    for length in 0..whole.len() {
        let error = read(&whole[..length]).unwrap_err();
        assert!(error.byte as usize <= length);
        most = most.max(error.messages);
        match error.problem {
            ReadProblem::NoMcap => assert!(length < 8),
            ReadProblem::Torn => assert!(error.to_string().contains(&format!("at byte {length}")), "{error}"),
            other => panic!("{length}: {other:?}"),
        }
    }
    assert_eq!(most, 6);
}

/// With any damage there is no panic, no memory for missing data, and an error or the same contents.
#[test]
fn a_damaged_file_never_panics() {
    let whole = file(3);
    let good = read(&whole).unwrap();
    let (mut refused, mut other) = (0, 0);
    let mut judge = |bytes: &[u8]| match read(bytes) {
        Err(error) => {
            assert!(!error.to_string().is_empty());
            refused += 1;
        }
        Ok(content) => other += u32::from(content.messages != good.messages),
    };
    for place in 0..whole.len() {
        for change in [0x01, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[place] ^= change;
            judge(&bytes);
        }
    }
    // Numbers of eight bytes at any place: lengths, counts, offsets.
    for place in 0..whole.len() - 8 {
        for number in [0_u64, 1 << 20, 1 << 40, u64::MAX] {
            let mut bytes = whole.clone();
            bytes[place..place + 8].copy_from_slice(&number.to_le_bytes());
            judge(&bytes);
        }
    }
    println!("{refused} refused, {other} with other messages");
    // Chunks with their messages and the file have checksums.
    assert_eq!(other, 0);
    assert!(refused > whole.len());
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

/// A file with one chunk, written according to the format.
fn with_chunk(compression: &str, pack: impl Fn(&[u8]) -> Vec<u8>, size: impl Fn(usize) -> u64) -> Vec<u8> {
    let schema =
        [&1_u16.to_le_bytes()[..], &text("geometry_msgs/msg/PoseStamped"), &text("ros2msg"), &text("")].concat();
    let channel = [&[4, 0, 1, 0][..], &text("/pose"), &text("cdr"), &text("")].concat();
    let (at, message) = pose(5);
    let at = at.nanoseconds().to_le_bytes();
    let message = [&[4, 0, 0, 0, 0, 0][..], &at, &at, &encode(&message).unwrap()].concat();
    let inside = [record(3, &schema), record(4, &channel), record(5, &message)].concat();
    let packed = pack(&inside);
    let head = [&at[..], &at, &size(inside.len()).to_le_bytes(), &crc32fast::hash(&inside).to_le_bytes()].concat();
    let chunk = [&head, &text(compression), &(packed.len() as u64).to_le_bytes()[..], &packed].concat();
    let magic = b"\x89MCAP0\r\n";
    let header = record(1, &[text("ros2"), text("")].concat());
    let ends = [record(15, &[0; 4]), record(2, &[0; 20])].concat();
    [&magic[..], &header, &record(6, &chunk), &ends, magic].concat()
}

fn zstd(inside: &[u8]) -> Vec<u8> {
    ruzstd::encoding::compress_to_vec(inside, ruzstd::encoding::CompressionLevel::Fastest)
}

fn lz4(inside: &[u8]) -> Vec<u8> {
    let mut packed = lz4_flex::frame::FrameEncoder::new(Vec::new());
    packed.write_all(inside).unwrap();
    packed.finish().unwrap()
}

#[test]
fn compressed_chunks_are_read() {
    for bytes in [
        with_chunk("", <[u8]>::to_vec, |size| size as u64),
        with_chunk("zstd", zstd, |size| size as u64),
        with_chunk("lz4", lz4, |size| size as u64),
    ] {
        let content = read(&bytes).unwrap();
        let (_, channel) = &content.channels[0];
        let [(4, ns, data)] = &content.messages[..] else { panic!("{content:?}") };
        assert_eq!((*ns, channel.decode::<PoseStamped>(data).unwrap()), (7_000_000_005, pose(5).1));
    }
}

#[test]
fn a_chunk_that_contradicts_its_header_is_refused() {
    let wrong = [
        (with_chunk("brotli", <[u8]>::to_vec, |size| size as u64), "'brotli'; known are zstd and lz4"),
        (with_chunk("zstd", <[u8]>::to_vec, |size| size as u64), "at or before byte"),
        (with_chunk("lz4", zstd, |size| size as u64), "cannot be unpacked"),
        (with_chunk("zstd", zstd, |size| size as u64 - 1), "has not the"),
        (with_chunk("lz4", lz4, |size| size as u64 + 1), "has not the"),
        (with_chunk("zstd", zstd, |_| u64::MAX), "more than"),
        (with_chunk("", |_| Vec::new(), |size| size as u64), "has not the"),
        (with_chunk("", |inside| inside[..inside.len() - 1].to_vec(), |size| size as u64 - 1), "checksum"),
    ];
    for (bytes, expected) in wrong {
        let error = read(&bytes).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    for (compression, pack) in [("zstd", zstd as fn(&[u8]) -> Vec<u8>), ("lz4", lz4)] {
        let whole = with_chunk(compression, pack, |size| size as u64);
        for place in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[place] ^= 0x55;
            let _ = read(&bytes);
        }
    }
}

/// Two frames of Zstandard with a skippable one between them.
fn frames(bytes: &[u8]) -> Vec<u8> {
    let (first, second) = bytes.split_at(bytes.len() / 2);
    [zstd(first), vec![0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0, 1, 2, 3], zstd(second)].concat()
}

#[test]
fn whole_files_are_decompressed() {
    let whole = file(5_000);
    for (name, packed) in [("plain", whole.clone()), ("zstd", frames(&whole)), ("lz4", lz4(&whole)), ("", vec![])] {
        let mut read = Vec::new();
        unpacked(Cursor::new(packed.clone())).unwrap().read_to_end(&mut read).unwrap();
        assert!(read == if name.is_empty() { &[][..] } else { &whole }, "{name}");
        if name == "zstd" {
            // Truncation inside a frame gives an error, never a shorter file.
            let torn = |length: usize| unpacked(Cursor::new(packed[..length].to_vec()))?.read_to_end(&mut Vec::new());
            let first = zstd(&whole[..whole.len() / 2]).len();
            assert!((4..first).step_by(first / 100).all(|length| torn(length).is_err()));
        }
    }
}

#[test]
fn separately_compressed_messages_are_read() {
    let (at, message) = pose(7);
    let bytes = encode(&message).unwrap();
    let kind = "geometry_msgs/msg/PoseStamped".to_owned();
    let channel = Channel { topic: "/pose".into(), kind, encoding: "cdr".into() };
    for packed in [bytes.clone(), frames(&bytes), lz4(&bytes)] {
        assert_eq!(channel.decode::<PoseStamped>(&packed).unwrap(), message, "{at:?}");
    }
    let mut torn = zstd(&bytes);
    torn.truncate(20);
    let error = channel.decode::<PoseStamped>(&torn).unwrap_err().to_string();
    assert!(error.contains("a compressed message cannot be unpacked"), "{error}");
}

//! Frames over a faulty line: damaged ones are rejected, and the state of the filter is that of a run without those frames.

use scphd_boards::hil::{Rates, Trouble};
use scphd_boards::stream::{self, Recorded};
use scphd_filters::settings::Settings;
use scphd_link::{
    Frame, FrameKind, Gaps, OVERHEAD, Received, Receiver, Refused, Report, Sender, Target, Unit, line_bytes,
};
use scphd_log::noise::Noise;
use scphd_stream::planar::{BlackBox, BlackBoxJoint, Planar};
use scphd_stream::{Aboard, Filter, Monitor, Reader, Record, Scalar, ScanCost, Seen, pieces};
use scphd_tests::with_roomy_stack;
use scphd_worlds::scenario;
use std::collections::BTreeSet;
use std::convert::Infallible;

const FRAMES: usize = 10_000;
pub(crate) const LONGEST: usize = 2048;

/// A line in memory: one end writes, the other one reads.
#[derive(Default)]
pub(crate) struct Wire {
    pub(crate) bytes: Vec<u8>,
    read: usize,
    /// Bytes written by the reading end.
    back: Vec<u8>,
}

impl embedded_io::ErrorType for Wire {
    type Error = Infallible;
}

impl embedded_io::Read for Wire {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        let left = &self.bytes[self.read..];
        let len = left.len().min(buffer.len());
        buffer[..len].copy_from_slice(&left[..len]);
        self.read += len;
        Ok(len)
    }
}

impl embedded_io::Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.back.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// The frame of a record or of the header, as bytes on the line.
fn framed(sender: &mut Sender<{ line_bytes(LONGEST) }>, number: usize, content: &[u8]) -> Vec<u8> {
    let mut wire = Wire::default();
    sender.again(&mut wire, number as u32, content, None).unwrap();
    wire.back
}

/// The bytes received from a faulty line, and the indices of intact frames in the order of arrival.
pub(crate) struct Arrived {
    pub(crate) wire: Vec<u8>,
    intact: Vec<usize>,
}

impl Arrived {
    /// Number of spans between zeros that are not intact frames.
    fn damaged(&self) -> usize {
        let spans = self.wire.split(|&byte| byte == 0).filter(|span| !span.is_empty());
        spans.count() - self.intact.len()
    }
}

/// Sends frames over a line with these error rates; the first frame is sent without errors.
pub(crate) fn sent(session: u16, contents: &[impl AsRef<[u8]>], rates: Rates, seed: u64) -> Arrived {
    let (mut sender, mut trouble) = (Sender::new(session), Trouble::new(rates, seed));
    let mut arrived = Arrived { wire: Vec::new(), intact: Vec::new() };
    let frames: Vec<Vec<u8>> =
        contents.iter().enumerate().map(|(number, content)| framed(&mut sender, number, content.as_ref())).collect();
    for (number, frame) in frames.iter().enumerate() {
        if number == 0 {
            arrived.wire.extend(frame);
            arrived.intact.push(0);
            continue;
        }
        trouble.pass(frame, |bytes| {
            arrived.wire.extend(bytes);
            // The frames are all different, so that a delayed one is identified by its bytes.
            arrived.intact.extend(frames.iter().position(|frame| frame == bytes));
        });
    }
    arrived
}

/// The frames that a receiver has to accept, and its counts, by their numbers only.
fn model(arrived: &Arrived) -> (Vec<usize>, Report) {
    let (mut accepted, mut report) = (Vec::new(), Report::default());
    for &number in &arrived.intact {
        match accepted.last() {
            Some(&last) if number > last => {
                report.lost += (number - last - 1) as u32;
                accepted.push(number);
            }
            // The line delays by at most three frames, which the receiver remembers.
            Some(_) if accepted.contains(&number) => report.doubled += 1,
            Some(_) => report.late += 1,
            None => accepted.push(number),
        }
    }
    report.accepted = accepted.len() as u32;
    report.damaged = arrived.damaged() as u32;
    (accepted, report)
}

/// Random contents of all lengths, all different, with many zeros.
fn contents(seed: u64) -> Vec<Vec<u8>> {
    let mut noise = Noise::new(seed);
    let content = |number: usize| {
        let len = (noise.uniform() * 300.0) as usize;
        let random = (0..len).map(|_| (noise.uniform() * 300.0).max(44.0) as u8);
        number.to_le_bytes().into_iter().chain(random).collect()
    };
    (0..FRAMES).map(content).collect()
}

#[test]
fn every_damaged_frame_is_refused_and_every_other_taken() {
    let contents = contents(1);
    let all = Rates { lose: 0.01, flip: 0.01, double: 0.01, late: 0.01 };
    for (rates, seed) in [(all, 11), (Rates { flip: 0.001, ..all }, 12), (Rates::default(), 13)] {
        let arrived = sent(3, &contents, rates, seed);
        let (accepted, expected) = model(&arrived);
        let mut receiver = Receiver::<LONGEST>::new(Gaps::Passed);
        let (mut line, mut taken) = (&arrived.wire[..], Vec::new());
        while let Some(received) = receiver.receive(&mut line).unwrap() {
            if let Received::Frame { frame: Frame { number, content, .. }, .. } = received {
                assert_eq!(content, contents[number as usize], "frame {number}");
                taken.push(number as usize);
            }
        }
        assert_eq!(receiver.report(), expected);
        assert_eq!(taken, accepted);
        assert!(rates.flip == 0.0 || expected.damaged > 1000 && expected.doubled > 0 && expected.late > 0);
    }
}

#[test]
fn a_frame_that_is_too_long_is_rejected_and_the_next_one_accepted() {
    let contents = [vec![1; 5], vec![2; 200], vec![3; 201], vec![4; 900], vec![5; 200]];
    let arrived = sent(3, &contents, Rates::default(), 1);
    let mut receiver = Receiver::<{ 200 + OVERHEAD }>::new(Gaps::Passed);
    let mut line = &arrived.wire[..];
    let mut seen = Vec::new();
    while let Some(received) = receiver.receive(&mut line).unwrap() {
        seen.push(match received {
            Received::Frame { frame, lost } => Ok((frame.number, lost)),
            Received::Refused { why, .. } => Err(why),
        });
    }
    assert_eq!(seen, [Ok((0, 0)), Ok((1, 0)), Err(Refused::TooLong), Err(Refused::TooLong), Ok((4, 2))]);
    assert_eq!(receiver.report().refused(), 2);
}

/// Noise is rejected, and the first frame after it accepted.
#[test]
fn noise_is_not_a_frame() {
    let mut noise = Noise::new(5);
    let mut wire: Vec<u8> = (0..200_000).map(|_| (noise.uniform() * 256.0) as u8).collect();
    wire.extend(framed(&mut Sender::new(9), 0, b"head"));
    let mut receiver = Receiver::<LONGEST>::new(Gaps::Refused);
    let mut line = &wire[..];
    let mut frames = 0;
    while let Some(received) = receiver.receive(&mut line).unwrap() {
        if let Received::Frame { frame, .. } = received {
            assert_eq!((frame.kind, frame.session, frame.content), (FrameKind::Head, 9, &b"head"[..]));
            frames += 1;
        }
    }
    assert!(frames == 1 && receiver.report().damaged > 500);
}

/// Digest after every scan.
#[derive(Default)]
pub(crate) struct Digests(pub(crate) Vec<u64>);

impl Monitor for Digests {
    fn scanned(&mut self, _: &ScanCost, _: &Seen, digest: u64) {
        self.0.push(digest);
    }
}

fn survey(seed: u64, filter: Recorded) -> Vec<u8> {
    let log = scenario::survey(seed);
    let mut settings = Settings::for_log(&log);
    (settings.filter.particles, settings.filter.samples) = (4, 1);
    stream::write(&log, &settings, filter, seed, Scalar::F32, usize::MAX).unwrap().bytes
}

/// The digests of a filter for these records, read from the stream directly; the header has number 0.
fn fed<A: Aboard<f32, Kind = Planar>>(bytes: &[u8], accepted: &BTreeSet<usize>) -> Vec<u64> {
    let mut reader = Reader::<Planar>::open(bytes).unwrap();
    let mut memory = Box::new(A::MEMORY);
    let mut filter = A::start(&reader.header(), &mut memory).unwrap();
    let (mut digests, mut number) = (Vec::new(), 0);
    while let Some(record) = reader.read().unwrap() {
        number += 1;
        if !accepted.contains(&number) {
            continue;
        }
        match record {
            Record::Predict(input) => filter.predict(&input).unwrap(),
            Record::Scan(measurements) => {
                let scan = filter.receive(measurements);
                filter.scan(scan).unwrap();
                filter.estimate();
                digests.push(filter.digest());
            }
            other => panic!("{other:?}"),
        }
    }
    digests
}

/// Sends surveys over a faulty line to a target, each as a session. Returns the numbers of frames and scans sent, and of scans
/// accepted.
fn state_is_that_of_what_was_taken<A: Aboard<f32, Kind = Planar>>(
    filter: Recorded,
    seeds: std::ops::Range<u64>,
    rates: Rates,
) -> [usize; 3] {
    let (mut wire, mut expected, mut counts) = (Wire::default(), Vec::new(), [0; 3]);
    let mut damaged = 0;
    for seed in seeds {
        let bytes = survey(seed, filter);
        let records: Vec<&[u8]> = pieces::<Planar>(&bytes).collect();
        let arrived = sent(seed as u16, &records, rates, seed);
        let (accepted, report) = model(&arrived);
        let digests = fed::<A>(&bytes, &accepted.into_iter().collect());
        counts[0] += records.len();
        counts[1] += Reader::<Planar>::open(&bytes).unwrap().header().scans as usize;
        counts[2] += digests.len();
        damaged += report.damaged;
        expected.extend(digests);
        wire.bytes.extend(arrived.wire);
    }
    let (mut memory, mut digests) = (Box::new(A::MEMORY), Digests::default());
    let mut target = Target::<LONGEST, 256>::new(Gaps::Passed);
    target.serve::<A, f32, _>(&mut wire, &mut memory, Unit::Nanoseconds, &mut digests).unwrap();
    assert!(damaged > 0 && wire.back.is_empty(), "nobody asked");
    assert_eq!(digests.0, expected);
    counts
}

#[test]
fn the_state_is_that_of_a_run_without_the_frames_that_were_hit() {
    let rates = Rates { lose: 0.01, flip: 0.01, ..Rates::default() };
    let [frames, scans, taken] =
        with_roomy_stack(|| state_is_that_of_what_was_taken::<BlackBoxJoint>(Recorded::Joint, 1..7, rates));
    assert!(frames >= FRAMES && taken > 0 && taken < scans, "{frames} frames, {taken} of {scans} scans");
    // With lower error rates, and for a mixture.
    let rates = Rates { lose: 0.01, flip: 0.001, double: 0.01, late: 0.01 };
    let [_, scans, taken] =
        with_roomy_stack(|| state_is_that_of_what_was_taken::<BlackBox>(Recorded::Mixture, 7..8, rates));
    assert!(2 * taken > scans && taken < scans, "{taken} of {scans} scans");
}

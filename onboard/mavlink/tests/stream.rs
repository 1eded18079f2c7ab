//! Bytes in arbitrary chunks, with other bytes between the messages: every byte is counted, and nothing panics.

use proptest::prelude::*;
use scphd_mavlink::{
    Heartbeat, Incoming, MapFrame, Odometry, Origin, Pose, Receiver, Report, ResetCounter, Sender, TimeSync, Twist,
};

/// LANDING_TARGET as written by pymavlink 2.4.50: number 3, 0.5 m ahead, 0.25 m to the left and 0.125 m up.
const TARGET: [u8; 72] = [
    0xfd, 0x3c, 0x00, 0x00, 0x00, 0x03, 0x01, 0x95, 0x00, 0x00, 0x40, 0x42, 0x0f, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x03, 0x0c, 0x00, 0x00, 0x00, 0x3f, 0x00, 0x00, 0x80, 0xbe, 0x00, 0x00, 0x00, 0xbe, 0x00, 0x00, 0x80, 0x3f, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x01, 0x0a, 0xa7,
];

fn numbers<const N: usize>() -> impl Strategy<Value = [f32; N]> {
    prop::collection::vec(-1e3..1e3_f32, N).prop_map(|numbers| numbers.try_into().unwrap())
}

fn odometry() -> impl Strategy<Value = Odometry> {
    let frame = prop_oneof![Just(MapFrame::Local), Just(MapFrame::EastNorth)];
    let turned = (-3.0..3.0_f32, -1.5..1.5_f32, -3.0..3.0_f32).prop_map(<[f32; 3]>::from);
    let speeds = prop::option::of((numbers(), numbers()));
    (any::<u64>(), frame, numbers(), turned, speeds, any::<u8>()).prop_map(
        |(time_us, frame, position_m, attitude_rad, speeds, reset_counter)| {
            let twist = speeds.map(|(velocity_mps, rates_radps)| Twist { velocity_mps, rates_radps, covariance: None });
            Odometry { time_us, frame, pose: Pose { position_m, attitude_rad, covariance: None }, twist, reset_counter }
        },
    )
}

/// All messages in the bytes, in chunks of this length.
fn received(bytes: &[u8], chunk: usize) -> (Vec<Incoming>, Report, usize) {
    let (mut receiver, mut messages) = (Receiver::new(), Vec::new());
    for mut chunk in bytes.chunks(chunk) {
        while let Some(received) = receiver.read(&mut chunk) {
            messages.push(received.message);
        }
        assert!(chunk.is_empty());
    }
    (messages, receiver.report(), receiver.waiting())
}

/// Checks that both are equal, except for rounding errors of the quaternion.
fn is_same(one: &Incoming, other: &Odometry) {
    let Incoming::Odometry(one) = one else { panic!("{one:?}") };
    let near = |one: [f32; 3], other: [f32; 3]| one.iter().zip(other).all(|(one, other)| (one - other).abs() < 2e-3);
    assert!(near(one.pose.attitude_rad, other.pose.attitude_rad), "{one:?} {other:?}");
    assert_eq!(Odometry { pose: Pose { attitude_rad: other.pose.attitude_rad, ..one.pose }, ..*one }, *other);
}

#[test]
fn a_target_is_seen_to_the_left_and_above() {
    let (messages, report, waiting) = received(&TARGET, 7);
    let [Incoming::Target(target)] = messages[..] else { panic!("{messages:?} {report:?}") };
    assert_eq!((target.number, target.time_us, waiting), (3, 1_000_000, 0));
    let [range, bearing] = target.in_plane().unwrap();
    assert!((range - 0.3125_f32.sqrt()).abs() < 1e-6 && (bearing - 0.5_f32.atan()).abs() < 1e-6);
    assert!((target.elevation_rad - (0.125 / range).atan()).abs() < 1e-6);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn messages_are_received_in_any_chunks(
        sent in prop::collection::vec(odometry(), 0..6),
        chunk in 1..400_usize,
        noise in prop::collection::vec(any::<u8>().prop_filter("a mark", |byte| *byte != 0xfd), 0..40),
    ) {
        let mut sender = Sender::new(1, 2);
        let mut bytes = Vec::new();
        for odometry in &sent {
            bytes.extend(sender.frame(&Heartbeat));
            bytes.extend(&noise);
            bytes.extend(sender.frame(odometry));
        }
        let (messages, report, waiting) = received(&bytes, chunk);
        prop_assert_eq!(messages.len(), sent.len());
        messages.iter().zip(&sent).for_each(|(one, other)| is_same(one, other));
        prop_assert_eq!((report.messages as usize, report.others as usize, waiting), (sent.len(), sent.len(), 0));
        prop_assert_eq!(report.skipped as usize, noise.len() * sent.len());
    }

    /// A message with a changed byte is lost, and no other one, unless the change makes it look longer, or like an unsupported one.
    #[test]
    fn damage_affects_only_its_message(sent in prop::collection::vec(odometry(), 4), at in 10..2000_usize, flip in 1..=255_u8) {
        let mut sender = Sender::new(1, 2);
        let frames: Vec<Vec<u8>> = sent.iter().map(|odometry| sender.frame(odometry).to_vec()).collect();
        let damaged = at % 3;
        let mut bytes = frames.concat();
        let begin: usize = frames[..damaged].iter().map(Vec::len).sum();
        bytes[begin + 10 + at % (frames[damaged].len() - 10)] ^= flip;
        let (messages, report, _) = received(&bytes, 64);
        let left: Vec<&Odometry> = sent.iter().enumerate().filter(|(k, _)| *k != damaged).map(|(_, sent)| sent).collect();
        prop_assert_eq!(messages.len(), left.len());
        messages.iter().zip(left).for_each(|(one, other)| is_same(one, other));
        prop_assert!(report.damaged >= 1);
    }

    /// Arbitrary bytes, and messages with arbitrary numbers.
    #[test]
    fn nothing_panics(
        bytes in prop::collection::vec(prop_oneof![4 => any::<u8>(), 1 => Just(0xfd_u8), 2 => Just(0_u8)], 0..900),
        place in any::<[i32; 4]>(),
        words in prop::collection::vec(any::<u32>(), 60),
        number in prop_oneof![Just((331_u32, 91_u8)), Just((149, 200)), Just((24, 24)), Just((111, 34))],
        corrections in any::<[f32; 6]>(),
    ) {
        let (_, report, waiting) = received(&bytes, 50);
        prop_assert!(report.skipped as usize + waiting <= bytes.len());
        // A correct checksum for any payload, signed or not.
        let payload: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).take(bytes.len() % 241).collect();
        let signed = bytes.len() % 2;
        let mut frame = vec![payload.len() as u8, signed as u8, 0, 0, 1, 1];
        frame.extend(&number.0.to_le_bytes()[..3]);
        frame.extend(payload);
        let digest = crc::Crc::<u16>::new(&crc::CRC_16_MCRF4XX).checksum(&[&frame[..], &[number.1]].concat());
        frame.extend(digest.to_le_bytes());
        frame.insert(0, 0xfd);
        frame.resize(frame.len() + 13 * signed, 0);
        let (messages, report, waiting) = received(&frame, 33);
        prop_assert_eq!((report.messages + report.unusable, report.skipped, waiting), (1, 0, 0));
        for message in messages {
            if let Incoming::Satellite(satellite) = message {
                prop_assert!(Origin::new(place[0], place[1]).place(&satellite).iter().all(|x| x.is_finite()));
            }
        }
        let mut resets = ResetCounter::new(0.5, 0.1);
        let [before, after] = [0, 3].map(|k| [corrections[k], corrections[k + 1], corrections[k + 2]]);
        let jumped = resets.between(before, after);
        prop_assert_eq!(resets.value(), u8::from(jumped));
        let question = TimeSync::question(i64::from(place[0]));
        prop_assert_eq!(question.answer(9).map(|answer| answer.asked_ns), Some(question.asked_ns));
    }
}

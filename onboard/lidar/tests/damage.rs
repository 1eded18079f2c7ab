//! Arbitrary bytes: nothing panics, every byte is counted, and intact packets are found again.

use proptest::prelude::*;
use scphd_lidar::{Assembler, Packet, PostFinder, PostSettings, Reading, Receiver};

fn packets() -> impl Strategy<Value = Vec<Packet>> {
    let readings = prop::array::uniform12(any::<(u16, u8)>());
    let packet = (any::<u16>(), 0..36_000_u16, 0..6_000_u16, readings, any::<u16>()).prop_map(
        |(speed_degps, start_cdeg, span, readings, time_ms)| Packet {
            speed_degps,
            start_cdeg,
            readings: readings.map(|(range_mm, intensity)| Reading { range_mm, intensity }),
            end_cdeg: ((u32::from(start_cdeg) + u32::from(span)) % 36_000) as u16,
            time_ms,
        },
    );
    prop::collection::vec(packet, 0..12)
}

/// The packets of a receiver. Checks that every byte is accounted for.
fn received(bytes: &[u8]) -> Vec<Packet> {
    let mut receiver = Receiver::new();
    let found: Vec<Packet> = bytes.iter().filter_map(|&byte| receiver.push(byte)).collect();
    let report = receiver.report();
    assert_eq!(found.len(), report.packets as usize);
    assert_eq!(bytes.len(), 47 * found.len() + report.skipped as usize + receiver.waiting());
    found
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn intact_packets_are_received(packets in packets()) {
        let bytes: Vec<u8> = packets.iter().flat_map(Packet::to_bytes).collect();
        prop_assert_eq!(&received(&bytes), &packets);
        // The same from a line that returns a few bytes at a time.
        let (mut line, mut receiver, mut read) = (&bytes[..], Receiver::new(), Vec::new());
        while let Ok(Some(packet)) = receiver.read(&mut line) {
            read.push(packet);
        }
        prop_assert_eq!(read, packets);
    }

    /// Noise between packets that cannot begin a packet removes none of them.
    #[test]
    fn packets_are_found_between_other_bytes(
        packets in packets(),
        noise in prop::collection::vec(any::<u8>().prop_filter("a mark", |byte| *byte != 0x54), 0..100),
    ) {
        let bytes: Vec<u8> = packets.iter().flat_map(|packet| noise.iter().copied().chain(packet.to_bytes())).collect();
        prop_assert_eq!(received(&bytes), packets);
    }

    /// A damaged packet is lost, and no other one, unless the damage makes it look like the beginning of a packet.
    #[test]
    fn damage_affects_only_its_packet(packets in packets(), at in any::<prop::sample::Index>(), flip in 1..=255_u8) {
        prop_assume!(packets.len() > 1);
        let mut bytes: Vec<u8> = packets.iter().flat_map(Packet::to_bytes).collect();
        let at = at.index(bytes.len());
        bytes[at] ^= flip;
        let mut left = packets;
        left.remove(at / 47);
        prop_assert_eq!(received(&bytes), left);
    }

    /// Arbitrary bytes and readings through the whole chain.
    #[test]
    fn nothing_panics(
        bytes in prop::collection::vec(prop_oneof![3 => any::<u8>(), 1 => Just(0x54_u8), 1 => Just(0x2c_u8)], 0..600),
        packets in packets(),
        radius in 1e-3..2.0_f32,
        min_points in 1..20_u16,
        min_intensity in any::<u8>(),
    ) {
        let mut receiver = Receiver::new();
        let mut assembler = Assembler::<64>::with_seam(u16::from(min_intensity) * 250);
        let finder = PostFinder::new(PostSettings { min_points, min_intensity: f32::from(min_intensity), ..PostSettings::of_radius(radius) }).unwrap();
        let all = bytes.into_iter().chain(packets.iter().flat_map(Packet::to_bytes));
        for packet in all.filter_map(|byte| receiver.push(byte)) {
            let Some(revolution) = assembler.push(&packet) else { continue };
            for post in finder.find::<4, _>(revolution).posts {
                prop_assert!(post.range_m.is_finite() && post.bearing_rad.abs() < std::f32::consts::PI + 1e-3);
                prop_assert!(post.before_end_s >= 0.0 && post.at_end(3.0, 1.0).iter().all(|x| x.is_finite()));
            }
        }
    }
}

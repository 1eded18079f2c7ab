//! Packets byte by byte, and revolutions from them.

use scphd_lidar::{Assembler, Packet, PacketError, Reading, Receiver};

/// The example of the manual of the LD06.
const MANUAL: [u8; 47] = [
    0x54, 0x2c, 0x68, 0x08, 0xab, 0x7e, 0xe0, 0x00, 0xe4, 0xdc, 0x00, 0xe2, 0xd9, 0x00, 0xe5, 0xd5, 0x00, 0xe3, 0xd3,
    0x00, 0xe4, 0xd0, 0x00, 0xe9, 0xcd, 0x00, 0xe4, 0xca, 0x00, 0xe2, 0xc7, 0x00, 0xe9, 0xc5, 0x00, 0xe5, 0xc2, 0x00,
    0xe5, 0xc0, 0x00, 0xe5, 0xbe, 0x82, 0x3a, 0x1a, 0x50,
];

#[test]
fn the_example_of_the_manual_is_read() {
    let packet = Packet::parse(&MANUAL).unwrap();
    assert_eq!((packet.speed_degps, packet.start_cdeg, packet.end_cdeg, packet.time_ms), (2152, 32_427, 33_470, 6714));
    let ranges = packet.readings.map(|reading| reading.range_mm);
    assert_eq!(ranges, [224, 220, 217, 213, 211, 208, 205, 202, 199, 197, 194, 192]);
    let intensities = packet.readings.map(|reading| reading.intensity);
    assert_eq!(intensities, [228, 226, 229, 227, 228, 233, 228, 226, 233, 229, 229, 229]);
    let angles: Vec<u16> = packet.points().map(|point| point.angle_cdeg).collect();
    assert_eq!(angles, [32427, 32522, 32617, 32711, 32806, 32901, 32996, 33091, 33186, 33280, 33375, 33470]);
    assert!((packet.step_cdeg() - 94.818_18).abs() < 1e-3);
    assert_eq!(packet.to_bytes(), MANUAL);
}

#[test]
fn angles_continue_through_north() {
    let packet = Packet { start_cdeg: 35_800, end_cdeg: 640, ..Packet::parse(&MANUAL).unwrap() };
    let packet = Packet::parse(&packet.to_bytes()).unwrap();
    let angles: Vec<u16> = packet.points().map(|point| point.angle_cdeg).collect();
    assert_eq!(angles, [35_800, 35_876, 35_953, 29, 105, 182, 258, 335, 411, 487, 564, 640]);
}

#[test]
fn every_changed_bit_is_detected() {
    for place in 0..MANUAL.len() {
        for bit in 0..8 {
            let mut bytes = MANUAL;
            bytes[place] ^= 1 << bit;
            let expected = if place < 2 { PacketError::Header } else { PacketError::Check };
            assert_eq!(Packet::parse(&bytes), Err(expected), "bit {bit} of byte {place}");
        }
    }
}

#[test]
fn invalid_angles_are_refused() {
    let good = Packet::parse(&MANUAL).unwrap();
    for packet in [
        Packet { start_cdeg: 36_000, ..good },
        Packet { end_cdeg: 36_000, ..good },
        Packet { start_cdeg: u16::MAX, end_cdeg: u16::MAX, ..good },
        Packet { start_cdeg: 0, end_cdeg: 6_001, ..good },
        // Counterclockwise.
        Packet { start_cdeg: 1_000, end_cdeg: 0, ..good },
    ] {
        assert_eq!(Packet::parse(&packet.to_bytes()), Err(PacketError::Angles), "{packet:?}");
    }
    let mut receiver = Receiver::new();
    let odd = Packet { start_cdeg: 36_000, ..good };
    assert!(odd.to_bytes().into_iter().all(|byte| receiver.push(byte).is_none()));
    assert_eq!((receiver.report().unlikely, receiver.report().damaged), (1, 0));
}

/// A revolution at 10 Hz, beginning at the rear, with constant range.
fn turn(packets: u32) -> impl Iterator<Item = Packet> {
    let angle = |k: u32| ((18_000 + 80 * k) % 36_000) as u16;
    (0..packets).map(move |packet| Packet {
        speed_degps: 3600,
        start_cdeg: angle(12 * packet),
        readings: [Reading { range_mm: 3000, intensity: 50 }; 12],
        end_cdeg: angle(12 * packet + 11),
        time_ms: (packet * 8 / 3) as u16,
    })
}

#[test]
fn revolutions_begin_at_the_seam() {
    let mut assembler = Assembler::<512>::new();
    let mut whole = Vec::new();
    for packet in turn(38 * 3) {
        if let Some(revolution) = assembler.push(&packet) {
            whole.push((revolution.points.len(), revolution.missing_cdeg, revolution.beyond));
            assert!((revolution.step_cdeg - 80.0).abs() < 0.5);
            let from_seam = |k: usize| (u32::from(revolution.points[k].angle_cdeg) + 18_000) % 36_000;
            assert_eq!(from_seam(0), 0);
            assert!((1..revolution.points.len()).all(|k| from_seam(k) > from_seam(k - 1)));
        }
    }
    // 114 packets are three revolutions and a little; the first one is not known to be complete.
    assert_eq!(whole, [(450, 0, 0); 2]);
}

#[test]
fn missing_packets_are_reported() {
    let mut assembler = Assembler::<512>::new();
    let mut told = Vec::new();
    for (k, packet) in turn(38 * 4).enumerate() {
        // Without a packet in the middle of the third revolution, and the one across the seam at its end.
        if k != 38 * 2 + 10 && k != 112 {
            told.extend(assembler.push(&packet).map(|revolution| (revolution.points.len(), revolution.missing_cdeg)));
        }
    }
    assert_eq!(told[0], (450, 0));
    // Twelve points and the step to the next one; about six points of the packet at the end belong to this revolution.
    assert_eq!(told[1].0 + told[2].0, 900 - 24, "{told:?}");
    assert!(told[1].1 >= 13 * 80 && told[1].1 + told[2].1 >= 2 * 12 * 80, "{told:?}");
}

#[test]
fn points_without_room_are_counted() {
    let mut assembler = Assembler::<100>::new();
    let told: Vec<_> = turn(38 * 3)
        .filter_map(|packet| assembler.push(&packet).map(|revolution| (revolution.points.len(), revolution.beyond)))
        .collect();
    assert_eq!(told, [(100, 350); 2]);
}

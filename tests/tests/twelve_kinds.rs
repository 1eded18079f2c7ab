//! The drive of the C and Python interfaces through streams and links: the recording of a described filter replays, and arrives over
//! a serial line, to the digests of the library. A joint map whose capacities streams do not have is built from its description
//! once more.

use scphd_boards::hil::Rates;
use scphd_drive::{Event, Filters, Memory, control, descriptions, events, take};
use scphd_link::{Gaps, Target, Unit};
use scphd_stream::planar::{
    self, BlackBox, BlackBoxArchive, BlackBoxCalibrated, BlackBoxHypotheses, BlackBoxJoint, BlackBoxMovers, Odometry,
    Planar,
};
use scphd_stream::{Aboard, Header, Scalar, Which, Writer, pieces};
use scphd_tests::with_roomy_stack;
use scphd_vehicle::{Backing, Description, Services as _, Slam as _, joint_backing};
use std::convert::Infallible;

use crate::black_box::replayed;
use crate::link::{Digests, LONGEST, Wire, sent};

joint_backing! {
    struct Plain: PlanarPose<f32> { features: 64, measurements: 64 }
}
joint_backing! {
    struct Tracks: PlanarPose<f32> { features: 64, measurements: 64, movers: 64 }
}
joint_backing! {
    struct Archive: PlanarPose<f32> { features: 64, measurements: 64, movers: 64, archived: 256 }
}
joint_backing! {
    struct Learning: CalibratedPose<f32> { features: 64, measurements: 64 }
}

/// The digests of the described filter in this memory after each scan of the drive.
pub(crate) fn driven(described: &Description<f32>, memory: &mut impl Backing<f32>, events: &[Event]) -> Vec<u64> {
    let mut slam = memory.start(described).unwrap();
    slam.reset(&described.start).unwrap();
    let mut digests = Vec::new();
    for event in events {
        take(&mut slam, described, event).unwrap();
        if is_scan(event) {
            digests.push(slam.digest());
        }
    }
    digests
}

/// Whether an input is a scan of range and bearing.
fn is_scan(event: &Event) -> bool {
    matches!(event, Event::Lidar(_) | Event::Radar(_))
}

/// The recording of the drive for this vehicle.
fn recording(described: &Description<f32>, events: &[Event]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let sink = |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok::<(), Infallible>(())
    };
    let Ok(mut log) = Writer::<Planar, _>::start(&Header::of(described, Scalar::F32).unwrap(), sink);
    let wide = |scan: &[[f32; 2]]| scan.iter().map(|z| z.map(f64::from)).collect::<Vec<_>>();
    for event in events {
        let Ok(()) = match event {
            &Event::Predict([speed_mps, rate, dt_s]) => {
                log.predict(&Odometry::of(control(described.vehicle.kind, speed_mps, rate), dt_s))
            }
            Event::Lidar(scan) => log.scan(&wide(scan)),
            Event::Radar(scan) => log.scan_of(Which::number(1).unwrap(), &wide(scan)),
            Event::Position(place) => log.fix(&planar::Fix::Position {
                place_m: place.map(f64::from),
                sigma_m: f64::from(0.3_f32),
                gate: 25.0,
                antenna_m: [-0.5_f32, 0.1].map(f64::from),
            }),
            Event::Heading(heading) => log.fix(&planar::Fix::Heading {
                heading_rad: f64::from(*heading),
                sigma_rad: f64::from(0.05_f32),
                gate: f64::INFINITY,
            }),
            // The diver's, and bearings, which streams do not have.
            Event::Camera(_) | Event::Dive(_) | Event::Sonar(_) | Event::Height(_) | Event::Compare => Ok(()),
        };
    }
    let Ok(()) = log.end();
    bytes
}

/// Whether the recording has these digests after each scan, replayed and over a line that doubles some frames.
fn same<A: Aboard<f32, Kind = Planar>>(described: &Description<f32>, events: &[Event], digests: &[u64]) -> bool {
    let bytes = recording(described, events);
    let (recovered, told) = replayed::<A, f32>(&bytes).unwrap();
    assert!(recovered.ended && recovered.gaps == 0);
    let replayed = told.digests.iter().map(|&(_, digest)| digest);

    let records: Vec<&[u8]> = pieces::<Planar>(&bytes).collect();
    let mut wire = Wire::default();
    wire.bytes = sent(1, &records, Rates { double: 0.05, ..Rates::default() }, 1).wire;
    let (mut memory, mut arrived) = (Box::new(A::MEMORY), Digests::default());
    let mut target = Target::<LONGEST, 256>::new(Gaps::Passed);
    target.serve::<A, f32, _>(&mut wire, &mut memory, Unit::Nanoseconds, &mut arrived).unwrap();
    arrived.0 == digests && replayed.eq(digests.iter().copied())
}

#[test]
fn ten_filters_of_the_drive_replay_from_streams_and_arrive_over_links() {
    with_roomy_stack(|| {
        let (events, mut memory) = (events(), Box::new(Memory::NEW));
        let mut filters = Filters::new(&mut memory).unwrap();
        let mut library = Vec::new();
        for event in &events {
            filters.take(event).unwrap();
            if is_scan(event) {
                library.push(filters.digests());
            }
        }
        let of = |place: usize| descriptions()[place].unwrap();
        let in_its_memory = |place: usize| library.iter().map(|digests| digests[place]).collect::<Vec<_>>();
        let plain = |place| {
            let digests = driven(&of(place), &mut *Box::new(Plain::new()), &events);
            same::<BlackBoxJoint>(&of(place), &events, &digests)
        };
        let alike = [
            same::<BlackBox>(&of(1), &events, &in_its_memory(1)),
            plain(2),
            same::<BlackBoxMovers>(&of(4), &events, &driven(&of(4), &mut *Box::new(Tracks::new()), &events)),
            same::<BlackBoxArchive>(&of(5), &events, &driven(&of(5), &mut *Box::new(Archive::new()), &events)),
            same::<BlackBoxCalibrated>(&of(6), &events, &driven(&of(6), &mut *Box::new(Learning::new()), &events)),
            same::<BlackBoxHypotheses>(&of(7), &events, &in_its_memory(7)),
            plain(8),
            plain(9),
            same::<BlackBox>(&of(10), &events, &in_its_memory(10)),
            plain(11),
        ];
        assert_eq!(alike, [true; 10]);
    });
}

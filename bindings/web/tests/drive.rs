//! Described filters in the memory of the page have the digests of the library over the drive of the C interface.

mod kinds;

use kinds::{HELD, described, inputs};
use scphd_drive::{Event, Filters, Memory, take};
use scphd_vehicle::Description;
use scphd_web::{Refused, Session};

/// The 32 × 2 particles, of which the library's memory has too few pages for all births in two scans; the page has more.
const SHORT_OF_PAGES: usize = 0;

#[test]
fn the_mixtures_of_the_drive_have_the_digests_of_the_library() {
    let mut session = Box::new(Session::NEW);
    for place in HELD {
        let mut memory = Box::new(Memory::NEW);
        let (described, mut library) = (described(place), Filters::new(&mut memory).unwrap());
        session.describe(&described.numbers()).unwrap();
        let mut different = 0;
        for event in inputs() {
            library.take(&event).unwrap();
            take(session.filter().unwrap().services(), &described, &event).unwrap();
            if event == Event::Compare {
                different += usize::from(session.digest() != library.digests()[place]);
            }
        }
        assert_eq!(different, if place == SHORT_OF_PAGES { 2 } else { 0 }, "{place}");
    }
}

#[test]
fn other_descriptions_are_refused() {
    let mut session = Box::new(Session::NEW);
    assert_eq!(session.describe(&Description::<f32>::robot().numbers()), Err(Refused), "a joint map without tracks");
    assert_eq!(session.describe(&[f64::NAN]), Err(Refused));
    session.describe(&described(1).numbers()).unwrap();
    assert!(session.filter().unwrap().services().audit().is_ok());
}

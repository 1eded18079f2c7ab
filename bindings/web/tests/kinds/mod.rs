//! The filters of the C interface's drive that the page has memory for: mixtures, without the camera.

use scphd_drive::{Event, descriptions, events};
use scphd_vehicle::Description;

/// Their places among the filters of the drive. The drive fills the pages of the library's 32 × 2 particles, of which the page has more.
pub const HELD: [usize; 2] = [1, 10];

/// The description of one of them.
pub fn described(place: usize) -> Description<f32> {
    let mut described = descriptions()[place].unwrap();
    described.sensors[2] = None;
    described
}

/// Their inputs.
pub fn inputs() -> impl Iterator<Item = Event> {
    events().into_iter().filter(|event| !matches!(event, Event::Camera(_)))
}

//! The filters of the C interface's drive that the page has memory for: mixtures, without the camera.

use scphd_drive::{Event, descriptions, events};
use scphd_vehicle::Description;

/// Their places among the filters of the drive.
pub const HELD: [usize; 3] = [0, 1, 10];

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

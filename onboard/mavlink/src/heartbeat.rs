//! HEARTBEAT: that somebody is here. Flight stacks want one each second before they talk to a component.

use crate::frame::{Outgoing, Payload};

/// Of a computer beside the flight stack (`MAV_TYPE_ONBOARD_CONTROLLER`, `MAV_AUTOPILOT_INVALID`, `MAV_STATE_ACTIVE`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Heartbeat;

impl Outgoing for Heartbeat {
    const NUMBER: u32 = 0;
    const EXTRA: u8 = 50;

    fn write(&self, payload: &mut Payload) {
        // No mode of its own; the version of the protocol is 3.
        payload.0.bytes(&[0; 4]).bytes(&[18, 8, 0, 4, 3]);
    }
}

//! HEARTBEAT: announces a component. Flight stacks need one each second before they communicate with it.

use crate::frame::{Outgoing, Payload};

/// The heartbeat of a companion computer (`MAV_TYPE_ONBOARD_CONTROLLER`, `MAV_AUTOPILOT_INVALID`, `MAV_STATE_ACTIVE`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Heartbeat;

impl Outgoing for Heartbeat {
    const NUMBER: u32 = 0;
    const EXTRA: u8 = 50;

    fn write(&self, payload: &mut Payload) {
        // No custom mode; version 3 of the protocol.
        payload.0.bytes(&[0; 4]).bytes(&[18, 8, 0, 4, 3]);
    }
}

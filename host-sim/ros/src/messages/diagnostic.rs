//! `diagnostic_msgs`.

use super::standard::Header;
use crate::definition::messages;

messages! {
    "diagnostic_msgs"
    /// A value with its name.
    #[derive(Default)]
    KeyValue { key: String, value: String, }

    /// Status of a part of a vehicle.
    #[derive(Default)]
    DiagnosticStatus {
        "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n"
        level: u8 as "byte",
        name: String,
        message: String,
        /// The device.
        hardware_id: String,
        values: Vec<KeyValue>,
    }

    /// Status of the parts of a vehicle.
    #[derive(Default)]
    DiagnosticArray { header: Header, status: Vec<DiagnosticStatus>, }
}

//! `diagnostic_msgs`.

use super::message;
use super::standard::{HEADER, Header};
use crate::definition::Definition;
use serde::{Deserialize, Serialize};

/// A value with its name.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are said above")]
pub struct KeyValue {
    pub key: String,
    pub value: String,
}

pub static KEY_VALUE: Definition =
    Definition { name: "diagnostic_msgs/msg/KeyValue", text: "string key\nstring value\n", parts: &[] };

/// Status of a part of a vehicle.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    /// 0 good, 1 a warning, 2 an error, 3 no recent message.
    pub level: u8,
    pub name: String,
    pub message: String,
    /// The device.
    pub hardware_id: String,
    /// Figures.
    pub values: Vec<KeyValue>,
}

pub static DIAGNOSTIC_STATUS: Definition = Definition {
    name: "diagnostic_msgs/msg/DiagnosticStatus",
    text: "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\nstring hardware_id\n\
           diagnostic_msgs/KeyValue[] values\n",
    parts: &[&KEY_VALUE],
};

/// Status of the parts of a vehicle.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct DiagnosticArray {
    pub header: Header,
    pub status: Vec<DiagnosticStatus>,
}

message!(
    DiagnosticArray,
    DIAGNOSTIC_ARRAY = "diagnostic_msgs/msg/DiagnosticArray",
    "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n",
    [HEADER, DIAGNOSTIC_STATUS]
);

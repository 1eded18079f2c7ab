//! Definitions of messages, in the format of files.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// The definition of a type.
#[derive(Debug)]
pub struct Definition {
    /// Package and name, for example `geometry_msgs/msg/Pose`.
    pub name: &'static str,
    /// Its fields, one in each line.
    pub text: &'static str,
    /// The message types of its fields.
    pub parts: &'static [&'static Self],
}

/// A message type with topics of its own.
pub trait Message: Serialize + DeserializeOwned {
    const DEFINITION: &'static Definition;
}

/// The definition with those of all types in it, in the encoding `ros2msg` of MCAP.
#[must_use]
pub fn full_text(definition: &'static Definition) -> String {
    let mut all = Vec::new();
    collect(definition, &mut all);
    let mut text = definition.text.to_owned();
    for part in &all[1..] {
        let name = part.name.replace("/msg/", "/");
        text += &format!("{}\nMSG: {name}\n{}", "=".repeat(80), part.text);
    }
    text
}

/// Adds the type and all types in it, each once.
fn collect(definition: &'static Definition, all: &mut Vec<&'static Definition>) {
    if all.iter().any(|known| known.name == definition.name) {
        return;
    }
    all.push(definition);
    definition.parts.iter().for_each(|part| collect(part, all));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::{ALL, TRANSFORM_STAMPED};
    use std::collections::BTreeSet;

    const PRIMITIVES: [&str; 10] =
        ["bool", "byte", "uint8", "int8", "uint16", "int32", "uint32", "float32", "float64", "string"];

    #[test]
    fn the_types_of_all_fields_are_defined() {
        for definition in ALL {
            let (mut all, mut used) = (Vec::new(), BTreeSet::new());
            collect(definition, &mut all);
            for part in &all {
                for line in part.text.lines() {
                    let kind = line.split_whitespace().next().unwrap();
                    let kind = kind.split('[').next().unwrap();
                    assert!(line.split_whitespace().count() >= 2, "{line}");
                    if !PRIMITIVES.contains(&kind) {
                        assert!(kind.contains('/'), "{}: {line}", part.name);
                        used.insert(kind.to_owned());
                    }
                }
            }
            let given: BTreeSet<String> = all[1..].iter().map(|part| part.name.replace("/msg/", "/")).collect();
            assert_eq!(used, given, "{}", definition.name);
        }
    }

    #[test]
    fn a_type_that_is_used_twice_is_defined_once() {
        let text = full_text(&TRANSFORM_STAMPED);
        assert!(text.starts_with("std_msgs/Header header\nstring child_frame_id\n"), "{text}");
        assert_eq!(text.matches("MSG: geometry_msgs/Vector3\n").count(), 1);
        assert_eq!(text.matches("MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n").count(), 1);
    }
}

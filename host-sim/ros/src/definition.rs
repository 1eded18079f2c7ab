//! Definitions of messages, in the format of files.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt;

/// The definition of a message type.
#[derive(Debug)]
pub struct Definition {
    /// Package and name, for example `geometry_msgs/msg/Pose`.
    pub name: &'static str,
    pub(crate) lines: &'static [Line],
}

/// A field in a definition.
#[derive(Debug)]
pub(crate) struct Line {
    /// The lines of constants before it.
    pub(crate) constants: &'static str,
    pub(crate) kind: Kind,
    pub(crate) name: &'static str,
    /// Its default, after a blank; empty if it is zero.
    pub(crate) default: &'static str,
}

#[derive(Debug, Clone, Copy)]
pub struct Kind {
    base: Base,
    count: Count,
}

#[derive(Debug, Clone, Copy)]
enum Base {
    Plain(&'static str),
    Message(&'static Definition),
}

#[derive(Debug, Clone, Copy)]
enum Count {
    One,
    Fixed(usize),
    Any,
}

impl Kind {
    pub(crate) const fn plain(name: &'static str) -> Self {
        Self { base: Base::Plain(name), count: Count::One }
    }

    pub(crate) const fn message(definition: &'static Definition) -> Self {
        Self { base: Base::Message(definition), count: Count::One }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.base {
            Base::Plain(name) => f.write_str(name)?,
            Base::Message(definition) => f.write_str(&definition.name.replace("/msg/", "/"))?,
        }
        match self.count {
            Count::One => Ok(()),
            Count::Fixed(count) => write!(f, "[{count}]"),
            Count::Any => f.write_str("[]"),
        }
    }
}

/// A type of the fields of messages.
pub trait Field {
    const KIND: Kind;
}

macro_rules! plain {
    ($($type:ty = $name:literal)+) => { $(impl Field for $type { const KIND: Kind = Kind::plain($name); })+ };
}
plain!(bool = "bool" u8 = "uint8" i8 = "int8" u16 = "uint16" i32 = "int32" u32 = "uint32" f32 = "float32" f64 = "float64" String = "string");

impl<T: Field> Field for Vec<T> {
    const KIND: Kind = Kind { count: Count::Any, ..T::KIND };
}

impl<T: Field, const N: usize> Field for [T; N] {
    const KIND: Kind = match T::KIND.count {
        Count::Fixed(inner) => Kind { count: Count::Fixed(N * inner), ..T::KIND },
        _ => Kind { count: Count::Fixed(N), ..T::KIND },
    };
}

pub trait Message: Serialize + DeserializeOwned {
    const DEFINITION: &'static Definition;
}

impl Definition {
    /// The lines of its fields.
    fn text(&self) -> String {
        let line = |Line { constants, kind, name, default }: &Line| {
            format!("{constants}{kind} {}{default}\n", name.trim_start_matches("r#"))
        };
        self.lines.iter().map(line).collect()
    }
}

/// The definition with those of all types in it, in the encoding `ros2msg` of MCAP.
pub fn full_text(definition: &'static Definition) -> String {
    let mut all = Vec::new();
    collect(definition, &mut all);
    let mut text = definition.text();
    for part in &all[1..] {
        text += &format!("{}\nMSG: {}\n{}", "=".repeat(80), part.name.replace("/msg/", "/"), part.text());
    }
    text
}

/// Adds the type and all types in it, each once.
fn collect(definition: &'static Definition, all: &mut Vec<&'static Definition>) {
    if all.iter().any(|known| known.name == definition.name) {
        return;
    }
    all.push(definition);
    for line in definition.lines {
        if let Base::Message(part) = line.kind.base {
            collect(part, all);
        }
    }
}

/// Structs of messages of a package, with the fields of their definitions: before a field there may be the lines of constants,
/// behind its type its default, or the name of its type if another type has the same struct field.
macro_rules! messages {
    ($package:literal $(
        $(#[$about:meta])*
        $name:ident { $( $($constants:literal)? $(#[$said:meta])* $field:ident: $kind:ty $(= $default:literal)? $(as $plain:literal)?, )+ }
    )+) => { $(
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct $name { $( $(#[$said])* pub $field: $kind, )+ }

        impl $crate::definition::Field for $name {
            const KIND: $crate::definition::Kind = $crate::definition::Kind::message(<Self as $crate::Message>::DEFINITION);
        }

        impl $crate::Message for $name {
            const DEFINITION: &'static $crate::Definition = &$crate::Definition {
                name: concat!($package, "/msg/", stringify!($name)),
                lines: &[$($crate::definition::Line {
                    constants: concat!("", $($constants)?),
                    kind: {
                        let _kind = <$kind as $crate::definition::Field>::KIND;
                        $(let _kind = $crate::definition::Kind::plain($plain);)?
                        _kind
                    },
                    name: stringify!($field),
                    default: concat!("", $(" ", $default)?),
                }),+],
            };
        }
    )+ };
}
pub(crate) use messages;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::{NavSatStatus, Quaternion, TransformStamped};

    #[test]
    fn a_type_that_is_used_twice_is_defined_once() {
        let text = full_text(TransformStamped::DEFINITION);
        assert!(text.starts_with("std_msgs/Header header\nstring child_frame_id\n"), "{text}");
        assert_eq!(text.matches("MSG: geometry_msgs/Vector3\n").count(), 1);
        assert_eq!(text.matches("MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n").count(), 1);
    }

    #[test]
    fn constants_and_defaults_are_in_a_definition() {
        assert_eq!(Quaternion::DEFINITION.text(), "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n");
        assert!(
            NavSatStatus::DEFINITION.text().contains("int8 STATUS_GBAS_FIX=2\nint8 status\nuint16 SERVICE_GPS=1\n")
        );
    }
}

//! Topics of ROS 2 and their quality of service.

use crate::parameters::{ParameterError, Parameters};
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{Context, ContextOptions, MessageTypeName, Name, Node, NodeName, NodeOptions, QosProfile};
use scphd_ros::Message;
use std::collections::BTreeMap;
use std::env;
use std::fmt::Display;
use std::fs;

/// An error of the middleware or of a command line.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Failure(pub String);

impl From<ParameterError> for Failure {
    fn from(error: ParameterError) -> Self {
        Self(error.to_string())
    }
}

/// Depths of the histories of readers and publishers.
pub(crate) const IN: usize = 1024;
const OUT: usize = 64;

/// Quality of service for sensors: lost messages are not repeated (REP 2003).
pub fn sensor_data() -> QosProfile {
    QosProfile::subscription_default().reliability_best_effort().history(History::KeepLast { depth: IN })
}

/// Lost messages are repeated.
pub fn reliable() -> QosProfile {
    QosProfile::publisher_default().reliability_reliable(WhenFull::DEFAULT).history(History::KeepLast { depth: OUT })
}

/// As `reliable`; late readers receive the last message.
pub fn latched() -> QosProfile {
    reliable().durability(Durability::TransientLocal).history(History::KeepLast { depth: 1 })
}

/// The name of a message type, such as `nav_msgs/msg/Odometry`.
pub fn type_name(kind: &str) -> Result<MessageTypeName, Failure> {
    match kind.split('/').collect::<Vec<_>>()[..] {
        [package, "msg", name] => Ok(MessageTypeName::new(package, name)),
        _ => Err(Failure(format!("'{kind}' is no type of messages"))),
    }
}

/// The arguments of a ROS 2 command line: `--ros-args -r FROM:=TO -p NAME:=VALUE --params-file FILE`.
#[derive(Debug, Clone, PartialEq)]
pub struct Arguments {
    /// Name of the node.
    pub name: String,
    /// Namespace of the node.
    pub namespace: String,
    /// Remapped names of topics and services.
    pub remapped: BTreeMap<String, String>,
    pub parameters: Parameters,
    /// Arguments that are not of ROS 2.
    pub rest: Vec<String>,
}

impl Arguments {
    /// Reads a command line.
    pub fn of(words: impl Iterator<Item = String>, name: &str) -> Result<Self, Failure> {
        let mut found = Self {
            name: name.to_owned(),
            namespace: "/".into(),
            remapped: BTreeMap::new(),
            parameters: Parameters::default(),
            rest: Vec::new(),
        };
        let (mut files, mut assigned) = (Vec::new(), Vec::new());
        let mut words = words;
        while let Some(word) = words.next() {
            let mut next = || words.next().ok_or_else(|| Failure(format!("{word} needs a value")));
            match word.as_str() {
                "--ros-args" | "--" => {}
                "-p" | "--param" => assigned.push(next()?),
                "--params-file" => files.push(next()?),
                "-r" | "--remap" => {
                    let word = next()?;
                    let (from, to) =
                        word.split_once(":=").ok_or_else(|| Failure(format!("'{word}' is not FROM:=TO")))?;
                    match from {
                        "__node" | "__name" => found.name = to.to_owned(),
                        "__ns" => found.namespace = to.to_owned(),
                        _ => drop(found.remapped.insert(from.to_owned(), to.to_owned())),
                    }
                }
                _ => found.rest.push(word),
            }
        }
        for file in files {
            let text = fs::read_to_string(&file).map_err(|error| Failure(format!("{file}: {error}")))?;
            let read = found.parameters.read(&text, &found.name);
            read.map_err(|error| Failure(format!("{file}: {error}")))?;
        }
        assigned.iter().try_for_each(|word| found.parameters.assign(word))?;
        Ok(found)
    }

    /// The full name of a topic or service: `~/pose` is in the node's private namespace, `scan` in the node's namespace, `/scan`
    /// is absolute.
    pub fn resolved(&self, name: &str) -> String {
        let name = self.remapped.get(name).map_or(name, String::as_str);
        let namespace = self.namespace.trim_end_matches('/');
        match (name.strip_prefix("~/"), name.starts_with('/')) {
            (Some(own), _) => {
                let whole = format!("{namespace}/{}/{own}", self.name);
                self.remapped.get(&whole).cloned().unwrap_or(whole)
            }
            (None, true) => name.to_owned(),
            (None, false) => format!("{namespace}/{name}"),
        }
    }
}

/// A node in the domain of `ROS_DOMAIN_ID`.
pub fn node(arguments: &Arguments, options: NodeOptions) -> Result<Node, Failure> {
    let domain = match env::var("ROS_DOMAIN_ID") {
        Ok(text) if !text.is_empty() => {
            text.parse().map_err(|_| Failure(format!("ROS_DOMAIN_ID is '{text}', not a number")))?
        }
        _ => 0,
    };
    let context = Context::with_options(ContextOptions::new().domain_id(domain));
    let context = context.map_err(|error| Failure(format!("the middleware does not start: {error:?}")))?;
    let name = NodeName::new(&arguments.namespace, &arguments.name);
    let name = name.map_err(|error| Failure(format!("the name of the node: {error}")))?;
    context.new_node(name, options).map_err(|error| Failure(format!("the node does not start: {error:?}")))
}

/// Splits a name into namespace and name.
pub fn parted(whole: &str) -> Result<Name, Failure> {
    let bad = |error: &dyn Display| Failure(format!("the name '{whole}': {error}"));
    let (space, name) = whole.rsplit_once('/').ok_or_else(|| bad(&"it has no /"))?;
    Name::new(if space.is_empty() { "/" } else { space }, name).map_err(|error| bad(&error))
}

/// A publisher of a message type.
pub fn publisher<M: Message>(
    node: &mut Node,
    name: &str,
    quality: &QosProfile,
) -> Result<ros2_client::Publisher<M>, Failure> {
    any_publisher(node, name, M::DEFINITION.name, quality)
}

/// A publisher of values that serialise as messages of a type.
pub fn any_publisher<M: serde::Serialize>(
    node: &mut Node,
    name: &str,
    kind: &str,
    quality: &QosProfile,
) -> Result<ros2_client::Publisher<M>, Failure> {
    let refused = |error: &dyn std::fmt::Debug| Failure(format!("{name}: {error:?}"));
    let topic = node.create_topic(&parted(name)?, type_name(kind)?, quality).map_err(|error| refused(&error))?;
    node.create_publisher(&topic, Some(quality.clone())).map_err(|error| refused(&error))
}

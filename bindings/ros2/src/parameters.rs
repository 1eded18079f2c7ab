//! Parameters of a node, from files of ROS 2 and from the command line.

use serde_yaml_ng::Value as Yaml;
use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

/// A parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A truth value.
    Bool(bool),
    Number(f64),
    /// A word.
    Text(String),
    /// A list of words.
    Texts(Vec<String>),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(is) => write!(f, "{is}"),
            Self::Number(number) if number.is_infinite() => f.write_str(if *number > 0.0 { ".inf" } else { "-.inf" }),
            // With a decimal point, because ROS 2 infers the type from it.
            Self::Number(number) => write!(f, "{number:?}"),
            Self::Text(text) => write!(f, "'{}'", text.replace('\'', "''")),
            Self::Texts(texts) => {
                let texts: Vec<String> = texts.iter().map(|text| Self::Text(text.clone()).to_string()).collect();
                write!(f, "[{}]", texts.join(", "))
            }
        }
    }
}

/// The reason why parameters cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// The file is not a parameter file.
    #[error("{0}")]
    File(String),
    #[error("there is no parameter '{0}'{1}")]
    Unknown(String, String),
    /// A value that the parameter cannot have.
    #[error("parameter '{name}' is {found}: it must be {range}")]
    Invalid { name: String, found: String, range: String },
}

/// Parameters by name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parameters(pub BTreeMap<String, Value>);

impl Parameters {
    /// Reads the parameters of a node from a file, those of `/**` and of the node's name, and replaces earlier values.
    pub fn read(&mut self, text: &str, node: &str) -> Result<(), ParameterError> {
        let root: Yaml = serde_yaml_ng::from_str(text).map_err(|error| ParameterError::File(error.to_string()))?;
        let Yaml::Mapping(nodes) = root else {
            return Err(ParameterError::File("there is no node in the file".into()));
        };
        let mut found = false;
        for (name, content) in &nodes {
            let name = name.as_str().unwrap_or_default();
            if name != "/**" && name.trim_start_matches('/') != node {
                continue;
            }
            let parameters = content.get("ros__parameters");
            let parameters =
                parameters.ok_or_else(|| ParameterError::File(format!("{name} has no ros__parameters")))?;
            self.take("", parameters)?;
            found = true;
        }
        if found { Ok(()) } else { Err(ParameterError::File(format!("neither '{node}' nor '/**' is in the file"))) }
    }

    /// Reads an argument of the command line, `name:=value`.
    pub fn assign(&mut self, word: &str) -> Result<(), ParameterError> {
        let Some((name, value)) = word.split_once(":=") else {
            return Err(ParameterError::File(format!("'{word}' is not NAME:=VALUE")));
        };
        let value = serde_yaml_ng::from_str(value).map_err(|error| ParameterError::File(error.to_string()))?;
        self.take(name, &value)
    }

    fn take(&mut self, name: &str, value: &Yaml) -> Result<(), ParameterError> {
        let invalid = || ParameterError::Invalid {
            name: name.to_owned(),
            found: format!("{value:?}"),
            range: "a number, a word, a list of words or yes or no".to_owned(),
        };
        let value = match value {
            Yaml::Mapping(parts) => {
                for (key, value) in parts {
                    let key = key.as_str().ok_or_else(invalid)?;
                    let name = if name.is_empty() { key.to_owned() } else { format!("{name}.{key}") };
                    self.take(&name, value)?;
                }
                return Ok(());
            }
            Yaml::Bool(is) => Value::Bool(*is),
            Yaml::Number(number) => Value::Number(number.as_f64().ok_or_else(invalid)?),
            Yaml::String(text) => Value::Text(text.clone()),
            Yaml::Sequence(list) => {
                let texts = list.iter().map(|text| text.as_str().map(str::to_owned));
                Value::Texts(texts.collect::<Option<_>>().ok_or_else(invalid)?)
            }
            _ => return Err(invalid()),
        };
        self.0.insert(name.to_owned(), value);
        Ok(())
    }

    /// The text of a parameter file for this node.
    pub fn text(&self, node: &str) -> String {
        let mut text = format!("{node}:\n  ros__parameters:\n");
        for (name, value) in &self.0 {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "    {name}: {value}");
        }
        text
    }
}

//! Python objects that are printed, compared, copied and pickled by their keyword arguments.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// The value of a keyword.
enum Value {
    Number(f64),
    Count(u16),
    Word(&'static str),
    Object(Box<dyn Printed>),
}

/// An object that is the value of a keyword.
pub trait Printed {
    /// The object in Python.
    fn in_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>>;

    /// Its `repr`.
    fn text(&self) -> String;
}

/// The keyword arguments of an object.
#[derive(Default)]
pub struct Keywords(Vec<(&'static str, Value)>);

/// Arguments by which `copy` and `pickle` construct an object again.
pub type NewArguments<'py> = (Bound<'py, PyTuple>, Bound<'py, PyDict>);

impl Keywords {
    /// Adds a number.
    pub fn number(mut self, name: &'static str, number: f64) -> Self {
        self.0.push((name, Value::Number(number)));
        self
    }

    /// Adds a count.
    pub fn count(mut self, name: &'static str, count: u16) -> Self {
        self.0.push((name, Value::Count(count)));
        self
    }

    /// Adds a word.
    pub fn word(mut self, name: &'static str, word: &'static str) -> Self {
        self.0.push((name, Value::Word(word)));
        self
    }

    /// Adds an object, if there is one.
    pub fn object(mut self, name: &'static str, object: Option<impl Printed + 'static>) -> Self {
        self.0.extend(object.map(|object| (name, Value::Object(Box::new(object) as Box<dyn Printed>))));
        self
    }

    /// The keyword arguments for a call in Python.
    pub fn arguments<'py>(&self, py: Python<'py>) -> PyResult<NewArguments<'py>> {
        let keywords = PyDict::new(py);
        for (name, value) in &self.0 {
            match value {
                Value::Number(number) => keywords.set_item(name, number)?,
                Value::Count(count) => keywords.set_item(name, count)?,
                Value::Word(word) => keywords.set_item(name, word)?,
                Value::Object(object) => keywords.set_item(name, object.in_python(py)?)?,
            }
        }
        Ok((PyTuple::empty(py), keywords))
    }

    /// The call as text.
    pub fn call(&self, class: &str) -> String {
        let texts: Vec<String> = self
            .0
            .iter()
            .map(|(name, value)| match value {
                Value::Number(number) => format!("{name}={number:?}"),
                Value::Count(count) => format!("{name}={count}"),
                Value::Word(word) => format!("{name}='{word}'"),
                Value::Object(object) => format!("{name}={}", object.text()),
            })
            .collect();
        format!("{class}({})", texts.join(", "))
    }
}

/// Implements printing, comparing, copying and pickling of a class by its keywords.
macro_rules! object {
    ($class:ident, |$of:ident| $keywords:expr) => {
        #[pymethods]
        impl $class {
            pub(crate) fn __repr__(&self) -> String {
                let $of = &self.0;
                $keywords.call(stringify!($class))
            }

            fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
                other.cast::<Self>().is_ok_and(|other| other.get().0 == self.0)
            }

            fn __hash__(&self) -> u64 {
                let mut hasher = std::hash::DefaultHasher::new();
                std::hash::Hash::hash(&self.__repr__(), &mut hasher);
                std::hash::Hasher::finish(&hasher)
            }

            fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<$crate::keywords::NewArguments<'py>> {
                let $of = &self.0;
                $keywords.arguments(py)
            }
        }
    };
}
pub(crate) use object;

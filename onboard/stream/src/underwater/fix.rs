//! Measurements of the pose of an underwater vehicle, in addition to those of its velocity filter.

use crate::Scalar;
use crate::kind::Input;
use crate::numbers::Numbers;

/// A measurement of the pose with its noise, in double precision in every stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// The measured quantity.
    pub of: Of,
    /// Heading, rad, or z, m.
    pub value: f64,
    /// Standard deviation, rad or m.
    pub sigma: f64,
    /// Squared Mahalanobis distance beyond which it is an outlier.
    pub gate: f64,
}

/// The measured quantity of a fix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// The heading: [`HeadingFix`](scphd::models::HeadingFix).
    Heading,
    /// z: [`HeightFix`](scphd::models::HeightFix).
    Height,
}

const HEADING: u8 = 1;
const HEIGHT: u8 = 2;

impl Input for Fix {
    fn parts(&self) -> u8 {
        match self.of {
            Of::Heading => HEADING,
            Of::Height => HEIGHT,
        }
    }

    fn count(parts: u8) -> Option<usize> {
        matches!(parts, HEADING | HEIGHT).then_some(3)
    }

    fn scalar(_of_stream: Scalar) -> Scalar {
        Scalar::F64
    }

    fn put(&self, sink: &mut impl FnMut(f64)) {
        [self.value, self.sigma, self.gate].put(sink);
    }

    fn take(parts: u8, source: &mut impl FnMut() -> Option<f64>) -> Option<Self> {
        let [value, sigma, gate] = Numbers::take(source)?;
        Some(Self { of: if parts == HEADING { Of::Heading } else { Of::Height }, value, sigma, gate })
    }
}

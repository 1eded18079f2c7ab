//! How many particles a resampling leaves: as many as the places they are at need (KLD sampling, Fox 2003).

use crate::{ConfigError, Real};

/// As many particles as keep the Kullback–Leibler divergence between them and the density that they sample, both taken over
/// cells of the ground plane and of the heading, below `error` with probability 1 − `risk`; at most
/// [`Config::particles`](crate::Config::particles).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Adaptive<T> {
    /// ε.
    pub error: T,
    /// δ.
    pub risk: T,
    /// Never fewer. Of few particles N_eff hardly falls below a high threshold, and only a resampling makes more of them.
    pub least: usize,
    /// Side of a cell in x and y, m.
    pub cell_m: T,
    /// Side of a cell in heading, rad.
    pub cell_rad: T,
}

impl<T: Real> Default for Adaptive<T> {
    /// Fox's figures: 5 %, 1 %; cells of half a metre and ten degrees.
    fn default() -> Self {
        Self {
            error: T::from_f64(0.05),
            risk: T::from_f64(0.01),
            least: 8,
            cell_m: T::from_f64(0.5),
            cell_rad: T::from_f64(0.175),
        }
    }
}

impl<T: Real> Adaptive<T> {
    /// The first field that is out of range, if any.
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let require = |holds, field, range| if holds { Ok(()) } else { Err(ConfigError { field, range }) };
        let positive = |x: T| x > T::ZERO && x.is_finite();
        require(positive(self.error), "adaptive.error", "finite and positive")?;
        require(self.risk > T::ZERO && self.risk < T::ONE, "adaptive.risk", "above 0 and below 1")?;
        require(self.least >= 1, "adaptive.least", "at least 1")?;
        require(positive(self.cell_m), "adaptive.cell_m", "finite and positive")?;
        require(positive(self.cell_rad), "adaptive.cell_rad", "finite and positive")
    }
}

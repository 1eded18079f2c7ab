//! Differences between filter and reference.

/// Reason for refusing a log with fixes.
pub(super) const NO_FIXES: &str = "the reference takes no fixes of the pose";

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Figure {
    Greatest(f64),
    Count(usize),
}

/// The figures of a scan, or of several.
pub trait Figures {
    /// The names of the figures in a table.
    const NAMES: &'static [&'static str];

    /// The figures in this order.
    fn figures(&self) -> Vec<Figure>;
}

pub(super) trait Field {
    /// Adds the figure of other scans.
    fn merge(&mut self, other: Self);

    fn figure(&self) -> Figure;
}

impl Field for f64 {
    fn merge(&mut self, other: Self) {
        *self = larger(*self, other);
    }

    fn figure(&self) -> Figure {
        Figure::Greatest(*self)
    }
}

impl Field for usize {
    fn merge(&mut self, other: Self) {
        *self += other;
    }

    fn figure(&self) -> Figure {
        Figure::Count(*self)
    }
}

/// A struct of figures, each with its name in a table.
macro_rules! figures {
    ($(#[$about:meta])* $name:ident { $($field:ident: $kind:ty = $title:literal,)+ }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub struct $name { $(pub $field: $kind,)+ }

        impl $name {
            pub(super) fn merge(&mut self, other: &Self) {
                $($crate::compare::differences::Field::merge(&mut self.$field, other.$field);)+
            }
        }

        impl $crate::compare::Figures for $name {
            const NAMES: &'static [&'static str] = &[$($title),+];

            fn figures(&self) -> Vec<$crate::compare::Figure> {
                vec![$($crate::compare::differences::Field::figure(&self.$field)),+]
            }
        }
    };
}
pub(super) use figures;

figures! {
    /// Largest differences between filter and reference, relative unless the name has a unit.
    /// `docs/results.md` defines them.
    Differences {
        scans: usize = "scans",
        predicted_position_m: f64 = "predicted position (m)",
        predicted_heading_rad: f64 = "predicted heading (rad)",
        waited_s: f64 = "time since the scan (s)",
        ln_likelihood: f64 = "ln likelihood (relative)",
        particle_weight: f64 = "particle weight (relative)",
        component_weight: f64 = "component weight (relative)",
        mean: f64 = "component mean (relative)",
        covariance: f64 = "component covariance (relative)",
        mass: f64 = "map mass (relative)",
        estimated_position_m: f64 = "estimated position (m)",
        estimated_heading_rad: f64 = "estimated heading (rad)",
        other_survivors: usize = "scans with other survivors",
        components: usize = "static components compared",
        moving_components: usize = "moving components compared",
        unmatched: usize = "components unmatched",
        unmatched_mass: f64 = "unmatched mass (share of a map)",
        capacity_events: usize = "scans short of room",
    }
}

/// A comparison over a whole log.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison<D = Differences> {
    pub scans: Vec<D>,
    /// The largest differences of all scans.
    pub overall: D,
}

pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

pub(super) fn norm(a: &[f64]) -> f64 {
    a.iter().map(|x| x.powi(2)).sum::<f64>().sqrt()
}

/// The greater of two differences; NaN is the greatest.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

pub(super) fn relative(a: f64, b: f64) -> f64 {
    let scale = a.abs().max(b.abs());
    if a == b { 0.0 } else { (a - b).abs() / scale }
}

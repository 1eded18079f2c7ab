//! Differences between filter and reference as a table.

use super::table::{grouped, ruled};
use comfy_table::Row;
use scphd_run::compare::{Figure, Figures};
use std::iter;

/// The differences over a log as text without a newline at the end: a row for each parameter of the filter and for each figure, a
/// column for each precision.
pub fn render<D: Figures>(log: &str, parameters: &[(&str, String)], compared: &[(&str, D)]) -> String {
    let row = |name: &str, show: &dyn Fn(&(&str, D)) -> String| {
        Row::from(iter::once(name.to_owned()).chain(compared.iter().map(show)).collect::<Vec<_>>())
    };
    let precision = row("precision", &|(precision, _)| (*precision).to_owned());
    let parameters = parameters.iter().map(|(name, value)| row(name, &|_| value.clone()));
    let figures = D::NAMES.iter().enumerate().map(|(k, name)| row(name, &|(_, found)| shown(found.figures()[k])));
    ruled(row("log", &|_| log.to_owned()), iter::once(precision).chain(parameters).chain(figures))
}

/// A count, or a difference with its order of magnitude.
fn shown(figure: Figure) -> String {
    match figure {
        Figure::Count(count) => grouped(count as u64),
        Figure::Greatest(0.0) => "0".into(),
        Figure::Greatest(difference) => format!("{difference:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn magnitudes_are_readable() {
        for (difference, text) in [(0.0, "0"), (1.234e-12, "1.23e-12"), (f64::NAN, "NaN")] {
            assert_eq!(shown(Figure::Greatest(difference)), text);
        }
    }
}

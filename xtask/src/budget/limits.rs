//! `budgets.toml`.

use std::path::Path;

use serde::Deserialize;

use super::figures::Figures;
use crate::firmware::streams::{Precision, Source, Variant};

/// One entry: what to measure, and what it may take.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    pub board: String,
    pub configuration: String,
    pub scenario: String,
    pub scans: usize,
    pub flash_bytes: u64,
    pub library_flash_bytes: u64,
    pub state_bytes: u64,
    pub stack_bytes: u64,
    pub instructions_per_predict_worst: u64,
    pub instructions_per_scan_mean: u64,
    pub instructions_per_scan_worst: u64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    budget: Vec<Budget>,
}

/// Reads the entries; a file without any checks nothing, and is refused.
pub fn read(path: &Path) -> Result<Vec<Budget>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    parse(&text).map_err(|error| format!("{}: {error}", path.display()))
}

fn parse(text: &str) -> Result<Vec<Budget>, String> {
    let File { budget } = toml::from_str(text).map_err(|error| error.to_string())?;
    if budget.is_empty() { Err("no budget in it".into()) } else { Ok(budget) }
}

impl Budget {
    /// What to replay.
    pub fn source(&self) -> Source<'_> {
        Source { what: &self.scenario, scans: self.scans, variant: self.variant() }
    }

    fn variant(&self) -> Variant {
        let named = Variant::NAMED.into_iter().find(|variant| self.configuration.contains(variant.mark()));
        named.unwrap_or(Variant::Plain)
    }

    /// The number type that the configuration ends with.
    pub fn precision(&self) -> Result<Precision, String> {
        let rig = self.source().rig();
        let configuration = self.configuration.replace(self.variant().mark(), "");
        let found = rig.precisions.iter().find(|&&precision| configuration == rig.configuration(precision));
        found
            .copied()
            .ok_or_else(|| format!("budgets.toml: no configuration `{}` of {}", self.configuration, self.scenario))
    }

    /// The limits that these figures are above, one line each.
    pub fn broken_by(&self, figures: &Figures) -> Vec<String> {
        let limits = [
            ("flash_bytes", figures.flash_bytes, self.flash_bytes),
            ("library_flash_bytes", figures.library_flash_bytes, self.library_flash_bytes),
            ("state_bytes", figures.state_bytes, self.state_bytes),
            ("stack_bytes", figures.stack_bytes, self.stack_bytes),
            ("stack_bound_bytes", figures.stack_bound_bytes, self.stack_bytes),
            (
                "instructions_per_predict_worst",
                figures.instructions_per_predict_worst,
                self.instructions_per_predict_worst,
            ),
            ("instructions_per_scan_mean", figures.instructions_per_scan_mean, self.instructions_per_scan_mean),
            ("instructions_per_scan_worst", figures.instructions_per_scan_worst, self.instructions_per_scan_worst),
        ];
        let broken = limits.into_iter().filter(|(_, found, limit)| found > limit);
        let what = format!("{} {} {}", self.board, self.configuration, self.scenario);
        broken.map(|(name, found, limit)| format!("{what}: {name} is {found}, limit {limit}")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process;

    #[test]
    fn the_projects_budgets_can_be_read() {
        for budget in read(&process::root().join("budgets.toml")).unwrap() {
            assert!(budget.precision().is_ok() && budget.scans > 0, "{budget:?}");
            assert!(super::super::board_of(&budget).is_ok());
        }
    }

    #[test]
    fn a_limit_below_the_figure_is_broken_and_one_at_it_is_kept() {
        let budget = read(&process::root().join("budgets.toml")).unwrap().remove(0);
        let mut figures = Figures {
            flash_bytes: budget.flash_bytes,
            library_flash_bytes: budget.library_flash_bytes,
            state_bytes: budget.state_bytes,
            stack_bytes: budget.stack_bytes,
            stack_bound_bytes: budget.stack_bytes,
            instructions_per_predict_worst: budget.instructions_per_predict_worst,
            instructions_per_scan_mean: budget.instructions_per_scan_mean,
            instructions_per_scan_worst: budget.instructions_per_scan_worst,
            ..Figures::default()
        };
        assert!(budget.broken_by(&figures).is_empty());
        for raise in [
            |figures: &mut Figures| figures.flash_bytes += 1,
            |figures: &mut Figures| figures.library_flash_bytes += 1,
            |figures: &mut Figures| figures.state_bytes += 1,
            |figures: &mut Figures| figures.stack_bytes += 1,
            |figures: &mut Figures| figures.stack_bound_bytes += 1,
            |figures: &mut Figures| figures.instructions_per_predict_worst += 1,
            |figures: &mut Figures| figures.instructions_per_scan_mean += 1,
            |figures: &mut Figures| figures.instructions_per_scan_worst += 1,
        ] {
            let before = figures.clone();
            raise(&mut figures);
            assert_eq!(budget.broken_by(&figures).len(), 1);
            figures = before;
        }
    }

    #[test]
    fn no_budgets_and_unknown_limits_are_refused() {
        assert!(parse("budget = []").is_err());
        assert!(parse("").is_err());
        assert!(parse("[[budget]]\nboard = \"x\"\nspeed = 3").is_err());
    }
}

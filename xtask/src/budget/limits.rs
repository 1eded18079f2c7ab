//! The limits of `budgets.toml`, and the comparison of figures with them.

use super::entry::{Budget, FAULTS, WORST_CASE};
use super::figures::Figures;
use crate::{files, process};
use serde::Deserialize;

pub const FILE: &str = "budgets.toml";

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budgets {
    /// The compiler that the limits were set with.
    pub compiler: String,
    /// Margin of a limit above the measured figure.
    margin_percent: u64,
    /// Additional margin for the code of another compiler.
    other_compiler_percent: u64,
    #[serde(rename = "budget")]
    pub entries: Vec<Budget>,
}

/// Greatest ratio of a limit to its figure, in tenths. A higher limit would not detect a regression.
const LOOSE_TENTHS: u64 = 12;

/// Reads the file. A file without entries is refused, because it would check nothing.
pub fn read() -> Result<Budgets, String> {
    parse(&files::text(&process::root().join(FILE))?).map_err(|error| format!("{FILE}: {error}"))
}

fn parse(text: &str) -> Result<Budgets, String> {
    let budgets: Budgets = toml::from_str(text).map_err(|error| error.to_string())?;
    if budgets.entries.is_empty() { Err("no budget in it".into()) } else { Ok(budgets) }
}

impl Budgets {
    /// The violations by these figures, one line each: figures above their limits and, with the compiler of the file,
    /// limits that are too far above their figures.
    pub fn broken_by(&self, measured: &[Figures], compiler: &str) -> Vec<String> {
        let same = compiler == self.compiler;
        let more_percent = if same { 0 } else { self.other_compiler_percent };
        let each = self.entries.iter().zip(measured).flat_map(|(budget, figures)| {
            let mut broken = budget.broken_by(figures, more_percent);
            if same {
                broken.extend(budget.loose_for(figures));
            }
            broken
        });
        each.chain(self.longer_than_the_worst_case(measured)).collect()
    }

    /// The limit of a scan in the worst case, instructions.
    pub fn worst_case(&self, board: &str, configuration: &str) -> Result<u64, String> {
        let is_it = |entry: &&Budget| {
            (&*entry.board, &*entry.configuration) == (board, configuration) && entry.scenario.starts_with(WORST_CASE)
        };
        let found = self.entries.iter().find(is_it).map(|entry| entry.instructions_per_scan_worst);
        found.ok_or_else(|| format!("{FILE}: no worst case of {configuration} on {board}"))
    }

    /// The entries with faults in which a scan takes longer than the limit of the worst case, one line each.
    fn longer_than_the_worst_case(&self, measured: &[Figures]) -> Vec<String> {
        let under_faults = self.entries.iter().zip(measured).filter(|(entry, _)| entry.scenario == FAULTS);
        let line = |(entry, figures): (&Budget, &Figures)| {
            let found = figures.instructions_per_scan_worst;
            match self.worst_case(&entry.board, &entry.configuration) {
                Ok(limit) if found <= limit => None,
                Ok(limit) => Some(format!("{}: a scan takes {found}, and the worst case {limit}", entry.what())),
                Err(missing) => Some(missing),
            }
        };
        under_faults.filter_map(line).collect()
    }

    /// The file with new limits. Its lines before `compiler` are unchanged.
    pub fn rewritten(&self, text: &str, measured: &[Figures], compiler: &str) -> String {
        let head: String =
            text.lines().take_while(|line| !line.starts_with("compiler")).map(|line| format!("{line}\n")).collect();
        let mut file = format!(
            "{head}compiler = {compiler:?}\nmargin_percent = {}\nother_compiler_percent = {}\n",
            self.margin_percent, self.other_compiler_percent
        );
        for (budget, figures) in self.entries.iter().zip(measured) {
            file += &format!(
                "\n[[budget]]\nboard = {:?}\nconfiguration = {:?}\nscenario = {:?}\nscans = {}\n",
                budget.board, budget.configuration, budget.scenario, budget.scans
            );
            for (name, found, _) in budget.limits(figures) {
                file += &format!("{name} = {}\n", grouped(rounded_up(found, self.margin_percent)));
            }
        }
        file
    }
}

/// The figure plus this number of percent, rounded up to three digits.
fn rounded_up(figure: u64, percent: u64) -> u64 {
    let raised = (figure * (100 + percent)).div_ceil(100);
    let step = 10_u64.pow(raised.max(1).ilog10().saturating_sub(2));
    raised.next_multiple_of(step)
}

/// The number in groups of three digits, as `1_234_567`.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
    groups.collect::<Vec<_>>().join("_")
}

impl Budget {
    /// All limits: name, measured figure, limit.
    fn limits(&self, figures: &Figures) -> [(&'static str, u64, u64); 7] {
        let worst_predict = figures.instructions_per_predict_worst;
        [
            ("flash_bytes", figures.flash_bytes, self.flash_bytes),
            ("library_flash_bytes", figures.library_flash_bytes, self.library_flash_bytes),
            ("state_bytes", figures.state_bytes, self.state_bytes),
            ("stack_bytes", figures.stack_bytes.max(figures.stack_bound_bytes), self.stack_bytes),
            ("instructions_per_predict_worst", worst_predict, self.instructions_per_predict_worst),
            ("instructions_per_scan_mean", figures.instructions_per_scan_mean, self.instructions_per_scan_mean),
            ("instructions_per_scan_worst", figures.instructions_per_scan_worst, self.instructions_per_scan_worst),
        ]
    }

    /// The figures that are above their limits by more than `more_percent` percent, one line each.
    fn broken_by(&self, figures: &Figures, more_percent: u64) -> Vec<String> {
        let limits = self.limits(figures).map(|(name, found, limit)| (name, found, limit * (100 + more_percent) / 100));
        let broken = limits.into_iter().filter(|(_, found, limit)| found > limit);
        broken.map(|(name, found, limit)| format!("{}: {name} is {found}, limit {limit}", self.what())).collect()
    }

    /// The limits that are too far above these figures, one line each.
    fn loose_for(&self, figures: &Figures) -> Vec<String> {
        let loose = self.limits(figures).into_iter().filter(|(_, found, limit)| 10 * limit > LOOSE_TENTHS * found);
        let line = |(name, found, limit)| {
            format!("{}: {name} is {found}, and the limit {limit} too far above to guard it", self.what())
        };
        loose.map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COMPILER: &str = "rustc 1";

    /// The first of the project's budgets, set with [`COMPILER`].
    fn one() -> Budgets {
        let mut budgets = read().unwrap();
        budgets.entries.truncate(1);
        COMPILER.clone_into(&mut budgets.compiler);
        budgets
    }

    fn at_the_limits(budget: &Budget) -> Figures {
        Figures {
            flash_bytes: budget.flash_bytes,
            library_flash_bytes: budget.library_flash_bytes,
            state_bytes: budget.state_bytes,
            stack_bytes: budget.stack_bytes,
            stack_bound_bytes: budget.stack_bytes,
            instructions_per_predict_worst: budget.instructions_per_predict_worst,
            instructions_per_scan_mean: budget.instructions_per_scan_mean,
            instructions_per_scan_worst: budget.instructions_per_scan_worst,
            ..Figures::default()
        }
    }

    #[test]
    fn the_projects_budgets_can_be_read() {
        let budgets = read().unwrap();
        assert!(budgets.compiler.starts_with("rustc 1."));
        for budget in budgets.entries {
            assert!(budget.source().is_ok() && budget.scans > 0, "{budget:?}");
            assert!(super::super::board_of(&budget).is_ok());
        }
    }

    #[test]
    fn a_figure_above_its_limit_is_reported_and_one_at_it_is_not() {
        let budget = read().unwrap().entries.remove(0);
        let mut figures = at_the_limits(&budget);
        assert!(budget.broken_by(&figures, 0).is_empty());
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
            assert_eq!(budget.broken_by(&figures, 0).len(), 1);
            figures = before;
        }
    }

    #[test]
    fn no_fault_makes_a_scan_longer_than_the_worst_case() {
        let budgets = read().unwrap();
        let mut figures: Vec<Figures> = budgets.entries.iter().map(at_the_limits).collect();
        assert!(budgets.entries.iter().filter(|entry| entry.scenario == FAULTS).count() >= 4);
        assert_eq!(budgets.longer_than_the_worst_case(&figures), Vec::<String>::new());
        let place = budgets.entries.iter().position(|entry| entry.scenario == FAULTS).unwrap();
        let entry = &budgets.entries[place];
        figures[place].instructions_per_scan_worst =
            budgets.worst_case(&entry.board, &entry.configuration).unwrap() + 1;
        assert_eq!(budgets.longer_than_the_worst_case(&figures).len(), 1);
        assert!(budgets.worst_case("no board", "32x2-f32").is_err());
    }

    #[test]
    fn another_compiler_has_an_additional_margin() {
        let budgets = one();
        let mut figures = at_the_limits(&budgets.entries[0]);
        figures.flash_bytes += figures.flash_bytes * (budgets.other_compiler_percent - 1) / 100;
        assert_eq!(budgets.broken_by(&[figures.clone()], COMPILER).len(), 1);
        assert!(budgets.broken_by(&[figures.clone()], "rustc 2").is_empty());
        figures.flash_bytes += figures.flash_bytes * 2 / 100;
        assert_eq!(budgets.broken_by(&[figures], "rustc 2").len(), 1);
    }

    #[test]
    fn a_limit_far_above_its_figure_is_reported() {
        let budgets = one();
        let mut figures = at_the_limits(&budgets.entries[0]);
        figures.instructions_per_scan_worst = figures.instructions_per_scan_worst * 10 / 13;
        let broken = budgets.broken_by(&[figures.clone()], COMPILER);
        assert!(broken.len() == 1 && broken[0].contains("too far above"), "{broken:?}");
        assert!(budgets.broken_by(&[figures], "rustc 2").is_empty());
    }

    #[test]
    fn new_limits_are_not_exceeded_and_not_loose() {
        let before = read().unwrap();
        let mut figures: Vec<Figures> = before.entries.iter().map(at_the_limits).collect();
        figures.iter_mut().for_each(|figures| figures.flash_bytes = 2 * figures.flash_bytes + 1);
        let text = before.rewritten("# Head.\n\ncompiler = \"old\"\n", &figures, COMPILER);
        assert!(text.starts_with("# Head.\n\ncompiler = \"rustc 1\"\n"), "{text}");
        let after = parse(&text).unwrap();
        assert_eq!(after.entries.len(), before.entries.len());
        assert_eq!(after.broken_by(&figures, COMPILER), Vec::<String>::new());
        assert!(!before.broken_by(&figures, &before.compiler).is_empty());
    }

    #[test]
    fn limits_are_rounded_up_to_three_digits() {
        assert_eq!((rounded_up(153_924, 5), rounded_up(5_828, 5), rounded_up(100, 0)), (162_000, 6_120, 100));
        assert_eq!((rounded_up(7, 5), rounded_up(0, 5)), (8, 0));
        assert_eq!(
            (grouped(1_234_567), grouped(12), grouped(120_000)),
            ("1_234_567".into(), "12".into(), "120_000".into())
        );
    }

    #[test]
    fn no_budgets_and_unknown_limits_are_refused() {
        let head = "compiler = \"c\"\nmargin_percent = 5\nother_compiler_percent = 5\n";
        assert!(parse(&format!("{head}budget = []")).is_err());
        assert!(parse(head).is_err());
        assert!(parse("").is_err());
        assert!(parse(&format!("{head}[[budget]]\nboard = \"x\"\nspeed = 3")).is_err());
    }
}

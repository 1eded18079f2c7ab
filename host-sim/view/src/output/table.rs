//! Summaries on a terminal: a row for each figure, a column for each run.

use comfy_table::{CellAlignment, ContentLineStyle, LineStyle, Row, Table, TableStyle};
use scphd_score::results::json::Summary;

/// Greatest number of runs in a table; five fit a terminal of 132 columns.
const RUNS_PER_TABLE: usize = 5;

const UNKNOWN: &str = "–";

/// Rules above, below and under the header; none between the figures.
const STYLE: TableStyle = TableStyle::new()
    .top_border(LineStyle::none().fill('─').junction('─'))
    .header_lines(ContentLineStyle::none().junction(' '))
    .header_separator(LineStyle::none().fill('─').junction('─'))
    .content_lines(ContentLineStyle::none().junction(' '))
    .bottom_border(LineStyle::none().fill('─').junction('─'));

/// A figure: its name with the unit, and its text for a summary.
type Figure = (&'static str, fn(&Summary) -> String);

/// The figures in the order of the rows.
const FIGURES: [Figure; 34] = [
    ("filter", |s| s.filter.clone()),
    ("precision", |s| s.precision.clone()),
    ("particles", |s| grouped(s.particles)),
    ("seed", |s| s.seed.to_string()),
    ("scans", |s| grouped(s.scans)),
    ("position RMSE (m)", |s| decimals(s.position_rmse_m, 3)),
    ("  laid over the truth (m)", |s| decimals(s.position_rmse_aligned_m, 3)),
    ("heading RMSE (deg)", |s| decimals(s.heading_rmse_deg, 3)),
    ("dead reckoning RMSE (m)", |s| decimals(s.dead_reckoning_rmse_m, 3)),
    ("final position error (m)", |s| decimals(s.final_position_error_m, 3)),
    ("OSPA (m)", |s| decimals(s.ospa_m, 3)),
    ("  localization (m)", |s| decimals(s.ospa_localization_m, 3)),
    ("  cardinality (m)", |s| decimals(s.ospa_cardinality_m, 3)),
    ("GOSPA (m)", |s| decimals(s.gospa_m, 3)),
    ("  of what was in view (m)", |s| decimals(s.gospa_seen_m, 3)),
    ("features estimated", |s| decimals(s.features_estimated, 1)),
    ("landmarks mapped within 0.5 m", |s| count(s.static_features_matched)),
    ("  median error (m)", |s| decimals(s.static_position_error_median_m, 3)),
    ("  false features", |s| count(s.static_features_false)),
    ("ln evidence", |s| decimals(s.ln_evidence, 1)),
    ("innovations (NIS/dim)", |s| decimals(s.nis_mean, 2)),
    ("  within 95 % of χ² (%)", |s| percent(s.nis_within_95)),
    ("position errors (NEES/dim), median", |s| decimals(s.nees_median, 2)),
    ("  within 95 % of χ² (%)", |s| percent(s.nees_within_95)),
    ("pose errors (NEES/dim), median", |s| decimals(s.nees_pose_median, 2)),
    ("  within 95 % of χ² (%)", |s| percent(s.nees_pose_within_95)),
    ("movers found in 10 scans", |s| decimals(s.moving_hit_rate, 3)),
    ("  tracked afterwards", |s| decimals(s.moving_settled_rate, 3)),
    ("  median error (m)", |s| decimals(s.moving_position_error_median_m, 3)),
    ("  false tracks a scan", |s| decimals(s.false_moving_tracks_per_scan, 3)),
    ("scan, mean (µs)", |s| decimals(s.scan_us_mean, 1)),
    ("scan, 99 % (µs)", |s| decimals(s.scan_us_p99, 1)),
    ("state (KiB)", |s| {
        // Exact below 2⁵³ bytes.
        decimals(s.state_bytes.map(|bytes| bytes as f64 / 1024.0), 1)
    }),
    ("digest", |s| match s.digest {
        Some(digest) => format!("{digest:016x}"),
        None => UNKNOWN.into(),
    }),
];

/// The summaries as text without a newline at the end: plain UTF-8 without colours, the same on every terminal.
///
/// More than five runs continue in further tables below the first.
pub fn render(summaries: &[Summary]) -> String {
    let tables: Vec<String> = summaries.chunks(RUNS_PER_TABLE).map(block).collect();
    tables.join("\n\n")
}

/// One table for a few runs.
fn block(summaries: &[Summary]) -> String {
    let rows = FIGURES.into_iter().map(|(name, show)| row(name, summaries, show));
    ruled(row("log", summaries, |s| s.log.clone()), rows)
}

/// A header and rows as text: names aligned left, everything else right.
pub(crate) fn ruled(header: Row, rows: impl Iterator<Item = Row>) -> String {
    let mut table = Table::new();
    table.load_style(STYLE);
    table.set_header(header);
    table.add_rows(rows);
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt()
}

/// A row with the name of a figure and its value in every run.
fn row(name: &str, summaries: &[Summary], show: impl Fn(&Summary) -> String) -> Row {
    let mut cells = vec![name.to_string()];
    cells.extend(summaries.iter().map(show));
    Row::from(cells)
}

/// A number with fixed decimals and grouped thousands; as a power of ten if it would be long or all zeros.
pub(crate) fn decimals(value: Option<f64>, digits: usize) -> String {
    let Some(value) = value.filter(|v| v.is_finite()) else {
        return UNKNOWN.into();
    };
    let smallest = 0.5 * 10f64.powi(-(digits as i32));
    if value.abs() >= 1e9 || (value != 0.0 && value.abs() < smallest) {
        return format!("{value:.2e}");
    }
    let text = format!("{:.digits$}", value.abs());
    let (whole, fraction) = text.split_once('.').unwrap_or((&text, ""));
    let sign = if value < 0.0 { "-" } else { "" };
    let point = if fraction.is_empty() { "" } else { "." };
    format!("{sign}{}{point}{fraction}", group_digits(whole))
}

/// A share as a percentage, which may be unknown.
fn percent(share: Option<f64>) -> String {
    decimals(share.map(|share| 100.0 * share), 1)
}

/// A count that may be unknown.
fn count(value: Option<u64>) -> String {
    value.map_or_else(|| UNKNOWN.into(), grouped)
}

/// A count with its thousands grouped.
pub(crate) fn grouped(value: u64) -> String {
    group_digits(&value.to_string())
}

/// Puts a space between groups of three digits, from five digits on.
fn group_digits(digits: &str) -> String {
    if digits.len() < 5 {
        return digits.into();
    }
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_score::results::json::made_up as summary;

    #[test]
    fn numbers_are_readable() {
        assert_eq!(decimals(Some(0.1234), 3), "0.123");
        assert_eq!(decimals(Some(-12345.678), 1), "-12 345.7");
        assert_eq!(decimals(Some(0.0), 3), "0.000");
        assert_eq!(decimals(Some(0.0001), 3), "1.00e-4");
        assert_eq!(decimals(Some(3e12), 3), "3.00e12");
        assert_eq!(decimals(Some(f64::NAN), 3), UNKNOWN);
        assert_eq!(decimals(None, 3), UNKNOWN);
        assert_eq!(grouped(7000), "7000");
        assert_eq!(grouped(1_234_567), "1 234 567");
    }

    #[test]
    fn every_run_has_a_column() {
        let reference = Summary {
            filter: "reference".into(),
            precision: "f64".into(),
            state_bytes: None,
            digest: None,
            ..summary()
        };
        let text = render(&[summary(), reference]);
        println!("{text}");
        let cells = |name: &str| -> Vec<String> {
            let line = text.lines().find(|l| l.contains(name)).unwrap();
            line.split_once(name).unwrap().1.split_whitespace().map(String::from).collect()
        };
        assert_eq!(cells("filter"), ["scphd", "reference"]);
        assert_eq!(cells("position RMSE (m)"), ["0.300", "0.300"]);
        assert_eq!(cells("heading RMSE (deg)"), [UNKNOWN, UNKNOWN]);
        assert_eq!(cells("state (KiB)"), ["256.0", UNKNOWN]);
        assert_eq!(cells("digest"), ["0123456789abcdef", UNKNOWN]);
        assert!(!text.contains('\u{1b}'), "no escape sequences");
        assert!(text.lines().all(|l| !l.ends_with(' ')));
    }

    #[test]
    fn many_runs_continue_in_further_tables_and_no_table_is_empty() {
        let text = render(&vec![summary(); RUNS_PER_TABLE + 1]);
        assert_eq!(text.matches("position RMSE").count(), 2);
        assert!(text.lines().all(|l| l.chars().count() <= 132), "{text}");
        assert_eq!(render(&[]), "");
    }
}

//! Results of `tune`, as tables and sentences.

use super::table::{decimals, grouped, ruled};
use comfy_table::Row;
use scphd_run::tune::{Gain, Outcome, Said, Tuned, position_rmse_m, score};

/// Significant digits of a setting.
const DIGITS: usize = 4;

/// The tables of the estimates and of the candidates, and the result. `truth`: with the errors.
pub fn render<S>(log: &str, tuned: &Tuned<S>, truth: bool) -> String {
    let Tuned { said, outcome } = tuned;
    let innovations = ruled(
        Row::from([log, "now", "innovations say", "observations", "proposed"]),
        said.iter().map(|said| setting(said, outcome)),
    );
    let mut header = vec!["candidate", "how", "runs", "foresees more by (nats)", "verdict"];
    if truth {
        header.push("held-out RMSE (m)");
    }
    let tried = ruled(Row::from(header), (0..outcome.tried.len()).map(|index| candidate(outcome, index, truth)));
    format!("{innovations}\n\n{tried}\n\n{}", verdict(outcome, truth))
}

fn setting<S>(said: &Said, outcome: &Outcome<S>) -> Row {
    let proposed = outcome.proposed().and_then(|candidate| {
        let change = candidate.changes.iter().find(|change| change.field == said.field)?;
        change.size()
    });
    let mark = if said.clamped { " (clamped)" } else { "" };
    Row::from([
        said.field.to_owned(),
        significant(Some(said.now)),
        format!("{}{mark}", significant(said.to)),
        grouped(said.observations as u64),
        proposed.map_or_else(|| "as now".to_owned(), |value| significant(Some(value))),
    ])
}

/// A number with a fixed number of significant digits, because settings differ in magnitude.
fn significant(value: Option<f64>) -> String {
    let whole = value.filter(|value| *value != 0.0).map_or(0, |value| value.abs().log10().floor() as i32 + 1);
    decimals(value, usize::try_from(DIGITS as i32 - whole).unwrap_or(0))
}

fn candidate<S>(outcome: &Outcome<S>, index: usize, truth: bool) -> Row {
    let tried = &outcome.tried[index];
    let best = outcome.best.as_ref().filter(|best| best.tried == index);
    let verdict = match (best, tried.gain) {
        (Some(best), _) if best.confirmed => "proposed",
        (Some(_), _) => "refused: other seeds do not confirm it",
        (None, None) => "refused: the filter cannot run with it",
        (None, Some(_)) if tried.wins => "wins, another one by more",
        (None, Some(gain)) if gain.mean < 0.0 => "refused: it loses",
        (None, Some(_)) if tried.runs.len() < outcome.now.len() => "refused: others foresee more",
        (None, Some(_)) => "refused: it does not win clearly",
    };
    let mut row = vec![
        tried.candidate.group.name().to_owned(),
        tried.candidate.how.clone(),
        tried.runs.len().to_string(),
        tried.gain.map_or_else(|| "–".into(), |gain| shown(&gain)),
        verdict.to_owned(),
    ];
    if truth {
        row.push(decimals(position_rmse_m(&tried.runs), 3));
    }
    Row::from(row)
}

fn shown(gain: &Gain) -> String {
    format!("{:+.3} ± {:.3}", gain.mean, gain.error)
}

fn verdict<S>(outcome: &Outcome<S>, truth: bool) -> String {
    let Some(best) = &outcome.best else {
        let error =
            if truth { format!(", RMSE {} m", decimals(position_rmse_m(&outcome.now), 3)) } else { String::new() };
        return format!(
            "nothing is proposed: held-out score {:.3} nats a measurement as it is{error}",
            score(&outcome.now)
        );
    };
    let candidate = &outcome.tried[best.tried].candidate;
    let name = format!("{}, {}", candidate.group.name(), candidate.how);
    let decided = if best.confirmed { "proposed" } else { "refused" };
    let mut text = format!(
        "{name}: {decided}; with {} other seeds the held-out score is {:.3} before, {:.3} after ({} nats a measurement)",
        best.now.len(),
        score(&best.now),
        score(&best.then),
        shown(&best.gain),
    );
    if let Some((before, after)) = position_rmse_m(&best.now).zip(position_rmse_m(&best.then)).filter(|_| truth) {
        text += &format!("; held-out RMSE {before:.3} m before, {after:.3} m after");
    }
    text
}

/// A line of a study over several logs: the proposal, and the errors with the seeds that confirmed it.
pub fn line<S>(log: &str, tuned: &Tuned<S>) -> String {
    let outcome = &tuned.outcome;
    let Some(best) = outcome.best.as_ref() else {
        return format!("{log}: nothing proposed, RMSE {} m", decimals(position_rmse_m(&outcome.now), 3));
    };
    let candidate = &outcome.tried[best.tried].candidate;
    let (before, after) = (position_rmse_m(&best.now), position_rmse_m(&best.then));
    let ratio = before.zip(after).map(|(before, after)| after / before);
    format!(
        "{log}: {} {} ({}), score {}, RMSE {} -> {} m, ratio {}",
        candidate.group.name(),
        if best.confirmed { "proposed" } else { "refused" },
        candidate.how,
        shown(&best.gain),
        decimals(before, 3),
        decimals(after, 3),
        decimals(ratio, 3),
    )
}

/// Ratios of the held-out errors with the proposals to those before, over several logs.
pub fn summary<S>(logs: &[Tuned<S>]) -> String {
    let ratio = |tuned: &Tuned<S>| {
        let best = tuned.outcome.best.as_ref().filter(|best| best.confirmed)?;
        Some(position_rmse_m(&best.then)? / position_rmse_m(&best.now)?)
    };
    let mut ratios: Vec<f64> = logs.iter().filter_map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let count = |holds: fn(f64) -> bool| ratios.iter().filter(|ratio| holds(**ratio)).count();
    let middle = (!ratios.is_empty()).then(|| 0.5 * (ratios[(ratios.len() - 1) / 2] + ratios[ratios.len() / 2]));
    format!(
        "{} logs, proposals in {}: held-out RMSE at most 1.05 times in {}, less in {}; ratio median {}, greatest {}",
        logs.len(),
        ratios.len(),
        count(|ratio| ratio <= 1.05),
        count(|ratio| ratio < 1.0),
        decimals(middle, 2),
        decimals(ratios.last().copied(), 2),
    )
}

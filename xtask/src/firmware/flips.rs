//! Bit flips in the filter's state during a replay on a board: after every round the state and the number of repairs must be
//! those of the host, and no scan may exceed the worst case.

use super::board::FIRST;
use super::rig::{FEW, FEW_JOINT, Precision, Rig};
use super::streams::{self, Source};
use super::{emulator, image, output};
use crate::budget;

const FEATURES: [&str; 2] = ["few-particles", "flips"];
/// 60 scans without a flip and 20 rounds of 10.
const SCANS: usize = 260;
const ROUNDS: usize = 20;
/// Its filters, the configurations whose worst cases are their limits, and the instructions of the longest scan as stated in
/// `docs/performance.md`.
const FILTERS: [(Rig, &str, &str, u64); 2] =
    [(FEW, "mixture", "4x1-informed-f32", 967_000), (FEW_JOINT, "joint", "1x1-joint-f32", 2_090_000)];

/// The output of a replay.
struct Told {
    rounds: Vec<String>,
    /// Ticks of the longest scan of each round.
    worst: Vec<u64>,
}

impl Told {
    fn parse(text: &str) -> Self {
        let of = |kind: &'static str| text.lines().filter_map(move |line| line.strip_prefix(kind)?.strip_prefix(' '));
        let rounds = of("round").map(str::to_owned).collect();
        Self { rounds, worst: of("worst").filter_map(|ticks| ticks.parse().ok()).collect() }
    }

    /// The sum of a count, and the ticks of the longest scan, over the rounds of a filter.
    fn of(&self, filter: &str, count: &str) -> (u64, u64) {
        let rounds = self.rounds.iter().zip(&self.worst).filter(|(round, _)| output::word(round, "of") == Some(filter));
        rounds.fold((0, 0), |(sum, worst), (round, &ticks)| {
            (sum + output::number(round, count).unwrap_or(0), worst.max(ticks))
        })
    }
}

/// Fails if the board differs from the host.
pub fn check() -> Result<(), String> {
    FILTERS.iter().try_for_each(check_filter)
}

fn check_filter(&(rig, filter, configuration, stated): &(Rig, &str, &str, u64)) -> Result<(), String> {
    let stream = streams::make(Source { what: "survey", scans: SCANS, rig }, Precision::F32)?;
    let host = Told::parse(&streams::flips_on_host(&stream, &FEATURES)?);
    let image = image::build(FIRST, "flips", &FEATURES)?;
    let text = emulator::run(FIRST, &image, &stream)?;
    let replay = Told::parse(&text);
    let (begin, end) = (text.lines().next().unwrap_or_default(), text.lines().last().unwrap_or_default());
    if !end.starts_with("end ") {
        return Err(format!("it ended with {end}"));
    }
    let pairs = host.rounds.iter().zip(&replay.rounds);
    if let Some((left, right)) = pairs.clone().find(|(left, right)| left != right) {
        return Err(format!("the host has {left}, {} {right}", FIRST.name));
    }
    if [host.rounds.len(), replay.rounds.len(), replay.worst.len()] != [ROUNDS; 3] {
        return Err(format!("{} of {ROUNDS} rounds on {}", pairs.count(), FIRST.name));
    }
    let (Some(instructions), Some(ticks)) = (output::number(begin, "instructions"), output::number(begin, "ticks"))
    else {
        return Err(format!("no clock in {begin}"));
    };
    let sum = |count| replay.of(filter, count).0;
    let worst = replay.of(filter, "flips").1 * instructions / ticks.max(1);
    println!(
        "flips on {}: {filter}: of {} bits {} scrubbings mended, {} particles isolated, {} times back to a snapshot; \
         the longest scan took {worst} instructions",
        FIRST.name,
        sum("flips"),
        sum("mended"),
        sum("isolated"),
        sum("refused")
    );
    if let Some(why) = budget::beyond_worst_case(FIRST.name, configuration, worst)? {
        return Err(format!("{filter} on {}{why}", FIRST.name));
    }
    if !is_near(worst, stated) {
        return Err(format!("{filter} on {}: a scan takes {worst} instructions, not {stated}", FIRST.name));
    }
    Ok(())
}

/// Whether a figure is within a fifth of the stated one.
fn is_near(figure: u64, stated: u64) -> bool {
    5 * figure <= 6 * stated && 5 * stated <= 6 * figure
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_a_fifth_off_is_seen() {
        assert!(is_near(100, 120) && is_near(120, 100));
        assert!(!is_near(100, 121) && !is_near(121, 100));
    }

    #[test]
    fn rounds_are_summed_and_the_longest_scan_found() {
        let text = "clock systick instructions 40 ticks 1\nround 0 of mixture flips 8 mended 1 digest 0a\nworst 7\n\
                    round 1 of mixture flips 8 mended 2 digest 0b\nworst 5\nround 0 of joint flips 8 mended 0 digest 0c\nworst 9\nend stack 1";
        let told = Told::parse(text);
        assert_eq!((told.rounds.len(), told.worst.as_slice()), (3, &[7, 5, 9][..]));
        assert_eq!((told.of("mixture", "mended"), told.of("joint", "flips")), ((3, 7), (8, 9)));
    }
}

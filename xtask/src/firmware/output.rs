//! The output of a replay, on a board or on the host.

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Replay {
    pub scans: Vec<Scan>,
    /// Instructions per tick of the clock; 0 without counts.
    pub instructions_per_tick: f64,
    /// RAM of the filter, bytes.
    pub ram: u64,
    /// RAM of its parts, bytes.
    pub ram_parts: Vec<(String, u64)>,
    /// Greatest depth of the stack, bytes.
    pub stack: u64,
    /// Time between scans, s; only on the host.
    pub scan_interval_s: f64,
    /// The capacities that limit the cost of a scan.
    pub capacities: Capacities,
    /// Its last line, if it has finished.
    pub end: Option<String>,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scan {
    /// Counts, health and digest: everything that must be equal on host and board.
    pub state: String,
    /// Digest of the filter's state.
    pub digest: String,
    /// Greatest number of components in view of any candidate.
    pub in_view: u64,
    pub measurements: u64,
    /// Number of predictions before it.
    pub predictions: u64,
    /// Clock ticks of all predictions before it.
    pub predict: u64,
    /// Clock ticks of the longest prediction before it.
    pub predict_worst: u64,
    /// Clock ticks of the update.
    pub update: u64,
    /// Clock ticks of the estimate.
    pub estimate: u64,
    /// Clock ticks of the update's stages, in the order of [`STAGES`].
    pub stages: [u64; STAGES.len()],
}

/// The stages of a scan: predict moving features, weight candidates, resample particles, update maps (without reduction), and
/// reduce them.
pub const STAGES: [&str; 5] = ["predict", "weigh", "resample", "update", "reduce"];

impl Replay {
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut replay = Self::default();
        for line in text.lines() {
            replay.line(line).ok_or_else(|| format!("unexpected output: {line}"))?;
        }
        if replay.end.is_some() { Ok(replay) } else { Err(format!("no end after {} scans", replay.scans.len())) }
    }

    fn line(&mut self, line: &str) -> Option<()> {
        let (kind, rest) = line.split_once(' ')?;
        match kind {
            "clock" => {
                self.instructions_per_tick = number(rest, "instructions")? as f64 / number(rest, "ticks")? as f64;
            }
            "stream" => self.scan_interval_s = word(rest, "scan_interval_s")?.parse().ok()?,
            "capacity" => self.capacities = Capacities::parse(rest)?,
            "ram" => {
                let (name, bytes) = rest.rsplit_once(' ')?;
                let bytes = bytes.parse().ok()?;
                if name == "total" {
                    self.ram = bytes;
                } else {
                    self.ram_parts.push((name.to_owned(), bytes));
                }
            }
            "scan" => self.scans.push(Scan {
                state: rest.to_owned(),
                digest: word(rest, "digest")?.to_owned(),
                in_view: number(rest, "in_view")?,
                measurements: number(rest, "measurements")?,
                predictions: number(rest, "predictions")?,
                ..Scan::default()
            }),
            "cost" => {
                let scan = self.scans.last_mut()?;
                scan.predict = number(rest, "predict")?;
                scan.predict_worst = number(rest, "worst")?;
                scan.update = number(rest, "update")?;
                scan.estimate = number(rest, "estimate")?;
            }
            "stages" => {
                let scan = self.scans.last_mut()?;
                for (ticks, stage) in scan.stages.iter_mut().zip(STAGES) {
                    *ticks = number(rest, stage)?;
                }
            }
            // On the host, a snapshot must agree with the state of the replay.
            "snapshot" if word(rest, "agrees") == Some("true") => {}
            "end" => {
                self.stack = number(rest, "stack").unwrap_or(0);
                self.end = Some(rest.to_owned());
            }
            _ => return None,
        }
        Some(())
    }

    /// Instructions of the longest scan; 0 without counts.
    pub fn worst_scan(&self) -> u64 {
        let ticks = self.scans.iter().map(|scan| scan.update).max().unwrap_or(0);
        (ticks as f64 * self.instructions_per_tick).round() as u64
    }

    /// The first difference between two replays of the same stream.
    pub fn first_difference(&self, other: &Self) -> Option<String> {
        let mut pairs = self.scans.iter().zip(&other.scans);
        if let Some((left, right)) = pairs.find(|(left, right)| left.state != right.state) {
            return Some(format!("{} / {}", left.state, right.state));
        }
        let (left, right) = (self.scans.len(), other.scans.len());
        (left != right).then(|| format!("{left} scans / {right} scans"))
    }
}

/// The capacities that limit the cost of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Capacities {
    candidates: u64,
    particles: u64,
    components: u64,
    components_in_all: u64,
    measurements: u64,
}

impl Capacities {
    fn parse(text: &str) -> Option<Self> {
        Some(Self {
            candidates: number(text, "candidates")?,
            particles: number(text, "particles")?,
            components: number(text, "components")?,
            components_in_all: number(text, "in_all")?,
            measurements: number(text, "measurements")?,
        })
    }

    /// Number of passes over components in view and measurements: one for the weight of every candidate, and one for the update
    /// of every particle.
    pub fn looks(&self) -> u64 {
        self.candidates + self.particles
    }

    /// Greatest number of pairs of a component and a measurement in a scan: every pass has a full map, which all particles may
    /// share, and the maximum number of measurements.
    pub fn most_pairs(&self) -> u64 {
        self.looks() * self.components.min(self.components_in_all) * self.measurements
    }
}

/// The word after `name`.
pub fn word<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    let mut words = text.split(' ');
    words.find(|word| *word == name)?;
    words.next()
}

/// The number after `name`.
pub fn number(text: &str, name: &str) -> Option<u64> {
    word(text, name)?.parse().ok()
}

/// The number of compared scans, if there is no difference.
pub fn all_equal(compared: usize, differences: &[String]) -> Result<usize, String> {
    if differences.is_empty() { Ok(compared) } else { Err(differences.join("; ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_parsed() {
        let replay = Replay::parse(
            "clock systick instructions 2000000 ticks 50000\nram total 100\nram in and out 7\n\
             scan 0 measurements 5 predictions 2 in_view 9 health 0000 digest 0a\ncost 0 predict 9 worst 6 update 77 estimate 3\n\
             stages 0 predict 1 weigh 40 resample 2 update 20 reduce 10\n\
             end scans 1 features 3 stack 2000",
        )
        .unwrap();
        assert_eq!((replay.instructions_per_tick, replay.ram, replay.stack), (40.0, 100, 2000));
        assert_eq!(replay.ram_parts, [("in and out".to_owned(), 7)]);
        let scan = &replay.scans[0];
        assert_eq!((scan.digest.as_str(), scan.predictions, scan.predict_worst, scan.update), ("0a", 2, 6, 77));
        assert_eq!((scan.stages, replay.worst_scan()), ([1, 40, 2, 20, 10], 77 * 40));
    }

    #[test]
    fn incomplete_or_unexpected_output_is_an_error() {
        assert!(Replay::parse("scan 0 measurements 5 predictions 2 in_view 9 digest 0a").is_err());
        assert!(Replay::parse("Error damaged\nend scans 0").is_err());
    }

    #[test]
    fn the_first_difference_is_found() {
        let one = Replay::parse("scan 0 measurements 5 predictions 2 in_view 9 digest 0a\nend scans 1").unwrap();
        let other = Replay::parse("scan 0 measurements 5 predictions 2 in_view 9 digest 0b\nend scans 1").unwrap();
        let longer = Replay::parse("scan 0 measurements 5 predictions 2 in_view 9 digest 0a\nscan 1 measurements 5 predictions 2 in_view 9 digest 0a\nend scans 2").unwrap();
        assert_eq!(one.first_difference(&one), None);
        assert!(one.first_difference(&other).unwrap().contains("0b"));
        assert_eq!(one.first_difference(&longer).unwrap(), "1 scans / 2 scans");
    }
}

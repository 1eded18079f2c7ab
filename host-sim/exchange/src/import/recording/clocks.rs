//! Detection of times that go back in a recording.
//!
//! A few messages may be out of order: they are sorted. After a clock was set back, or a recording was repeated, times continue
//! from an earlier one: the recording is divided into pieces, and a log has one of them.

use crate::calendar;

/// Greatest number of consecutive late messages,
const LATE: usize = 2;
/// and greatest delay of a late message, ns; a longer one begins a new piece.
const LATE_NS: u64 = 1_000_000_000;
/// A step forward by more than this, ns, means that the clock was set: no recorder waits for a day.
const AHEAD_NS: u64 = 86_400_000_000_000;
/// Greatest number of topics that a text lists.
const NAMED: usize = 4;

/// Times of messages by topic, in the order of the recording.
#[derive(Debug, Default)]
pub(super) struct Clocks {
    topics: Vec<Topic>,
    count: usize,
}

#[derive(Debug)]
struct Topic {
    name: String,
    messages: Vec<Noted>,
}

/// A message: its index among all, its time and the time of recording, ns.
#[derive(Debug, Clone, Copy)]
struct Noted {
    place: usize,
    ns: u64,
    recorded_ns: u64,
}

/// The assignment of messages to pieces, and messages to the user.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Pieces {
    /// By topic and message; `None` for a message that is left out.
    of: Vec<(String, Vec<Option<usize>>)>,
    /// Index of the first message of each piece but the first.
    begins: Vec<usize>,
    lasts_s: Vec<f64>,
    /// A sentence for every step of a clock.
    steps: Vec<String>,
    /// A sentence for every correction.
    pub(super) told: Vec<String>,
    /// Whether the times of recording do not decrease.
    recorder_is_sound: bool,
}

impl Clocks {
    /// Adds a message. Returns its index among all.
    pub(super) fn note(&mut self, topic: &str, ns: u64, recorded_ns: u64) -> usize {
        let noted = Noted { place: self.count, ns, recorded_ns };
        self.count += 1;
        match self.topics.iter_mut().find(|known| known.name == topic) {
            Some(known) => known.messages.push(noted),
            None => self.topics.push(Topic { name: topic.to_owned(), messages: vec![noted] }),
        }
        noted.place
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    pub(super) fn pieces(&self) -> Pieces {
        let mut told = Vec::new();
        let cuts: Vec<Cuts> = self.topics.iter().map(|topic| topic.cuts(&mut told)).collect();
        let Some((leader, most)) = cuts
            .iter()
            .enumerate()
            .map(|(k, cuts)| (k, cuts.at.len()))
            .max_by_key(|(k, count)| (*count, usize::MAX - k))
        else {
            return Pieces::default();
        };
        let begins: Vec<usize> = cuts[leader].at.iter().map(|at| self.topics[leader].messages[*at].place).collect();
        let mut of = Vec::new();
        let mut spans = vec![(u64::MAX, 0_u64); most + 1];
        for (topic, cuts) in self.topics.iter().zip(&cuts) {
            // In a topic too slow for all steps, the cuts of the topic with most steps apply.
            let piece = |k: usize, place: usize| match cuts.at.len() == most {
                true => cuts.at.partition_point(|at| *at <= k),
                false => begins.partition_point(|begin| *begin <= place),
            };
            let mut pieces = Vec::new();
            for (k, message) in topic.messages.iter().enumerate() {
                let piece = piece(k, message.place);
                let kept = !cuts.alone.contains(&k);
                if kept {
                    spans[piece] = (spans[piece].0.min(message.ns), spans[piece].1.max(message.ns));
                }
                pieces.push(kept.then_some(piece));
            }
            of.push((topic.name.clone(), pieces));
        }
        let lasts_s = spans.iter().map(|(from, to)| to.saturating_sub(*from) as f64 / 1e9).collect();
        let steps = self.topics.iter().zip(&cuts).flat_map(|(topic, cuts)| topic.steps(cuts)).collect();
        let ordered = |topic: &Topic| topic.messages.windows(2).all(|pair| pair[0].recorded_ns <= pair[1].recorded_ns);
        Pieces { of, begins, lasts_s, steps, told, recorder_is_sound: self.topics.iter().all(ordered) }
    }
}

/// Indices of messages at which a topic starts a new piece, and of messages with a wrong time.
#[derive(Debug, Default)]
struct Cuts {
    at: Vec<usize>,
    alone: Vec<usize>,
}

impl Topic {
    fn cuts(&self, told: &mut Vec<String>) -> Cuts {
        let (mut cuts, mut late, mut most_ns, mut first) = (Cuts::default(), 0, 0, None);
        let ns = |k: usize| self.messages.get(k).map(|message| message.ns);
        // The latest time of this piece so far, and that of the message before it, ns.
        let (mut latest, mut before) = (0_u64, 0_u64);
        let mut k = 0;
        while let Some(now) = ns(k) {
            let begins = k == cuts.at.last().copied().unwrap_or(0);
            let back_ns = latest.saturating_sub(now);
            if !begins && now > latest && now - latest > AHEAD_NS {
                if ns(k + 1).is_some_and(|next| next < now - AHEAD_NS) {
                    cuts.alone.push(k);
                } else {
                    cuts.at.push(k);
                    continue;
                }
            } else if begins || back_ns == 0 {
                before = if begins { now } else { latest };
                latest = now;
            } else if back_ns >= LATE_NS && now >= before && k > 0 && ns(k - 1) == Some(latest) {
                // Only the message before had a wrong time, too late.
                cuts.alone.push(k - 1);
                latest = now;
            } else {
                let run = (k..).take_while(|k| ns(*k).is_some_and(|ns| ns < latest)).take(LATE + 1).count();
                if run > LATE || back_ns >= LATE_NS {
                    cuts.at.push(k);
                    continue;
                }
                late += 1;
                most_ns = most_ns.max(back_ns);
                first.get_or_insert(k);
            }
            k += 1;
        }
        let topic = &self.name;
        if let Some(first) = first {
            told.push(format!(
                "{topic}: {late} messages come later than their successors, by up to {:.3} s, the first is message {}: they are put in order of time",
                most_ns as f64 / 1e9,
                first + 1
            ));
        }
        if let Some(first) = cuts.alone.first() {
            let seconds = |k: usize| ns(k).map_or(0.0, |ns| ns as f64 / 1e9);
            told.push(format!(
                "{topic}: {} messages have a time far from those beside them, the first is message {} ({}, beside {}): they are left out",
                cuts.alone.len(),
                first + 1,
                calendar::shown(seconds(*first)),
                calendar::shown(seconds(first + 1))
            ));
        }
        cuts
    }

    fn steps(&self, cuts: &Cuts) -> Vec<String> {
        let step = |at: &usize| {
            let mut earlier = self.messages[..*at].iter().enumerate().rev();
            let latest = earlier.find(|(k, _)| !cuts.alone.contains(k));
            let (from, to) = (latest.map_or(0, |(_, message)| message.ns), self.messages[*at].ns);
            let way = if to < from { "back" } else { "ahead" };
            let seconds = |ns: u64| ns as f64 / 1e9;
            format!(
                "{} by {:.3} s {way} at message {} (from {} to {})",
                self.name,
                seconds(from.abs_diff(to)),
                at + 1,
                calendar::shown(seconds(from)),
                calendar::shown(seconds(to))
            )
        };
        cuts.at.iter().map(step).collect()
    }
}

impl Pieces {
    /// The requested piece, if there are several.
    pub(super) fn chosen(&self, part: Option<usize>, header: bool) -> Result<usize, String> {
        let count = self.lasts_s.len().max(1);
        let seconds: Vec<String> = self.lasts_s.iter().map(|lasts_s| format!("{lasts_s:.1} s")).collect();
        match part {
            None if count == 1 => Ok(0),
            Some(part) if (1..=count).contains(&part) => Ok(part - 1),
            Some(part) => Err(format!("no part {part}: stamps divide the recording into {count} parts")),
            None => {
                let more = self.steps.len().saturating_sub(NAMED);
                let more = if more > 0 { format!(", and {more} more") } else { String::new() };
                let steps = self.steps.iter().take(NAMED).cloned().collect::<Vec<_>>().join(", ");
                let clock = if header && self.recorder_is_sound {
                    "; or --clock log takes the times of the recording, which do not go back"
                } else {
                    ""
                };
                Err(format!(
                    "stamps jump: {steps}{more}; rows of both times do not belong together: --part N takes one of the {count} parts, which last {}{clock}",
                    seconds.join(", ")
                ))
            }
        }
    }

    /// Whether a message, by its index in the topic, belongs to a piece.
    pub(super) fn has(&self, piece: usize, topic: &str, message: usize) -> bool {
        let of = self.of.iter().find(|(name, _)| name == topic);
        of.and_then(|(_, pieces)| pieces.get(message)).is_some_and(|of| *of == Some(piece))
    }

    /// The same by the index among all messages.
    pub(super) fn has_place(&self, piece: usize, place: usize) -> bool {
        self.begins.partition_point(|begin| *begin <= place) == piece
    }

    pub(super) fn count(&self) -> usize {
        self.lasts_s.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(topics: &[(&str, &[f64])]) -> Pieces {
        let mut clocks = Clocks::default();
        let most = topics.iter().map(|(_, times)| times.len()).max().unwrap();
        for k in 0..most {
            for (topic, times) in topics {
                if let Some(t_s) = times.get(k) {
                    clocks.note(topic, (t_s * 1e9) as u64, k as u64);
                }
            }
        }
        clocks.pieces()
    }

    #[test]
    fn a_clock_set_back_divides_the_recording() {
        let fast: Vec<f64> = (0..40).map(|k| 100.0 + 0.1 * f64::from(k) - if k < 20 { 0.0 } else { 3.0 }).collect();
        let slow: Vec<f64> = (0..40).map(|k| 100.0 + 10.0 * f64::from(k)).collect();
        let found = pieces(&[("/odom", &fast), ("/fix", &slow)]);
        assert_eq!(found.count(), 2);
        let error = found.chosen(None, true).unwrap_err();
        for words in ["/odom by 2.900 s back at message 21 (from 101.900 s to 99.000 s)", "--part N", "--clock log"] {
            assert!(error.contains(words), "{words}: {error}");
        }
        assert_eq!((found.chosen(Some(2), true), found.chosen(Some(1), true)), (Ok(1), Ok(0)));
        assert!(found.chosen(Some(3), true).unwrap_err().contains("into 2 parts"));
        let kept = |piece| (0..40).filter(|k| found.has(piece, "/odom", *k)).collect::<Vec<_>>();
        assert_eq!((kept(0), kept(1)), ((0..20).collect(), (20..40).collect()));
        // The slow topic has no step, and is cut at the same place of the recording.
        assert!(found.has(0, "/fix", 19) && found.has(1, "/fix", 20) && !found.has(1, "/fix", 19));
        assert!(found.told.is_empty());
    }

    #[test]
    fn late_messages_are_sorted_and_reported_and_a_wrong_stamp_is_left_out() {
        let times = [1.0, 1.2, 1.1, 1.3, 10.3, 1.4, 1.5];
        let found = pieces(&[("/odom", &times)]);
        assert_eq!((found.count(), found.chosen(None, true)), (1, Ok(0)));
        assert!(!found.has(0, "/odom", 4) && found.has(0, "/odom", 2) && found.has(0, "/odom", 6));
        assert!(
            found.told[0]
                .contains("1 messages come later than their successors, by up to 0.100 s, the first is message 3")
        );
        assert!(found.told[1].contains("the first is message 5 (10.300 s, beside 1.400 s)"), "{:?}", found.told);
    }

    #[test]
    fn a_clock_set_forward_to_calendar_time_divides_the_recording() {
        let times: Vec<f64> = (0..10).map(|k| f64::from(k) + if k < 4 { 5.0 } else { 1.7e9 }).collect();
        let found = pieces(&[("/odom", &times)]);
        let error = found.chosen(None, true).unwrap_err();
        assert!(error.contains("ahead at message 5 (from 8.000 s to 2023-11-14 22:13:24 UTC)"), "{error}");
        let same = pieces(&[("/odom", &[1.0, 1.0, 2.0])]);
        assert_eq!((same.count(), same.told.len()), (1, 0));
    }
}

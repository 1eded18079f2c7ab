//! Simulated faults of a line, the same in every run.

use scphd_log::noise::Noise;
use std::collections::VecDeque;

/// Number of frames that pass before a late one.
const LATE_BY: usize = 3;

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rates {
    /// Share of lost frames.
    pub lose: f64,
    /// Share of bytes with a flipped bit.
    pub flip: f64,
    /// Share of duplicated frames.
    pub double: f64,
    /// Share of frames that arrive after later ones.
    pub late: f64,
}

/// A line with faults.
#[derive(Debug, Clone)]
pub struct Trouble {
    rates: Rates,
    noise: Noise,
    /// Late frames, each with the number of frames that still pass before it.
    held: VecDeque<(usize, Vec<u8>)>,
}

impl Trouble {
    /// A line with these rates.
    pub fn new(rates: Rates, seed: u64) -> Self {
        Self { rates, noise: Noise::new(seed), held: VecDeque::new() }
    }

    /// Passes on a frame with faults.
    pub fn pass(&mut self, frame: &[u8], mut on: impl FnMut(&[u8])) {
        let Rates { lose, flip, double, late } = self.rates;
        let mut bytes = frame.to_vec();
        for byte in &mut bytes {
            if self.noise.happens(flip) {
                *byte ^= 1 << (self.noise.uniform() * 8.0) as u8;
            }
        }
        let is_lost = self.noise.happens(lose);
        let times = if self.noise.happens(double) { 2 } else { 1 };
        let is_late = self.noise.happens(late);
        if is_late && !is_lost {
            self.held.push_back((LATE_BY, bytes));
        } else if !is_lost {
            (0..times).for_each(|_| on(&bytes));
        }
        self.held.iter_mut().for_each(|(left, _)| *left = left.saturating_sub(1));
        while self.held.front().is_some_and(|(left, _)| *left == 0) {
            self.held.pop_front().into_iter().for_each(|(_, bytes)| on(&bytes));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passed(rates: Rates, frames: usize) -> Vec<Vec<u8>> {
        let (mut trouble, mut arrived) = (Trouble::new(rates, 3), Vec::new());
        for k in 0..frames {
            trouble.pass(&[k as u8; 20], |bytes| arrived.push(bytes.to_vec()));
        }
        arrived
    }

    #[test]
    fn a_good_line_changes_nothing() {
        assert_eq!(passed(Rates::default(), 100), (0..100).map(|k| vec![k; 20]).collect::<Vec<_>>());
    }

    #[test]
    fn rates_are_as_requested() {
        let near = |count: usize, expected: f64| (count as f64 - expected).abs() < 4.0 * expected.sqrt();
        let n = 20_000;
        assert!(near(n - passed(Rates { lose: 0.05, ..Rates::default() }, n).len(), 1000.0));
        assert!(near(passed(Rates { double: 0.05, ..Rates::default() }, n).len() - n, 1000.0));
        let flipped = passed(Rates { flip: 0.01, ..Rates::default() }, n);
        let hit = flipped.iter().enumerate().flat_map(|(k, bytes)| bytes.iter().filter(move |&&byte| byte != k as u8));
        assert!(near(hit.count(), 4000.0));
        let late = passed(Rates { late: 0.05, ..Rates::default() }, n);
        let behind = late.windows(2).filter(|pair| pair[1][0].wrapping_sub(pair[0][0]) > 128);
        assert!(late.len() >= n - LATE_BY && near(behind.count(), 950.0));
    }
}

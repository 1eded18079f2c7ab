//! `Predict` of appendix A.

use super::draws::Draws;
use super::motion::Motion;
use super::state::{Candidate, Particle, State};

/// Moves every candidate by its own sample of the transition (5.12). The first prediction after a scan
/// makes the candidates. Static features keep as they are (5.14 with F = I, Q = 0, p_S = 1), and moving ones
/// only wait until the scan, so no map is touched; no time, no change and no draw.
pub(super) fn predict(
    state: &mut State,
    samples: usize,
    motion: &Motion,
    control: &[f64; 2],
    dt: f64,
    draws: &mut dyn Draws,
) {
    if dt == 0.0 {
        return;
    }
    let candidates = state.candidates.get_or_insert_with(|| children(&state.particles, samples));
    for candidate in candidates {
        candidate.pose = motion.sample(candidate.pose, control, dt, draws);
    }
    state.waited_s += dt;
}

/// M copies of every particle, sharing its weight (5.13).
fn children(particles: &[Particle], samples: usize) -> Vec<Candidate> {
    particles
        .iter()
        .flat_map(|particle| {
            let child = Candidate { pose: particle.pose, ln_weight: particle.ln_weight - (samples as f64).ln() };
            std::iter::repeat_n(child, samples)
        })
        .collect()
}

//! `Predict` of appendix A.

use super::state::{Candidate, Particle, State};

/// Moves every candidate to its sample of the transition, `moved` (5.12). The first prediction after a scan makes the candidates.
/// Static features are not changed (5.14 with F = I, Q = 0, p_S = 1), and moving ones are predicted at the scan, so that no map
/// is changed. For zero time nothing changes and no number is drawn.
pub(super) fn predict<P: Copy, const N: usize, const V: usize>(
    state: &mut State<P, N, V>,
    samples: usize,
    dt: f64,
    mut moved: impl FnMut(&P) -> P,
) {
    if dt == 0.0 {
        return;
    }
    let candidates = state.candidates.get_or_insert_with(|| children(&state.particles, samples));
    for candidate in candidates {
        candidate.pose = moved(&candidate.pose);
    }
    state.waited_s += dt;
}

/// M copies of every particle, each with its share of the weight (5.13).
fn children<P: Copy, const N: usize, const V: usize>(
    particles: &[Particle<P, N, V>],
    samples: usize,
) -> Vec<Candidate<P>> {
    particles
        .iter()
        .flat_map(|particle| {
            let child = Candidate { pose: particle.pose, ln_weight: particle.ln_weight - (samples as f64).ln() };
            std::iter::repeat_n(child, samples)
        })
        .collect()
}

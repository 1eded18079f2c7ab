//! Selection of the candidates that become particles (5.2.2).

use crate::particles::candidate::Candidate;
use crate::particles::resample::{one_child, systematic};
use crate::{Config, Noise, Pose, Real};

/// The input of the selection.
#[derive(Debug)]
pub(crate) struct Weighed<'a, P: Pose> {
    pub(crate) candidates: &'a [Candidate<P>],
    pub(crate) particles: usize,
    /// Candidates of each particle.
    pub(crate) children: usize,
    /// Effective number of the candidates.
    pub(crate) n_eff: P::Scalar,
}

/// The result of the selection.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Selection {
    /// Whether the particles were resampled.
    pub(crate) resampled: bool,
    /// The particle that continues the heaviest of the surviving candidates.
    pub(crate) heaviest: usize,
}

impl Selection {
    /// The placeholder before the selection.
    pub(crate) const NONE: Self = Self { resampled: false, heaviest: 0 };
}

/// Selects the candidate that each particle continues: by systematic resampling if `N_eff` is below the threshold, otherwise one
/// of its own children.
///
/// Writes the indices of the selected candidates, in ascending order of their parents, to `survivors`, and the candidates to
/// `selected`.
pub(crate) fn select<T: Real, P: Pose<Scalar = T>>(
    weighed: &Weighed<'_, P>,
    config: &Config<T>,
    noise: &mut Noise,
    survivors: &mut [u16],
    selected: &mut [Candidate<P>],
) -> Selection {
    let &Weighed { candidates, particles, children, n_eff } = weighed;
    let resampled = n_eff < config.resample_threshold * T::from_usize(candidates.len());
    let chosen = |index: u16| candidates.get(usize::from(index)).copied();
    if resampled {
        let chances = candidates.iter().map(|candidate| candidate.ln_weight.exp());
        systematic(chances, noise.uniform(), survivors.get_mut(..particles).unwrap_or(&mut []));
        let ln_weight = -T::from_usize(particles).ln();
        for (slot, &survivor) in selected.iter_mut().zip(survivors.iter().take(particles)) {
            if let Some(candidate) = chosen(survivor) {
                *slot = Candidate { ln_weight, ..candidate };
            }
        }
    } else {
        let families = candidates.chunks(children.max(1)).enumerate();
        for ((family, members), (slot, survivor)) in families.zip(selected.iter_mut().zip(survivors.iter_mut())) {
            // A single child needs no random number.
            let (child, ln_weight) = match members {
                [only] => (0, only.ln_weight),
                _ => one_child(members, noise.uniform()),
            };
            *survivor = (family * children + child) as u16;
            if let Some(candidate) = chosen(*survivor) {
                *slot = Candidate { ln_weight, ..candidate };
            }
        }
    }
    let mut heaviest = (0, T::NEG_INFINITY);
    for (particle, &survivor) in survivors.iter().take(particles).enumerate() {
        if let Some(candidate) = chosen(survivor)
            && candidate.ln_weight > heaviest.1
        {
            heaviest = (particle, candidate.ln_weight);
        }
    }
    Selection { resampled, heaviest: heaviest.0 }
}

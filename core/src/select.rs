//! From the weighed candidates to the particles that go on (5.2.2).

use crate::candidate::Candidate;
use crate::resample::{one_child, systematic};
use crate::{Noise, Real};

/// What the selection did.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Selection {
    /// Whether all particles were drawn anew.
    pub(crate) resampled: bool,
    /// The particle that continues the heaviest of the surviving candidates.
    pub(crate) heaviest: usize,
}

/// Chooses for every particle the candidate that it continues: by systematic resampling where
/// `N_eff` < `threshold` · candidates, otherwise one of its own children.
///
/// Writes the chosen candidates' indices, in ascending order of parents, to `survivors`, and the particles to `selected`.
pub(crate) fn select<T: Real, P: Copy>(
    candidates: &[Candidate<T, P>],
    children: usize,
    threshold: T,
    n_eff: T,
    noise: &mut Noise,
    survivors: &mut [u16],
    selected: &mut [Candidate<T, P>],
) -> Selection {
    let resampled = n_eff < threshold * T::from_usize(candidates.len());
    let chosen = |index: u16| candidates.get(usize::from(index)).copied();
    if resampled {
        let particles = T::from_usize(survivors.len());
        systematic(candidates.iter().map(|candidate| candidate.ln_weight.exp()), noise.uniform(), survivors);
        for (slot, &survivor) in selected.iter_mut().zip(survivors.iter()) {
            if let Some(candidate) = chosen(survivor) {
                *slot = Candidate { ln_weight: -particles.ln(), ..candidate };
            }
        }
    } else {
        let families = candidates.chunks(children.max(1)).enumerate();
        for ((family, members), (slot, survivor)) in families.zip(selected.iter_mut().zip(survivors.iter_mut())) {
            // An only child needs no draw.
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
    for (particle, &survivor) in survivors.iter().enumerate() {
        if let Some(candidate) = chosen(survivor)
            && candidate.ln_weight > heaviest.1
        {
            heaviest = (particle, candidate.ln_weight);
        }
    }
    Selection { resampled, heaviest: heaviest.0 }
}

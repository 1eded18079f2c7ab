//! The expected map over all particles (see 5.2.7).

use crate::map::Maps;
use crate::map::reduce::{merge_and_cap, moment_match};
use crate::map::workspace::Origin;
use crate::{Config, Feature, Real, Vector};

impl<T: Real, F: Feature<Position: Vector<Scalar = T>>> Maps<'_, F> {
    /// Fills the workspace with Σ_i ζ_i v_i, the mixture of all particles' maps by their weights, reduced.
    ///
    /// The cost is low because maps share pages: a shared component is visited once for all its particles, and labels identify
    /// the components of different maps that represent the same feature.
    pub(crate) fn expect(&mut self, particles: usize, weight: impl Fn(usize) -> T, config: &Config<T>) {
        let Self { table, pool, workspace, .. } = self;
        // Components that would be pruned in every particle are pruned here too.
        workspace.clear((config.prune_weight / T::from_usize(particles)).ln());
        for particle in 0..particles {
            for &id in table.pages(particle) {
                let holds = |other: &usize| table.pages(*other).contains(&id);
                let shared = pool.references(id) > 1;
                if shared && (0..particle).any(|earlier| holds(&earlier)) {
                    continue;
                }
                let later = (particle + 1..particles).filter(|other| shared && holds(other));
                let share = later.fold(weight(particle), |sum, other| sum + weight(other)).ln();
                let Some(page) = pool.get(id) else { continue };
                for component in page.components() {
                    let weighted = crate::Component { ln_weight: component.ln_weight + share, ..*component };
                    let held =
                        workspace.in_view_mut().iter_mut().find(|entry| entry.component.label == component.label);
                    match held {
                        Some(entry) if entry.component.ln_weight >= weighted.ln_weight => {
                            entry.component = moment_match(&entry.component, core::iter::once(&weighted));
                        }
                        Some(entry) => {
                            let other = entry.component;
                            entry.component = moment_match(&weighted, core::iter::once(&other));
                        }
                        None => workspace.push(&weighted, Origin::Missed),
                    }
                }
            }
        }
        merge_and_cap(workspace, config.merge_distance, usize::MAX);
    }
}

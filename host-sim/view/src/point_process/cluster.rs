//! Cluster processes (3.27): parents, and daughters that depend on their parent.

use super::cardinality::Poisson;
use super::region::Rectangle;
use super::{Point, ProcessError};

/// A parent with its daughters; only the daughters are observed.
#[derive(Debug, Clone, PartialEq)]
pub struct Cluster<P> {
    /// The realisation of the parent process.
    pub parent: P,
    /// The points of the daughter process given this parent.
    pub daughters: Vec<Point>,
}

/// A realisation of the cluster process G(h) = G_p(G_d(h|·)) (3.27), from the parents and the process of daughters
/// given a parent.
pub fn clusters<P>(parents: Vec<P>, mut daughters: impl FnMut(&P) -> Vec<Point>) -> Vec<Cluster<P>> {
    parents
        .into_iter()
        .map(|parent| {
            let daughters = daughters(&parent);
            Cluster { parent, daughters }
        })
        .collect()
}

/// What is observed of a realisation: all daughters, in the order of their parents.
pub fn points<P>(clusters: &[Cluster<P>]) -> impl Iterator<Item = Point> {
    clusters.iter().flat_map(|cluster| cluster.daughters.iter().copied())
}

/// What happens where clusters reach over the border of the region.
///
/// κ is the mean number of parents in the region over its area and μ the mean number of daughters of a parent. Deeper
/// inside than a cluster reaches, the intensity is κμ in all three cases. What is said of the border holds where clusters
/// do not reach from one side of the region to the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Border {
    /// As the thesis simulates: parents lie in the region, all their daughters are kept.
    ///
    /// The intensity falls from κμ inside to κμ/2 on a side and κμ/4 at a corner, and reaches zero as far outside as a
    /// cluster reaches.
    #[default]
    Kept,
    /// Parents lie in the region, daughters outside it are dropped: the same intensity inside, zero outside.
    Clipped,
    /// Parents of the same κ also lie outside the region as far as a cluster reaches, daughters outside it are dropped:
    /// the intensity is κμ up to the border, as in the part of an endless process that is seen in the region.
    ///
    /// Parents outside the region, and those without a daughter in it, are in the realisation all the same.
    Stationary,
}

impl Border {
    /// Where parents lie, and the law of their number, for `parents` in `region` and clusters that reach `reach` m.
    pub(super) fn parents(
        self,
        region: Rectangle,
        parents: Poisson,
        reach: f64,
    ) -> Result<(Poisson, Rectangle), ProcessError> {
        if self != Self::Stationary {
            return Ok((parents, region));
        }
        let grown = region.grown(reach)?;
        Ok((Poisson::new(parents.mean() * grown.area() / region.area())?, grown))
    }

    /// Drops what this border drops of the daughters.
    pub(super) fn cut(self, region: Rectangle, mut daughters: Vec<Point>) -> Vec<Point> {
        if self != Self::Kept {
            daughters.retain(|&point| region.contains(point));
        }
        daughters
    }
}

/// `size` (m), if it is that of a cluster: finite and not negative.
pub(super) fn checked_size(size: f64) -> Result<f64, ProcessError> {
    if (0.0..f64::INFINITY).contains(&size) { Ok(size) } else { Err(ProcessError::Size(size)) }
}

#[cfg(test)]
mod tests {
    use super::super::cardinality::{Binomial, Fixed};
    use super::super::iid::IidProcess;
    use super::super::spatial::Disc;
    use super::super::statistics::assert_moments;
    use super::*;
    use scphd_log::noise::Noise;

    #[test]
    fn any_two_processes_make_a_cluster_process() {
        // Binomial parents of mean m and variance v with exactly d daughters: mean md, variance vd².
        let spatial = Rectangle::new([0.0, 1.0], [0.0, 1.0]).unwrap();
        let parents = IidProcess { cardinality: Binomial::new(20, 0.3).unwrap(), spatial };
        let mut noise = Noise::new(1);
        let totals: Vec<f64> = (0..20_000)
            .map(|_| {
                let drawn = parents.simulate(&mut noise);
                let clusters = clusters(drawn, |&centre| {
                    IidProcess { cardinality: Fixed(3), spatial: Disc { centre, radius: 0.1 } }.simulate(&mut noise)
                });
                assert!(clusters.iter().all(|cluster| cluster.daughters.len() == 3));
                points(&clusters).count() as f64
            })
            .collect();
        assert_moments(&totals, 18.0, 4.2 * 9.0);
    }
}

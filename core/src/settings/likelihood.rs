//! Which likelihood weighs a particle (5.3.2).

/// How the scan weighs a particle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Likelihood {
    /// The single-cluster likelihood (4.52): ln L = −Σ p_D w + Σ_z ln η_z.
    #[default]
    SingleCluster,
    /// That of RB-PHD SLAM with the empty map: ln L = Σ_z ln κ + N̂ − N̂⁻. The baseline of section 5.3.2; needs clutter.
    EmptyMap,
    /// That of RB-PHD SLAM with a single feature, the heaviest static one in view. Needs clutter.
    SingleFeature,
    /// That of RB-PHD SLAM with several features at once: up to 16 static ones in view that weigh ¾ or more, heaviest first
    /// (Leung, Inostroza, Adams 2016). Needs clutter.
    #[cfg(feature = "multi-feature")]
    MultiFeature,
}

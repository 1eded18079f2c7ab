//! Prediction of the moving features (5.14).

use crate::map::Pool;
use crate::{Config, Dim, Packed, Real};

/// Moves every stored component on by `dt` seconds, all the steps since the last scan in one: they do not hang on the
/// vehicle, so that maps which share a page share the step too. Drops what has become too light or too uncertain.
pub(crate) fn drift<T: Real, const E: usize, const D: usize>(pool: &mut Pool<'_, T, E, D>, config: &Config<T>, dt: T)
where
    Dim<E>: Packed,
{
    if !(dt > T::ZERO) {
        return;
    }
    let moving = &config.moving;
    let ln_least = config.prune_weight.ln();
    let greatest_variance = moving.spread_max_m * moving.spread_max_m;
    for page in pool.held_mut() {
        page.change(|component| {
            let later = moving.motion.advance::<D, E>(component, dt)?;
            let certain = (0..D).all(|axis| later.covariance.get(axis, axis) <= greatest_variance);
            (certain && later.ln_weight >= ln_least).then_some(later)
        });
    }
}

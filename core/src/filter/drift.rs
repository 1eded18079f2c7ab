//! Prediction of the moving features (5.14).

use crate::map::Pool;
use crate::{Config, Dynamic, Place, Real};

/// Moves every stored component on by `dt` seconds, all the steps since the last scan in one: they do not hang on the
/// vehicle, so that maps which share a page share the step too. Drops what has become too light or too uncertain.
pub(crate) fn drift<T: Real, D: Place<Scalar = T>>(pool: &mut Pool<'_, Dynamic<D>>, config: &Config<T>, dt: T) {
    if !(dt > T::ZERO) {
        return;
    }
    let moving = &config.moving;
    let ln_least = config.prune_weight.ln();
    let greatest_variance = moving.spread_max_m * moving.spread_max_m;
    for page in pool.held_mut() {
        page.change(|component| {
            let later = moving.motion.advance::<D>(component, dt)?;
            let certain = (0..D::DIMENSION).all(|axis| later.covariance.get(axis, axis) <= greatest_variance);
            (certain && later.ln_weight >= ln_least).then_some(later)
        });
    }
}

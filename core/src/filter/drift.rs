//! Prediction of the moving features (5.14).

use crate::map::{Page, Pool};
use crate::{Component, Config, Dynamic, Executor, Place, Real};

/// Moves every stored component on by `dt` seconds, all the steps since the last scan in one: they do not hang on the
/// vehicle, so that maps which share a page share the step too. Drops what has become too light or too uncertain.
pub(crate) fn drift<T: Real, D: Place<Scalar = T>>(pool: &mut Pool<'_, Dynamic<D>>, config: &Config<T>, dt: T) {
    if dt > T::ZERO {
        pool.held_mut().for_each(step(config, dt));
    }
}

/// The same in one job for each of the workers.
pub(crate) fn drift_on<T: Real, D: Place<Scalar = T>>(
    pool: &mut Pool<'_, Dynamic<D>>,
    config: &Config<T>,
    dt: T,
    (executor, workers): (&impl Executor, usize),
) {
    if dt > T::ZERO && pool.capacity() > 0 {
        executor.run(pool.held_in_parts(workers), |pages| pages.for_each(step(config, dt)));
    }
}

/// What moves the components of one page.
pub(crate) fn step<T: Real, D: Place<Scalar = T>>(config: &Config<T>, dt: T) -> impl Fn(&mut Page<Dynamic<D>>) {
    let ln_least = config.prune_weight.ln();
    move |page| page.change(|component| later::<T, D>(config, ln_least, dt, component))
}

/// What becomes of a component in `dt` seconds; nothing where it is lighter than `ln_least` or too uncertain then.
#[inline]
pub(crate) fn later<T: Real, D: Place<Scalar = T>>(
    config: &Config<T>,
    ln_least: T,
    dt: T,
    component: &Component<D::Moving>,
) -> Option<Component<D::Moving>> {
    let moving = &config.moving;
    let greatest_variance = moving.spread_max_m * moving.spread_max_m;
    let later = moving.motion.advance::<D>(component, dt)?;
    let certain = (0..D::DIMENSION).all(|axis| later.covariance.get(axis, axis) <= greatest_variance);
    (certain && later.ln_weight >= ln_least).then_some(later)
}

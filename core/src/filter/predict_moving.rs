//! Prediction of the moving features (5.14).

use crate::map::{Page, Pool};
use crate::{Component, Config, Dynamic, Executor, Place, Real};

/// Predicts every stored component over `dt` seconds, the time since the last scan, in one step. The prediction does not depend on the
/// vehicle, so that it is done once for maps that share a page. Drops components that are then too light or too uncertain.
pub(crate) fn predict_moving<T: Real, D: Place<Scalar = T>>(
    pool: &mut Pool<'_, Dynamic<D>>,
    config: &Config<T>,
    dt: T,
) {
    if dt > T::ZERO {
        pool.held_mut().for_each(predict_page(config, dt));
    }
}

/// [`predict_moving`] in one job for each worker.
pub(crate) fn predict_moving_on<T: Real, D: Place<Scalar = T>>(
    pool: &mut Pool<'_, Dynamic<D>>,
    config: &Config<T>,
    dt: T,
    (executor, workers): (&impl Executor, usize),
) {
    if dt > T::ZERO && pool.capacity() > 0 {
        executor.run(pool.held_in_parts(workers), |pages| pages.for_each(predict_page(config, dt)));
    }
}

/// The function that predicts the components of one page.
pub(crate) fn predict_page<T: Real, D: Place<Scalar = T>>(config: &Config<T>, dt: T) -> impl Fn(&mut Page<Dynamic<D>>) {
    let ln_least = config.prune_weight.ln();
    move |page| page.change(|component| predict_component::<T, D>(config, ln_least, dt, component))
}

/// A component after `dt` seconds; `None` if its weight is then below `ln_least`, or if it is too uncertain.
#[inline]
pub(crate) fn predict_component<T: Real, D: Place<Scalar = T>>(
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

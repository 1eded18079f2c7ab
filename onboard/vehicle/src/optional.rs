//! Optional parts of a joint map: moving features, an archive and several hypotheses. A memory without one of them has the type
//! `()`, and the code for it is not linked.

use crate::{PlanarState, Setting, StartError};
use nalgebra::Vector2;
use scphd::models::ScalarOf;
use scphd::settings::{HypothesesConfig, MovingConfig};
use scphd::storage::{
    Archive, Archived, JointArchive, JointFilter, JointHypotheses, JointMovers, Movers, MoversOf, NoArchive, NoMovers,
    Tracked,
};
use scphd::{JointSlam, MultiHypothesisSlam};

/// A joint map with an archive `A` and moving features `V`, or without them.
pub(crate) type Map<'m, P, A, V> = JointSlam<'m, <P as PlanarState>::Moves, Vector2<ScalarOf<P>>, A, V>;

/// The error for a part that only the memory or only the description has.
pub(crate) fn odd(part: Setting, is_described: bool) -> StartError {
    if is_described { StartError::NoRoom { part } } else { StartError::NotDescribed { part } }
}

/// Checks that the description has a part if and only if the memory has it.
pub(crate) fn has<C>(of_memory: bool, described: Option<C>, part: Setting) -> Result<(), StartError> {
    if of_memory == described.is_some() { Ok(()) } else { Err(odd(part, described.is_some())) }
}

/// Checks that the description has the same part as before.
pub(crate) fn stays<C: PartialEq>(before: Option<C>, now: Option<C>, part: Setting) -> Result<(), StartError> {
    has(before.is_some(), now.as_ref(), part)?;
    if before == now { Ok(()) } else { Err(StartError::Fixed { part }) }
}

/// A memory that can be constructed empty.
#[doc(hidden)]
pub trait Empty {
    /// Empty: all zero.
    const EMPTY: Self;
}

impl Empty for () {
    const EMPTY: Self = ();
}

impl<P: PlanarState, const MOVERS: usize> Empty for JointMovers<P, MOVERS> {
    const EMPTY: Self = Self::new();
}

impl<P: PlanarState, const ARCHIVED: usize> Empty for JointArchive<P, ARCHIVED> {
    const EMPTY: Self = Self::new();
}

impl<P: PlanarState, const OTHERS: usize, const FEATURES: usize, const NUMBERS: usize, const TRACKS: usize> Empty
    for JointHypotheses<P, OTHERS, FEATURES, NUMBERS, TRACKS>
{
    const EMPTY: Self = Self::new();
}

/// Memory for the moving features of a joint map: [`JointMovers`], or `()`.
pub trait MoversMemory<P: PlanarState> {
    /// The moving features in this memory.
    type Movers<'m>: Movers<P>
    where
        Self: 'm,
        P: 'm;

    /// Adds the moving features of the description to the map.
    ///
    /// # Errors
    /// Only one of description and memory has them, or they are out of range.
    fn add_movers<'m, A: Archive<P>>(
        &'m mut self,
        map: Map<'m, P, A, NoMovers>,
        moving: Option<MovingConfig<ScalarOf<P>>>,
    ) -> Result<Map<'m, P, A, Self::Movers<'m>>, StartError>;
}

impl<P: PlanarState> MoversMemory<P> for () {
    type Movers<'m>
        = NoMovers
    where
        P: 'm;

    fn add_movers<'m, A: Archive<P>>(
        &'m mut self,
        map: Map<'m, P, A, NoMovers>,
        moving: Option<MovingConfig<ScalarOf<P>>>,
    ) -> Result<Map<'m, P, A, NoMovers>, StartError> {
        has(false, moving, Setting::MOVERS)?;
        Ok(map)
    }
}

impl<P: PlanarState + 'static, const MOVERS: usize> MoversMemory<P> for JointMovers<P, MOVERS> {
    type Movers<'m> = Tracked<'m, P>;

    fn add_movers<'m, A: Archive<P>>(
        &'m mut self,
        map: Map<'m, P, A, NoMovers>,
        moving: Option<MovingConfig<ScalarOf<P>>>,
    ) -> Result<Map<'m, P, A, Tracked<'m, P>>, StartError> {
        let moving = moving.ok_or(StartError::NotDescribed { part: Setting::MOVERS })?;
        Ok(map.with_movers(self, moving)?)
    }
}

/// Memory for distant features: [`JointArchive`], or `()`.
pub trait ArchiveMemory<P: PlanarState> {
    /// The archive in this memory.
    type Archive<'m>: Archive<P>
    where
        Self: 'm,
        P: 'm;

    /// Adds the archive to the map, for sensors with this range, m.
    ///
    /// # Errors
    /// Only one of description and memory has it, or it is out of range.
    fn add_archive<'m>(
        &'m mut self,
        map: Map<'m, P, NoArchive, NoMovers>,
        reach_m: Option<ScalarOf<P>>,
    ) -> Result<Map<'m, P, Self::Archive<'m>, NoMovers>, StartError>;
}

impl<P: PlanarState> ArchiveMemory<P> for () {
    type Archive<'m>
        = NoArchive
    where
        P: 'm;

    fn add_archive<'m>(
        &'m mut self,
        map: Map<'m, P, NoArchive, NoMovers>,
        reach_m: Option<ScalarOf<P>>,
    ) -> Result<Map<'m, P, NoArchive, NoMovers>, StartError> {
        has(false, reach_m, Setting::ARCHIVE)?;
        Ok(map)
    }
}

impl<P: PlanarState + 'static, const ARCHIVED: usize> ArchiveMemory<P> for JointArchive<P, ARCHIVED> {
    type Archive<'m> = Archived<'m, P>;

    fn add_archive<'m>(
        &'m mut self,
        map: Map<'m, P, NoArchive, NoMovers>,
        reach_m: Option<ScalarOf<P>>,
    ) -> Result<Map<'m, P, Archived<'m, P>, NoMovers>, StartError> {
        let reach_m = reach_m.ok_or(StartError::NotDescribed { part: Setting::ARCHIVE })?;
        Ok(map.with_archive(self, reach_m)?)
    }
}

/// Memory for further hypotheses of data association: [`JointHypotheses`], or `()`. Hypotheses have no archive.
pub trait HypothesesMemory<'m, P: PlanarState, A, V> {
    /// The filter with these hypotheses.
    type Filter: JointFilter<Motion = P::Moves>;

    /// Adds the hypotheses of the description to the map.
    ///
    /// # Errors
    /// Only one of description and memory has them, or they are out of range.
    fn add_hypotheses(
        &'m mut self,
        map: Map<'m, P, A, V>,
        config: Option<HypothesesConfig<ScalarOf<P>>>,
    ) -> Result<Self::Filter, StartError>;
}

impl<'m, P: PlanarState + 'm, A: Archive<P>, V: Movers<P>> HypothesesMemory<'m, P, A, V> for () {
    type Filter = Map<'m, P, A, V>;

    fn add_hypotheses(
        &'m mut self,
        map: Map<'m, P, A, V>,
        config: Option<HypothesesConfig<ScalarOf<P>>>,
    ) -> Result<Map<'m, P, A, V>, StartError> {
        has(false, config, Setting::HYPOTHESES)?;
        Ok(map)
    }
}

impl<
    'm,
    P: PlanarState + 'm,
    V: MoversOf<'m, P>,
    const OTHERS: usize,
    const FEATURES: usize,
    const NUMBERS: usize,
    const TRACKS: usize,
> HypothesesMemory<'m, P, NoArchive, V> for JointHypotheses<P, OTHERS, FEATURES, NUMBERS, TRACKS>
{
    type Filter = MultiHypothesisSlam<'m, P::Moves, Vector2<ScalarOf<P>>, V, OTHERS>;

    fn add_hypotheses(
        &'m mut self,
        map: Map<'m, P, NoArchive, V>,
        config: Option<HypothesesConfig<ScalarOf<P>>>,
    ) -> Result<Self::Filter, StartError> {
        let config = config.ok_or(StartError::NotDescribed { part: Setting::HYPOTHESES })?;
        Ok(map.with_hypotheses(self, config)?)
    }
}

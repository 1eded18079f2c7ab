//! Optional parts of a joint map: moving features and an archive. A memory without one of them has the type `()`, and the code
//! for it is not linked.

use crate::sensor::Polar;
use crate::{PlanarState, Refused, Setting, StartError};
use nalgebra::Vector2;
use scphd::errors::{LoadMapError, ScanError};
use scphd::models::{PositionOf, ScalarOf};
use scphd::settings::MovingConfig;
use scphd::storage::{Archive, Archived, JointArchive, JointMovers, Movers, NoArchive, NoMovers, Tracked};
use scphd::{Component, JointReport, JointSlam};

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
    type Archive<'m>: MapArchive<P>
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

/// The archive of a joint map, or none. With an archive, a map can neither be loaded nor be left unchanged by a scan.
pub trait MapArchive<P: PlanarState>: Archive<P> + Sized {
    /// [`JointSlam::load_map`](scphd::JointSlam::load_map).
    ///
    /// # Errors
    /// As for that, or there is an archive.
    fn load_map<V: Movers<P>>(
        map: &mut Map<'_, P, Self, V>,
        features: &[Component<PositionOf<P>>],
    ) -> Result<(), Refused<LoadMapError>>;

    /// [`JointSlam::localise`](scphd::JointSlam::localise).
    ///
    /// # Errors
    /// As for that, or there is an archive.
    fn localise<V: Movers<P>>(
        map: &mut Map<'_, P, Self, V>,
        detector: &Polar<P, ScalarOf<P>>,
        measurements: &[Vector2<ScalarOf<P>>],
    ) -> Result<JointReport<ScalarOf<P>>, Refused<ScanError>>;
}

impl<P: PlanarState> MapArchive<P> for NoArchive {
    fn load_map<V: Movers<P>>(
        map: &mut Map<'_, P, Self, V>,
        features: &[Component<PositionOf<P>>],
    ) -> Result<(), Refused<LoadMapError>> {
        map.load_map(features).map_err(Refused::Filter)
    }

    fn localise<V: Movers<P>>(
        map: &mut Map<'_, P, Self, V>,
        detector: &Polar<P, ScalarOf<P>>,
        measurements: &[Vector2<ScalarOf<P>>],
    ) -> Result<JointReport<ScalarOf<P>>, Refused<ScanError>> {
        map.localise(detector, measurements).map_err(Refused::Filter)
    }
}

impl<P: PlanarState> MapArchive<P> for Archived<'_, P> {
    fn load_map<V: Movers<P>>(
        _: &mut Map<'_, P, Self, V>,
        _: &[Component<PositionOf<P>>],
    ) -> Result<(), Refused<LoadMapError>> {
        Err(Refused::NotPossible)
    }

    fn localise<V: Movers<P>>(
        _: &mut Map<'_, P, Self, V>,
        _: &Polar<P, ScalarOf<P>>,
        _: &[Vector2<ScalarOf<P>>],
    ) -> Result<JointReport<ScalarOf<P>>, Refused<ScanError>> {
        Err(Refused::NotPossible)
    }
}

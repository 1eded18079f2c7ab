//! A filter behind its handle, as a trait object, so that a program links only the filters that it starts (`starts.rs`).
//!
//! The services are a second trait, available after a call of `scphd_services_...`, so that other programs do not link them.

use crate::block::Handle;
use crate::pointer::{Handed, Out, tell};
use crate::{scphd_fix_report, scphd_status};
use core::any::Any;
use core::fmt::{Debug, Formatter};
use scphd::errors::ObserveError;
use scphd::fixes::FixReport;
use scphd_vehicle::{Refused, Services, Slam, Watched};

/// A filter that can be downcast to its type.
pub trait Running: Slam<f32> + Any {}

impl<S: Slam<f32> + Any> Running for S {}

/// Converts a filter to its services.
type Find = fn(&mut dyn Running) -> Option<&mut dyn Services<f32>>;

/// A filter, and access to its services if they were requested.
pub struct Filter {
    running: &'static mut dyn Running,
    services: Option<Find>,
}

impl Debug for Filter {
    fn fmt(&self, f: &mut Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Filter").finish_non_exhaustive()
    }
}

impl Filter {
    pub(crate) fn new(running: &'static mut dyn Running) -> Self {
        Self { running, services: None }
    }
}

/// A filter, in its memory.
#[derive(Debug)]
pub struct scphd_slam {
    _opaque: [u8; 0],
}

impl Handle for scphd_slam {
    type Inner = Filter;
    const KIND: u32 = 1;
}

/// Calls a function with a filter.
pub(crate) fn on(
    mut slam: Handed<scphd_slam>,
    call: impl FnOnce(&mut dyn Slam<f32>) -> Result<(), scphd_status>,
) -> scphd_status {
    scphd_status::of(slam.enter().and_then(|mut slam| call(&mut *slam.running)))
}

/// Calls a function with the services of a filter, if they were requested.
pub(crate) fn serve(
    mut slam: Handed<scphd_slam>,
    call: impl FnOnce(&mut dyn Services<f32>) -> Result<(), scphd_status>,
) -> scphd_status {
    let serve = || {
        let mut slam = slam.enter()?;
        let find = slam.services.ok_or(scphd_status::NoServices)?;
        call(find(&mut *slam.running).ok_or(scphd_status::NoServices)?)
    };
    scphd_status::of(serve())
}

/// Updates the filter with a fix. With services, the fix may be monitored.
pub(crate) fn observe(
    mut slam: Handed<scphd_slam>,
    mut report: Out<scphd_fix_report>,
    observe: impl FnOnce(&mut dyn Slam<f32>) -> Result<FixReport<f32>, Refused<ObserveError>>,
    watch: impl FnOnce(&mut dyn Services<f32>) -> Result<Watched<f32>, Refused<ObserveError>>,
) -> scphd_status {
    let take = || {
        let report = report.wanted()?;
        let mut slam = slam.enter()?;
        match slam.services.and_then(|find| find(&mut *slam.running)) {
            Some(services) => tell(report, watch(services)?),
            None => tell(report, observe(&mut *slam.running)?),
        }
        Ok(())
    };
    scphd_status::of(take())
}

/// Makes the services of a filter of type `S` available.
pub(crate) fn provide<S: Services<f32> + Any>(mut slam: Handed<scphd_slam>) -> scphd_status {
    let mut provide = || {
        let mut slam = slam.enter()?;
        let find: Find = |running| {
            let any: &mut dyn Any = running;
            any.downcast_mut::<S>().map(|services| services as &mut dyn Services<f32>)
        };
        find(&mut *slam.running).ok_or(scphd_status::WrongMemory)?;
        slam.services = Some(find);
        Ok(())
    };
    scphd_status::of(provide())
}

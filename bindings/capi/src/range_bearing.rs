//! Detectors of range and bearing in the plane.

use crate::block::Handle;
use crate::detector::Parts;
use crate::memory::{Entry, Memory, hand_out};
use crate::pointer::{Bytes, In, Out};
use crate::reason::Reason;
use crate::sets::in_range_bearing;
use crate::{scphd_mounting, scphd_reason, scphd_status, version};
use nalgebra::Vector2;
use scphd::models::{ModelError, RangeBearing, RangeBearingLimits, RangeBearingWindow, Sensing, UniformClutter};
use scphd::storage::ScanRoom;
use scphd::{Births, Detector};

/// A detector of range and bearing, in its memory.
#[derive(Debug)]
pub struct scphd_range_bearing_detector {
    _opaque: [u8; 0],
}

/// One measurement.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_range_bearing {
    /// m.
    pub range_m: f32,
    /// 0 ahead, growing to the left, rad.
    pub bearing_rad: f32,
}

/// The part of the plane that a sensor detects features in. The probability of detection falls linearly with range, and to zero
/// over a ramp around every edge.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_window {
    /// Least range, m; 0 for none.
    pub range_min_m: f32,
    /// Greatest range, m.
    pub range_max_m: f32,
    /// Half width of the soft edge at either range, m.
    pub range_edge_m: f32,
    /// Middle of the window, rad.
    pub bearing_center_rad: f32,
    /// Half width of the window, rad; pi or more for a full circle.
    pub bearing_half_width_rad: f32,
    /// Half width of the soft edge at either side, rad.
    pub bearing_edge_rad: f32,
    /// Probability of detection at range zero, in [0, 1).
    pub probability_near: f32,
    /// At the greatest range.
    pub probability_far: f32,
}

/// What there is to say of such a sensor.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_range_bearing_config {
    /// `sizeof(scphd_range_bearing_config)`, set by the caller.
    pub struct_size: u32,
    /// Standard deviation of the range, m.
    pub range_sigma_m: f32,
    /// Standard deviation of the bearing, rad.
    pub bearing_sigma_rad: f32,
    /// Where it sees.
    pub window: scphd_window,
    /// False measurements to expect of a scan.
    pub clutter_per_scan: f32,
    /// Intensity of births of features that stand still, 1/(m rad).
    pub births_still: f32,
    /// Intensity of births of features that move, 1/(m rad).
    pub births_moving: f32,
    /// Where it sits.
    pub mounting: scphd_mounting,
}

/// The models of such a sensor.
pub(crate) type Polar = Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>;

impl Handle for scphd_range_bearing_detector {
    type Inner = Detector<Polar, ScanRoom<'static, Vector2<f32>>>;
    const KIND: u32 = 4;
}

impl scphd_window {
    /// A hard-edged full circle.
    pub(crate) fn full_circle(range_max_m: f32, probability: f32) -> Self {
        let limits = RangeBearingLimits::full_circle(range_max_m, probability);
        Self {
            range_min_m: limits.range_min_m,
            range_max_m: limits.range_max_m,
            range_edge_m: limits.range_edge_m,
            bearing_center_rad: limits.bearing_center_rad,
            bearing_half_width_rad: limits.bearing_half_width_rad,
            bearing_edge_rad: limits.bearing_edge_rad,
            probability_near: limits.probability_near,
            probability_far: limits.probability_far,
        }
    }

    pub(crate) fn window(&self) -> Result<RangeBearingWindow<f32>, ModelError> {
        RangeBearingWindow::new(RangeBearingLimits {
            range_min_m: self.range_min_m,
            range_max_m: self.range_max_m,
            range_edge_m: self.range_edge_m,
            bearing_center_rad: self.bearing_center_rad,
            bearing_half_width_rad: self.bearing_half_width_rad,
            bearing_edge_rad: self.bearing_edge_rad,
            probability_near: self.probability_near,
            probability_far: self.probability_far,
        })
    }
}

impl scphd_range_bearing_config {
    fn sensing(&self) -> Result<Polar, ModelError> {
        let sensor = RangeBearing::new(self.range_sigma_m, self.bearing_sigma_rad)?;
        let field_of_view = self.window.window()?;
        let clutter = UniformClutter::of_scan(self.clutter_per_scan, field_of_view.measure())?;
        Ok(Sensing { sensor, field_of_view, clutter })
    }

    fn detector(&self, reason: &mut Reason<'_>) -> Result<Detector<Polar>, scphd_status> {
        let sensing = self.sensing().map_err(|error| reason.model(error))?;
        let births = Births { of_static: self.births_still, of_moving: self.births_moving };
        Parts { sensing, births, mounting: &self.mounting }.detector(reason)
    }
}

/// A detector that sees nothing, where the library asks for one and does not look at it.
pub(crate) fn blind() -> Result<Detector<Polar>, ModelError> {
    let sensor = RangeBearing::new(1.0, 1.0)?;
    let (field_of_view, clutter) = (RangeBearingWindow::full_circle(1.0, 0.0)?, UniformClutter::of_scan(0.0, 1.0)?);
    Detector::new(Sensing { sensor, field_of_view, clutter }, Births::NONE)
}

/// A sensor that sees all around, as far as this, m, and with this probability of detection, in [0, 1): one false measurement a scan,
/// one in ten scans of a feature that is new, none that moves, seated where the pose is. The standard deviations of its noise are left 0,
/// which is out of range: set them.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_range_bearing_defaults(
    mut config: Out<scphd_range_bearing_config>,
    range_max_m: f32,
    probability: f32,
) -> scphd_status {
    scphd_status::of(config.get().map(|config| {
        *config = scphd_range_bearing_config {
            struct_size: config.struct_size,
            range_sigma_m: 0.0,
            bearing_sigma_rad: 0.0,
            window: scphd_window::full_circle(range_max_m, probability),
            clutter_per_scan: 1.0,
            births_still: 0.1 / (range_max_m * core::f32::consts::TAU),
            births_moving: 0.0,
            mounting: scphd_mounting::NONE,
        };
    }))
}

/// Starts a detector in this memory: `abi_version` is `SCPHD_ABI_VERSION`, `set` one of `SCPHD_SET_RANGE_BEARING_...`. The reason may be
/// null. Writes the handle to `detector`, or null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_range_bearing_start(
    abi_version: u32,
    set: u32,
    memory: Bytes,
    size_bytes: usize,
    config: In<scphd_range_bearing_config>,
    mut reason: Out<scphd_reason>,
    detector: Out<*mut scphd_range_bearing_detector>,
) -> scphd_status {
    scphd_status::of(hand_out(detector, || {
        version::check(abi_version)?;
        let mut reason = Reason::of(&mut reason)?;
        let memory = Memory::of::<scphd_range_bearing_detector>(memory, size_bytes, set, Entry::Start)?;
        let detector = config.get()?.detector(&mut reason)?;
        in_range_bearing!(memory, |room| detector.over(room).map_err(|error| reason.setup(error)))
    }))
}

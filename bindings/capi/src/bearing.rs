//! Detectors of bearings alone in the plane.

use crate::block::Handle;
use crate::detector::Parts;
use crate::memory::{Entry, Memory, hand_out};
use crate::pointer::{Bytes, In, Out};
use crate::reason::Reason;
use crate::sets::in_bearing;
use crate::{scphd_mounting, scphd_reason, scphd_status, scphd_window, version};
use nalgebra::Vector1;
use scphd::models::{BearingOnly, ModelError, PolarBirths, PolarGrid, RangeBearingWindow, Sensing, UniformClutter};
use scphd::storage::ScanRoom;
use scphd::{Births, Detector};

/// A detector of bearings alone, in its memory. Only a mixture takes its scans.
#[derive(Debug)]
pub struct scphd_bearing_detector {
    _opaque: [u8; 0],
}

/// What there is to say of such a sensor. One bearing has no inverse: features are born on rings around the sensor.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_bearing_config {
    /// `sizeof(scphd_bearing_config)`, set by the caller.
    pub struct_size: u32,
    /// Standard deviation of the bearing, rad.
    pub bearing_sigma_rad: f32,
    /// Where it sees.
    pub window: scphd_window,
    /// False measurements to expect of a scan.
    pub clutter_per_scan: f32,
    /// Range of the innermost ring of births, m.
    pub births_nearest_m: f32,
    /// Range of the outermost ring, m.
    pub births_farthest_m: f32,
    /// Rings, at least 2. The components of all rings must fit into the view of the set.
    pub births_rings: u32,
    /// Components in a ring.
    pub births_sectors: u32,
    /// Weight of each: features that appear there between two scans.
    pub births_weight: f32,
    /// Where it sits.
    pub mounting: scphd_mounting,
}

/// The models of such a sensor.
type Direction = Sensing<BearingOnly<f32, PolarBirths<f32>>, RangeBearingWindow<f32>, UniformClutter<f32>>;

impl Handle for scphd_bearing_detector {
    type Inner = Detector<Direction, ScanRoom<'static, Vector1<f32>>>;
    const KIND: u32 = 5;
}

impl scphd_bearing_config {
    fn sensing(&self) -> Result<Direction, ModelError> {
        // Beyond 16 bits there is no room for them in any set.
        let components = |count: u32| u16::try_from(count).unwrap_or(u16::MAX);
        let births = PolarBirths::new(PolarGrid {
            nearest_m: self.births_nearest_m,
            farthest_m: self.births_farthest_m,
            rings: components(self.births_rings),
            sectors: components(self.births_sectors),
            weight: self.births_weight,
        })?;
        let sensor = BearingOnly::new(self.bearing_sigma_rad, births)?;
        let field_of_view = self.window.window()?;
        let half_width_rad = self.window.bearing_half_width_rad.min(core::f32::consts::PI);
        let clutter = UniformClutter::of_scan(self.clutter_per_scan, half_width_rad + half_width_rad)?;
        Ok(Sensing { sensor, field_of_view, clutter })
    }

    fn detector(&self, reason: &mut Reason<'_>) -> Result<Detector<Direction>, scphd_status> {
        let sensing = self.sensing().map_err(|error| reason.model(error))?;
        Parts { sensing, births: Births::NONE, mounting: &self.mounting }.detector(reason)
    }
}

/// A sensor that sees all around, as far as this, m, and with this probability of detection, in [0, 1): one false measurement a scan,
/// four rings of 24 births from a tenth of the range on, seated where the pose is. The standard deviation of its noise is left 0, which is
/// out of range: set it.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_bearing_defaults(
    mut config: Out<scphd_bearing_config>,
    range_max_m: f32,
    probability: f32,
) -> scphd_status {
    scphd_status::of(config.get().map(|config| {
        *config = scphd_bearing_config {
            struct_size: config.struct_size,
            bearing_sigma_rad: 0.0,
            window: scphd_window::full_circle(range_max_m, probability),
            clutter_per_scan: 1.0,
            births_nearest_m: 0.1 * range_max_m,
            births_farthest_m: range_max_m,
            births_rings: 4,
            births_sectors: 24,
            births_weight: 0.001,
            mounting: scphd_mounting::NONE,
        };
    }))
}

/// Starts a detector in this memory: `abi_version` is `SCPHD_ABI_VERSION`, `set` one of `SCPHD_SET_BEARING_...`. The reason may be null.
/// Writes the handle to `detector`, or null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_bearing_start(
    abi_version: u32,
    set: u32,
    memory: Bytes,
    size_bytes: usize,
    config: In<scphd_bearing_config>,
    mut reason: Out<scphd_reason>,
    detector: Out<*mut scphd_bearing_detector>,
) -> scphd_status {
    scphd_status::of(hand_out(detector, || {
        version::check(abi_version)?;
        let mut reason = Reason::of(&mut reason)?;
        let memory = Memory::of::<scphd_bearing_detector>(memory, size_bytes, set, Entry::Start)?;
        let detector = config.get()?.detector(&mut reason)?;
        in_bearing!(memory, |room| detector.over(room).map_err(|error| reason.setup(error)))
    }))
}

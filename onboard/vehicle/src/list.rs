//! The list of all settings.

use crate::field::{Get, Meaning, Place, Range, Set};
use crate::{Description, Filter, FixSpec, JointSettings, Sensor, SensorModel, VehicleKind};
use core::ffi::CStr;
use scphd::fixes::FixRule;
use scphd::models::{OdometryCorrection, OdometryPrior};
use scphd::settings::{Extraction, HypothesesConfig, Informed, MovingConfig, Plausible, Proposal};
use scphd::{Config, Real};

/// Ranges, and what they are in words, as in "must be finite".
mod ranges {
    use crate::field::Range;
    use core::ffi::CStr;

    type Worded = (Range, &'static CStr);
    const INFINITY: f32 = f32::INFINITY;

    pub(super) const FINITE: Worded = (Range::open(f32::NEG_INFINITY, INFINITY), c"finite");
    pub(super) const NOT_NEGATIVE: Worded =
        (Range { closed: [true, false], ..Range::open(0.0, INFINITY) }, c"finite and at least 0");
    pub(super) const AT_LEAST_ONE: Worded =
        (Range { closed: [true, false], ..Range::open(1.0, INFINITY) }, c"finite and at least 1");
    pub(super) const POSITIVE: Worded = (Range::open(0.0, INFINITY), c"finite and above 0");
    pub(super) const LIMIT: Worded =
        (Range { closed: [false, true], ..Range::open(0.0, INFINITY) }, c"above 0, or infinite");
    pub(super) const GATE: Worded = (Range::within(0.0, INFINITY), c"at least 0, or infinite");
    pub(super) const SHARE: Worded = (Range::within(0.0, 1.0), c"between 0 and 1");
    pub(super) const BELOW_ONE: Worded =
        (Range { closed: [true, false], ..Range::open(0.0, 1.0) }, c"at least 0 and below 1");
    pub(super) const INSIDE_ONE: Worded = (Range::open(0.0, 1.0), c"above 0 and below 1");
    /// A standard deviation whose square single precision can hold.
    pub(super) const SIGMA: Worded = (Range::within(1e-6, 1e6), c"between 0.000001 and 1000000");
}

/// The numbers that a setting may be.
macro_rules! numbers {
    (number $name:literal, $unit:literal, $range:expr, $($rest:tt)*) => {{
        // Without its words.
        const RANGE: Range = $range.0;
        RANGE
    }};
    (choice $name:literal, [$($names:literal),+], $($rest:tt)*) => {
        Range::within(0.0, ([$($names),+].len() - 1) as f32)
    };
}

/// Where a description, or one of its sensors, keeps a setting that is a number.
macro_rules! place {
    (number $description:ident, $name:literal, $unit:literal, $range:expr, $about:literal, $kind:ident, |$d:ident| $place:expr) => {{
        let $d = $description;
        Some(Place::$kind($place))
    }};
    (choice $($rest:tt)*) => {
        None
    };
}

/// Reads a setting that is one of several.
macro_rules! get {
    (choice $description:ident, $sensor:ident, $name:literal, [$($names:literal),+], $about:literal, $get:expr, $set:expr) => {{
        let get: Get<T> = $get;
        get($description, $sensor)
    }};
    (number $($rest:tt)*) => {
        None
    };
}

/// Sets a setting that is one of several.
macro_rules! set {
    (choice $description:ident, $sensor:ident, $choice:ident, $name:literal, [$($names:literal),+], $about:literal, $get:expr, $set:expr) => {{
        let set: Set<T> = $set;
        set($description, $sensor, $choice)
    }};
    (number $($rest:tt)*) => {
        false
    };
}

/// What a setting may be, in words.
macro_rules! range {
    (number $name:literal, $unit:literal, $range:expr, $($rest:tt)*) => { $range.1 };
    (choice $name:literal, [$first:literal $(, $names:literal)*], $($rest:tt)*) => {
        text(concat!("one of ", $first $(, ", ", $names)*, "\0"))
    };
}

/// What a setting is.
macro_rules! meaning {
    (number $name:literal, $unit:literal, $range:expr, $about:literal, $($rest:tt)*) => {
        Meaning { unit: $unit, about: $about, choices: &[] }
    };
    (choice $name:literal, [$($names:literal),+], $about:literal, $($rest:tt)*) => {
        Meaning { unit: "", about: $about, choices: &[$($names),+] }
    };
}

/// Returns the expression of the setting in this place of the list. A compiler makes one jump of it, which is smaller than a table of
/// functions.
macro_rules! at {
    ($place:ident, $here:ident, $($then:expr),+) => { $(if $here.next() == Some($place) { return $then; })+ };
}

/// Makes the tables of all settings. They are several, for a program links each table as a whole.
macro_rules! settings {
    (
        of a description { $($kind:ident($name:literal, $($rest:tt)*),)+ }
        of a sensor { $($sensor_kind:ident($sensor_name:literal, $($sensor_rest:tt)*),)+ }
    ) => {
        /// Their names.
        pub(crate) const NAMES: &[&CStr] = &[$(text(concat!($name, "\0")),)+ $(text(concat!($sensor_name, "\0"))),+];
        /// The numbers that they may be.
        const NUMBERS: &[Range] =
            &[$(numbers!($kind $name, $($rest)*),)+ $(numbers!($sensor_kind $sensor_name, $($sensor_rest)*)),+];
        /// The same in words.
        pub(crate) const RANGES: &[&CStr] =
            &[$(range!($kind $name, $($rest)*),)+ $(range!($sensor_kind $sensor_name, $($sensor_rest)*)),+];
        /// What they are.
        pub(crate) const MEANINGS: &[Meaning] =
            &[$(meaning!($kind $name, $($rest)*),)+ $(meaning!($sensor_kind $sensor_name, $($sensor_rest)*)),+];

        impl<T: Real> Description<T> {
            /// Where the setting at this place of the list is kept, if it is a number; `None` where the description has no such part.
            pub(crate) fn place(&mut self, place: usize, sensor: usize) -> Option<Place<'_, T>> {
                let mut here = 0..;
                at!(place, here, $(place!($kind self, $name, $($rest)*)),+);
                let sensor = self.sensors.get_mut(sensor)?.as_mut()?;
                at!(place, here, $(place!($sensor_kind sensor, $sensor_name, $($sensor_rest)*)),+);
                None
            }

            /// Which choice the setting at this place of the list has, if it is one of several; `None` where the description has no such part.
            pub(crate) fn choice(&self, place: usize, sensor: usize) -> Option<usize> {
                let mut here = 0..;
                at!(place, here, $(get!($kind self, sensor, $name, $($rest)*)),+);
                None
            }

            /// Sets the setting at this place of the list, if it is one of several; false where the description has no such part.
            pub(crate) fn choose(&mut self, place: usize, sensor: usize, choice: usize) -> bool {
                let mut here = 0..;
                at!(place, here, $(set!($kind self, sensor, choice, $name, $($rest)*)),+);
                false
            }
        }
    };
}

/// Number of different ranges, that of each setting by its index, and the ranges: a program links each only once.
#[expect(clippy::indexing_slicing, reason = "evaluated by the compiler")]
const DISTINCT: (usize, [u8; NUMBERS.len()], [Range; NUMBERS.len()]) = {
    let (mut len, mut of, mut all) = (0, [0; NUMBERS.len()], [NUMBERS[0]; NUMBERS.len()]);
    let mut place = 0;
    while place < NUMBERS.len() {
        let mut known = 0;
        while known < len && !all[known].is(&NUMBERS[place]) {
            known += 1;
        }
        if known == len {
            all[len] = NUMBERS[place];
            len += 1;
        }
        of[place] = known as u8;
        place += 1;
    }
    (len, of, all)
};
static RANGE_OF: [u8; NUMBERS.len()] = DISTINCT.1;
static RANGES_ONCE: [Range; DISTINCT.0] = *DISTINCT.2.first_chunk().unwrap();

/// The numbers that the setting at this place of the list may be.
pub(crate) fn numbers(place: usize) -> Option<&'static Range> {
    RANGES_ONCE.get(usize::from(*RANGE_OF.get(place)?))
}

/// A text that ends with a zero.
const fn text(with_zero: &'static str) -> &'static CStr {
    match CStr::from_bytes_with_nul(with_zero.as_bytes()) {
        Ok(text) => text,
        Err(_) => c"",
    }
}

fn put<C: Copy>(place: &mut C, choice: Option<&C>) -> bool {
    choice.is_some_and(|choice| {
        *place = *choice;
        true
    })
}

/// A part that is there or not: one that was not has its defaults.
fn switch<C>(part: &mut Option<C>, on: bool, default: impl FnOnce() -> C) -> bool {
    if on {
        part.get_or_insert_with(default);
    } else {
        *part = None;
    }
    true
}

fn prior<T: Real>() -> OdometryPrior<T> {
    let [scale, offset] = [0.05, 0.02].map(T::from_f64);
    let sigma = OdometryCorrection { speed_scale: scale, turn_scale: scale, turn_offset: offset };
    OdometryPrior { sigma, lasts_s: T::from_f64(3600.0) }
}

fn mixture<T>(description: &mut Description<T>) -> Option<&mut Config<T>> {
    match &mut description.filter {
        Filter::Mixture(config) => Some(config),
        Filter::Joint(_) => None,
    }
}

fn joint<T>(description: &mut Description<T>) -> Option<&mut JointSettings<T>> {
    match &mut description.filter {
        Filter::Joint(joint) => Some(joint),
        Filter::Mixture(_) => None,
    }
}

fn informed<T>(description: &mut Description<T>) -> Option<&mut Informed<T>> {
    match &mut mixture(description)?.proposal {
        Proposal::Informed(informed) => Some(informed),
        Proposal::Blind => None,
    }
}

fn moving<T>(description: &mut Description<T>) -> Option<&mut MovingConfig<T>> {
    match &mut description.filter {
        Filter::Mixture(config) => Some(&mut config.moving),
        Filter::Joint(joint) => joint.movers.as_mut(),
    }
}

fn plausible<T>(description: &mut Description<T>) -> &mut Plausible<T> {
    match &mut description.filter {
        Filter::Mixture(config) => &mut config.plausible,
        Filter::Joint(joint) => &mut joint.config.plausible,
    }
}

fn other_filter<T: Real>(description: &mut Description<T>, is_joint: bool) -> bool {
    match (&description.filter, is_joint) {
        (Filter::Mixture(_), true) => description.filter = Filter::Joint(JointSettings::default()),
        (Filter::Joint(_), false) => description.filter = Filter::Mixture(Config::informed(4)),
        _ => {}
    }
    true
}

fn other_proposal<T: Real>(description: &mut Description<T>, is_informed: bool) -> bool {
    let Some(config) = mixture(description) else { return false };
    match (&config.proposal, is_informed) {
        (Proposal::Blind, true) => {
            config.proposal = Proposal::Informed(Informed { sampled_fraction: T::ZERO, ..Informed::default() });
        }
        (Proposal::Informed(_), false) => config.proposal = Proposal::Blind,
        _ => {}
    }
    true
}

fn other_sensor<T: Real>(description: &mut Description<T>, index: usize, choice: usize) -> bool {
    let Some(place) = description.sensors.get_mut(index) else { return false };
    let model = match choice {
        1 => SensorModel::RangeBearing,
        2 => SensorModel::Bearing,
        _ => {
            *place = None;
            return choice == 0;
        }
    };
    let of = T::from_f64;
    place.get_or_insert_with(|| Sensor::range_bearing(of(15.0), of(0.9), [of(0.2), of(0.02)])).model = model;
    true
}

// A number: name, unit, range, meaning, and where a description or one of its sensors keeps it.
// One of several: name, choices, meaning, and how it is read and set.
#[rustfmt::skip] // A line to a setting.
settings! {
    of a description {
        choice("vehicle.kind", ["ackermann", "unicycle", "unicycle_euler", "holonomic"], "How the vehicle moves.", |d, _| Some(d.vehicle.kind as usize), |d, _, n| put(&mut d.vehicle.kind, [VehicleKind::Ackermann, VehicleKind::Unicycle, VehicleKind::UnicycleEuler, VehicleKind::Holonomic].get(n))),
        number("vehicle.wheelbase_m", "m", ranges::POSITIVE, "Wheelbase L of a car.", Number, |d| &mut d.vehicle.geometry.wheelbase_m),
        number("vehicle.encoder_offset_m", "m", ranges::FINITE, "Offset H of the wheel encoder of a car from the centreline.", Number, |d| &mut d.vehicle.geometry.encoder_offset_m),
        number("vehicle.sensor_forward_m", "m", ranges::FINITE, "Distance of the pose of a car ahead of the rear axle.", Number, |d| &mut d.vehicle.geometry.sensor_forward_m),
        number("vehicle.sensor_left_m", "m", ranges::FINITE, "Distance of the pose of a car to the left of the centreline.", Number, |d| &mut d.vehicle.geometry.sensor_left_m),
        number("noise.speed_sigma_mps", "m/s", ranges::NOT_NEGATIVE, "Standard deviation of the speed.", Number, |d| &mut d.vehicle.noise.speed_sigma_mps),
        number("noise.speed_sigma_ratio", "", ranges::NOT_NEGATIVE, "Standard deviation of the speed divided by the speed; adds in quadrature.", Number, |d| &mut d.vehicle.noise.speed_sigma_ratio),
        number("noise.turn_sigma", "rad/s", ranges::NOT_NEGATIVE, "Standard deviation of the turn rate, or of a car's steering angle, rad.", Number, |d| &mut d.vehicle.noise.turn_sigma),
        number("noise.turn_sigma_ratio", "", ranges::NOT_NEGATIVE, "Standard deviation of the turn rate or steering angle divided by its value; adds in quadrature.", Number, |d| &mut d.vehicle.noise.turn_sigma_ratio),
        number("noise.interval_s", "s", ranges::NOT_NEGATIVE, "Correlation time of the errors; 0: independent in every prediction.", Number, |d| &mut d.vehicle.noise.interval_s),
        choice("filter", ["mixture", "joint"], "The filter. A change sets its defaults.", |d, _| Some(usize::from(matches!(d.filter, Filter::Joint(_)))), |d, _, n| other_filter(d, n == 1)),
        number("mixture.particles", "", (Range::within(1.0, 65535.0), c"between 1 and 65535"), "Number of particles between scans.", Count, |d| &mut mixture(d)?.particles),
        number("mixture.samples", "", (Range::within(1.0, 65535.0), c"between 1 and 65535"), "Number of samples of each particle in a prediction.", Count, |d| &mut mixture(d)?.samples),
        choice("mixture.proposal", ["blind", "informed"], "Proposal density: the motion model, or a Gaussian that includes the scan.", |d, _| match d.filter { Filter::Mixture(c) => Some(usize::from(matches!(c.proposal, Proposal::Informed(_)))), Filter::Joint(_) => None }, |d, _, n| other_proposal(d, n == 1)),
        number("mixture.informed.rounds", "", (Range::within(1.0, 16.0), c"between 1 and 16"), "Informed proposal: maximum number of linearisations.", Count, |d| &mut informed(d)?.rounds),
        number("mixture.informed.sampled_fraction", "", ranges::SHARE, "Informed proposal: share of its covariance that is sampled.", Number, |d| &mut informed(d)?.sampled_fraction),
        number("mixture.informed.min_responsibility", "", ranges::INSIDE_ONE, "Informed proposal: least association probability of a measurement that is used.", Number, |d| &mut informed(d)?.min_responsibility),
        number("mixture.resample_threshold", "", ranges::SHARE, "Particles are resampled if N_eff / N is below this value.", Number, |d| &mut mixture(d)?.resample_threshold),
        number("mixture.prune_weight", "", ranges::INSIDE_ONE, "Components with a smaller weight are removed.", Number, |d| &mut mixture(d)?.prune_weight),
        number("mixture.confirming_detections", "", ranges::NOT_NEGATIVE, "Number of measurements that confirm a component, judged by its covariance; at least 1.", Number, |d| &mut mixture(d)?.confirming_detections),
        number("mixture.unconfirmed_weight", "", ranges::SHARE, "An unconfirmed component with a smaller weight is removed when it leaves the view; 0: none is.", Number, |d| &mut mixture(d)?.unconfirmed_weight),
        number("mixture.confirmed_weight", "", ranges::SHARE, "Least weight of a confirmed component after misses; 0: no limit.", Number, |d| &mut mixture(d)?.confirmed_weight),
        number("mixture.merge_distance", "", ranges::NOT_NEGATIVE, "Squared Mahalanobis distance within which components are merged.", Number, |d| &mut mixture(d)?.merge_distance),
        number("mixture.extraction_weight", "", ranges::SHARE, "Least weight of an estimated feature.", Number, |d| &mut mixture(d)?.extraction_weight),
        number("mixture.negligible", "", ranges::INSIDE_ONE, "Terms of the update below this share of clutter and births are left out; at most prune_weight.", Number, |d| &mut mixture(d)?.negligible),
        number("mixture.max_components", "", ranges::AT_LEAST_ONE, "Maximum number of components in view after pruning and merging.", Count, |d| &mut mixture(d)?.max_components),
        choice("mixture.extraction", ["heaviest", "peaks", "confirmed"], "Selection of the components that are estimated features.", |d, _| match d.filter { Filter::Mixture(c) => Some(c.extraction as usize), Filter::Joint(_) => None }, |d, _, n| mixture(d).is_some_and(|c| put(&mut c.extraction, [Extraction::Heaviest, Extraction::Peaks, Extraction::Confirmed].get(n)))),
        choice("mixture.births_wait", ["no", "yes"], "Whether unexplained births wait for the next scan.", |d, _| match d.filter { Filter::Mixture(c) => Some(usize::from(c.births_wait)), Filter::Joint(_) => None }, |d, _, n| mixture(d).is_some_and(|c| put(&mut c.births_wait, [false, true].get(n)))),
        number("joint.birth_probability_min", "", ranges::SHARE, "Least probability of a measurement to be from a new feature for it to start one.", Number, |d| &mut joint(d)?.config.birth_probability_min),
        number("joint.gate", "", ranges::NOT_NEGATIVE, "Gate of the association: greatest squared Mahalanobis distance of a measurement.", Number, |d| &mut joint(d)?.config.gate),
        number("joint.occlusion_factor", "", ranges::SHARE, "Factor on the probability of detection behind a nearer detection.", Number, |d| &mut joint(d)?.config.occlusion_factor),
        number("joint.least_existence", "", ranges::SHARE, "A feature with a smaller existence probability is removed.", Number, |d| &mut joint(d)?.config.least_existence),
        number("joint.least_tentative", "", ranges::SHARE, "The same for a feature that was detected less than twice.", Number, |d| &mut joint(d)?.config.least_tentative),
        number("joint.extraction_existence", "", ranges::SHARE, "Least existence probability of an estimated feature.", Number, |d| &mut joint(d)?.config.extraction_existence),
        number("joint.merge_distance", "", ranges::NOT_NEGATIVE, "Squared Mahalanobis distance within which two features are merged.", Number, |d| &mut joint(d)?.config.merge_distance),
        number("joint.visible_s", "s", ranges::LIMIT, "Mean time until a visible landmark is occluded; infinite: never.", Number, |d| &mut joint(d)?.config.persistence.visible_s),
        number("joint.occluded_s", "s", ranges::LIMIT, "Mean time of an occlusion.", Number, |d| &mut joint(d)?.config.persistence.occluded_s),
        number("joint.lifetime_s", "s", ranges::LIMIT, "Mean time until a landmark is removed; infinite: never.", Number, |d| &mut joint(d)?.config.persistence.lifetime_s),
        choice("joint.movers", ["no", "yes"], "Whether moving objects are tracked.", |d, _| match d.filter { Filter::Joint(j) => Some(usize::from(j.movers.is_some())), Filter::Mixture(_) => None }, |d, _, n| joint(d).is_some_and(|j| switch(&mut j.movers, n == 1, || MovingConfig::walkers()))),
        choice("joint.odometry", ["no", "yes"], "Whether systematic errors of the odometry are estimated.", |d, _| match d.filter { Filter::Joint(j) => Some(usize::from(j.odometry.is_some())), Filter::Mixture(_) => None }, |d, _, n| joint(d).is_some_and(|j| switch(&mut j.odometry, n == 1, || prior()))),
        choice("joint.archive", ["no", "yes"], "Whether distant features are moved to an archive of submaps.", |d, _| match d.filter { Filter::Joint(j) => Some(usize::from(j.archive_reach_m.is_some())), Filter::Mixture(_) => None }, |d, _, n| joint(d).is_some_and(|j| switch(&mut j.archive_reach_m, n == 1, || T::from_f64(15.0)))),
        choice("joint.hypotheses", ["no", "yes"], "Whether there are several hypotheses of data association.", |d, _| match d.filter { Filter::Joint(j) => Some(usize::from(j.hypotheses.is_some())), Filter::Mixture(_) => None }, |d, _, n| joint(d).is_some_and(|j| switch(&mut j.hypotheses, n == 1, HypothesesConfig::default))),
        number("joint.archive.reach_m", "m", ranges::POSITIVE, "Greatest range of all sensors.", Number, |d| joint(d)?.archive_reach_m.as_mut()?),
        number("joint.odometry.speed_scale", "", ranges::NOT_NEGATIVE, "Standard deviation of the scale error of the speed.", Number, |d| &mut joint(d)?.odometry.as_mut()?.sigma.speed_scale),
        number("joint.odometry.turn_scale", "", ranges::NOT_NEGATIVE, "Standard deviation of the scale error of the turn rate or steering angle.", Number, |d| &mut joint(d)?.odometry.as_mut()?.sigma.turn_scale),
        number("joint.odometry.turn_offset", "rad/s", ranges::NOT_NEGATIVE, "Standard deviation of the offset of the turn rate, or of a car's steering angle, rad.", Number, |d| &mut joint(d)?.odometry.as_mut()?.sigma.turn_offset),
        number("joint.odometry.lasts_s", "s", ranges::LIMIT, "Time in which the errors change by their standard deviations (random walk); infinite: they are constant.", Number, |d| &mut joint(d)?.odometry.as_mut()?.lasts_s),
        number("joint.hypotheses.most", "", (Range::within(1.0, 16.0), c"between 1 and 16"), "Greatest number of hypotheses; the memory may have room for fewer.", Count, |d| &mut joint(d)?.hypotheses.as_mut()?.most),
        number("joint.hypotheses.joined_sigmas", "", ranges::NOT_NEGATIVE, "Two hypotheses are joined if their poses are within this many standard deviations.", Number, |d| &mut joint(d)?.hypotheses.as_mut()?.joined_sigmas),
        number("joint.hypotheses.least_ratio", "", ranges::SHARE, "A hypothesis is not made if its weight, divided by that of the likeliest, is below this.", Number, |d| &mut joint(d)?.hypotheses.as_mut()?.least_ratio),
        number("joint.hypotheses.least_share", "", ranges::SHARE, "A hypothesis is dropped after a scan if its probability is below this.", Number, |d| &mut joint(d)?.hypotheses.as_mut()?.least_share),
        number("moving.velocity_sigma_mps", "m/s", ranges::SIGMA, "Moving features: initial standard deviation of the velocity, along each axis.", Number, |d| &mut moving(d)?.velocity_sigma_mps),
        number("moving.acceleration_psd", "m^2/s^3", ranges::NOT_NEGATIVE, "Moving features: power spectral density of the acceleration.", Number, |d| &mut moving(d)?.motion.acceleration_psd),
        number("moving.lifetime_s", "s", ranges::LIMIT, "Moving features: mean lifetime.", Number, |d| &mut moving(d)?.motion.lifetime_s),
        number("moving.spread_max_m", "m", ranges::POSITIVE, "Moving features: one with a greater standard deviation of the position is removed.", Number, |d| &mut moving(d)?.spread_max_m),
        number("moving.extraction_weight", "", ranges::SHARE, "Moving features: least weight of an estimated one.", Number, |d| &mut moving(d)?.extraction_weight),
        number("plausible.step_max_s", "s", ranges::LIMIT, "Greatest time step. A longer prediction is refused; infinite: no limit.", Number, |d| &mut plausible(d).step_max_s),
        number("plausible.speed_max_mps", "m/s", ranges::LIMIT, "Greatest speed. A faster prediction is refused; infinite: no limit.", Number, |d| &mut plausible(d).speed_max_mps),
        number("plausible.turn_rate_max_radps", "rad/s", ranges::LIMIT, "Greatest turn rate. A faster prediction is refused; infinite: no limit.", Number, |d| &mut plausible(d).turn_rate_max_radps),
        number("plausible.jump_max_m", "m", ranges::LIMIT, "Greatest distance of a step. A longer prediction is refused; infinite: no limit.", Number, |d| &mut plausible(d).jump_max_m),
        choice("position", ["no", "yes"], "Whether the position is measured.", |d, _| Some(usize::from(d.position.is_some())), |d, _, n| switch(&mut d.position, n == 1, || FixSpec::of_sigma(T::ONE))),
        number("position.sigma", "m", ranges::SIGMA, "Standard deviation of a measured position.", Number, |d| &mut d.position.as_mut()?.sigma),
        number("position.forward_m", "m", ranges::FINITE, "Distance of the antenna ahead of the pose.", Number, |d| d.position.as_mut()?.antenna_m.first_mut()?),
        number("position.left_m", "m", ranges::FINITE, "Distance of the antenna to the left of the pose.", Number, |d| d.position.as_mut()?.antenna_m.last_mut()?),
        number("position.gate", "", ranges::LIMIT, "Squared Mahalanobis distance beyond which a measurement is an outlier; infinite: none is.", Number, |d| &mut d.position.as_mut()?.gate),
        choice("position.watch", ["no", "yes"], "Whether the filter is moved if consecutive outliers agree with each other.", |d, _| Some(usize::from(d.position?.watch.is_some())), |d, _, n| d.position.as_mut().is_some_and(|fix| switch(&mut fix.watch, n == 1, FixRule::default))),
        number("position.watch.patience_s", "s", ranges::GATE, "Time from the first outlier until the filter is moved; infinite: never.", Number, |d| &mut d.position.as_mut()?.watch.as_mut()?.patience_s),
        number("position.watch.fewest", "", (Range::within(3.0, 1000.0), c"between 3 and 1000"), "Least number of consecutive outliers.", Small, |d| &mut d.position.as_mut()?.watch.as_mut()?.fewest),
        choice("heading", ["no", "yes"], "Whether the heading is measured.", |d, _| Some(usize::from(d.heading.is_some())), |d, _, n| switch(&mut d.heading, n == 1, || FixSpec::of_sigma(T::ONE))),
        number("heading.sigma", "rad", ranges::SIGMA, "Standard deviation of a measured heading.", Number, |d| &mut d.heading.as_mut()?.sigma),
        number("heading.gate", "", ranges::LIMIT, "Squared Mahalanobis distance beyond which a measurement is an outlier; infinite: none is.", Number, |d| &mut d.heading.as_mut()?.gate),
        choice("heading.watch", ["no", "yes"], "Whether the filter is moved if consecutive outliers agree with each other.", |d, _| Some(usize::from(d.heading?.watch.is_some())), |d, _, n| d.heading.as_mut().is_some_and(|fix| switch(&mut fix.watch, n == 1, FixRule::default))),
        number("heading.watch.patience_s", "s", ranges::GATE, "Time from the first outlier until the filter is moved; infinite: never.", Number, |d| &mut d.heading.as_mut()?.watch.as_mut()?.patience_s),
        number("heading.watch.fewest", "", (Range::within(3.0, 1000.0), c"between 3 and 1000"), "Least number of consecutive outliers.", Small, |d| &mut d.heading.as_mut()?.watch.as_mut()?.fewest),
        number("start.x_m", "m", ranges::FINITE, "Initial x.", Number, |d| &mut d.start.pose.x_m),
        number("start.y_m", "m", ranges::FINITE, "Initial y.", Number, |d| &mut d.start.pose.y_m),
        number("start.heading_rad", "rad", ranges::FINITE, "Initial heading, counterclockwise from the x axis.", Number, |d| &mut d.start.pose.heading_rad),
        number("start.position_sigma_m", "m", ranges::NOT_NEGATIVE, "Standard deviation of the initial position; 0 together with the heading's: the pose is certain.", Number, |d| &mut d.start.position_sigma_m),
        number("start.heading_sigma_rad", "rad", ranges::NOT_NEGATIVE, "Standard deviation of the initial heading.", Number, |d| &mut d.start.heading_sigma_rad),
        number("start.seed", "", (Range::within(0.0, 16777216.0), c"between 0 and 16777216"), "Seed of the random numbers of a mixture.", Seed, |d| &mut d.start.seed),
        choice("sensor.model", ["none", "range_bearing", "bearing"], "Measurement of the sensor. A change from none sets its defaults.", |d, i| d.sensors.get(i).map(|sensor| match sensor { None => 0, Some(sensor) => 1 + sensor.model as usize }), |d, i, n| other_sensor(d, i, n)),
    }
    of a sensor {
        number("sensor.range_sigma_m", "m", ranges::SIGMA, "Standard deviation of the range.", Number, |s| &mut s.range_sigma_m),
        number("sensor.range_sigma_ratio", "", ranges::SHARE, "Standard deviation of the range divided by the range; adds in quadrature.", Number, |s| &mut s.range_sigma_ratio),
        number("sensor.bearing_sigma_rad", "rad", ranges::SIGMA, "Standard deviation of the bearing.", Number, |s| &mut s.bearing_sigma_rad),
        number("sensor.range_min_m", "m", ranges::NOT_NEGATIVE, "Least range of the view.", Number, |s| &mut s.window.range_min_m),
        number("sensor.range_max_m", "m", ranges::POSITIVE, "Greatest range of the view.", Number, |s| &mut s.window.range_max_m),
        number("sensor.range_edge_m", "m", ranges::NOT_NEGATIVE, "Half width of the gradual edge at both ranges.", Number, |s| &mut s.window.range_edge_m),
        number("sensor.bearing_center_rad", "rad", ranges::FINITE, "Centre of the view.", Number, |s| &mut s.window.bearing_center_rad),
        number("sensor.bearing_half_width_rad", "rad", ranges::POSITIVE, "Half width of the view; pi or more for a full circle.", Number, |s| &mut s.window.bearing_half_width_rad),
        number("sensor.bearing_edge_rad", "rad", ranges::NOT_NEGATIVE, "Half width of the gradual edge at both sides.", Number, |s| &mut s.window.bearing_edge_rad),
        number("sensor.probability_near", "", ranges::BELOW_ONE, "Probability of detection at range zero.", Number, |s| &mut s.window.probability_near),
        number("sensor.probability_far", "", ranges::BELOW_ONE, "Probability of detection at the greatest range.", Number, |s| &mut s.window.probability_far),
        number("sensor.clutter_per_scan", "", (Range::within(0.0, 1e9), c"between 0 and 1000000000"), "Expected number of false measurements in a scan.", Number, |s| &mut s.clutter_per_scan),
        number("sensor.births_still", "1/(m rad)", ranges::NOT_NEGATIVE, "Birth intensity of static features.", Number, |s| &mut s.births.of_static),
        number("sensor.births_moving", "1/(m rad)", ranges::NOT_NEGATIVE, "Birth intensity of moving features.", Number, |s| &mut s.births.of_moving),
        number("sensor.births_nearest_m", "m", ranges::POSITIVE, "Bearing-only sensor: range of the nearest births.", Number, |s| &mut s.grid.nearest_m),
        number("sensor.births_farthest_m", "m", ranges::POSITIVE, "Bearing-only sensor: range of the farthest births.", Number, |s| &mut s.grid.farthest_m),
        number("sensor.births_rings", "", (Range::within(2.0, 65535.0), c"between 2 and 65535"), "Bearing-only sensor: number of ranges with births.", Small, |s| &mut s.grid.rings),
        number("sensor.births_sectors", "", (Range::within(1.0, 65535.0), c"between 1 and 65535"), "Bearing-only sensor: number of births at each range.", Small, |s| &mut s.grid.sectors),
        number("sensor.births_weight", "", ranges::NOT_NEGATIVE, "Bearing-only sensor: weight of each birth.", Number, |s| &mut s.grid.weight),
        number("sensor.forward_m", "m", ranges::FINITE, "Distance of the sensor ahead of the pose.", Number, |s| s.seat_m.first_mut()?),
        number("sensor.left_m", "m", ranges::FINITE, "Distance of the sensor to the left of the pose.", Number, |s| s.seat_m.last_mut()?),
        number("sensor.yaw_rad", "rad", ranges::FINITE, "Direction of the sensor, counterclockwise from that of the vehicle.", Number, |s| &mut s.yaw_rad),
    }
}

//! The list of all settings.

use crate::field::{Access, Find, Place};
use crate::{Description, Field, Filter, FixSpec, JointFilter, Range, Sensor, SensorModel, VehicleKind};
use scphd::fixes::FixRule;
use scphd::models::{OdometryCorrection, OdometryPrior};
use scphd::settings::{Extraction, Informed, MovingConfig, Plausible, Proposal};
use scphd::{Config, Real};

/// A setting that is a number.
macro_rules! number {
    ($name:literal, $unit:literal, $range:expr, $about:literal, $kind:ident, |$d:ident, $i:tt| $place:expr) => {{
        let find: Find<T> = |$d, $i| Some(Place::$kind($place));
        Field { name: $name, unit: $unit, range: $range, about: $about, access: Access::Number(find) }
    }};
}

/// A setting that is one of several.
macro_rules! choice {
    ($name:literal, [$first:literal $(, $names:literal)*], $about:literal, $get:expr, $set:expr) => {{
        const NAMES: &[&str] = &[$first $(, $names)*];
        let range = Range::within(0.0, (NAMES.len() - 1) as f64, concat!("one of ", $first $(, ", ", $names)*));
        Field { name: $name, unit: "", range, about: $about, access: Access::Choice { names: NAMES, get: $get, set: $set } }
    }};
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

fn joint<T>(description: &mut Description<T>) -> Option<&mut JointFilter<T>> {
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

fn sensor<T>(description: &mut Description<T>, index: usize) -> Option<&mut Sensor<T>> {
    description.sensors.get_mut(index)?.as_mut()
}

fn other_filter<T: Real>(description: &mut Description<T>, is_joint: bool) -> bool {
    match (&description.filter, is_joint) {
        (Filter::Mixture(_), true) => description.filter = Filter::Joint(JointFilter::default()),
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

#[rustfmt::skip] // A line to a setting.
impl<T: Real> Description<T> {
    /// All settings.
    pub const FIELDS: &'static [Field<T>] = &[
        choice!("vehicle.kind", ["ackermann", "unicycle", "unicycle_euler", "holonomic"], "How the vehicle moves.", |d, _| Some(d.vehicle.kind as usize), |d, _, n| put(&mut d.vehicle.kind, [VehicleKind::Ackermann, VehicleKind::Unicycle, VehicleKind::UnicycleEuler, VehicleKind::Holonomic].get(n))),
        number!("vehicle.wheelbase_m", "m", Range::POSITIVE, "Of a car: wheelbase L.", Number, |d, _| &mut d.vehicle.geometry.wheelbase_m),
        number!("vehicle.encoder_offset_m", "m", Range::FINITE, "Of a car: offset H of the wheel encoder from the centreline.", Number, |d, _| &mut d.vehicle.geometry.encoder_offset_m),
        number!("vehicle.sensor_forward_m", "m", Range::FINITE, "Of a car: how far ahead of the rear axle its pose is.", Number, |d, _| &mut d.vehicle.geometry.sensor_forward_m),
        number!("vehicle.sensor_left_m", "m", Range::FINITE, "Of a car: how far left of the centreline its pose is.", Number, |d, _| &mut d.vehicle.geometry.sensor_left_m),
        number!("noise.speed_sigma_mps", "m/s", Range::NOT_NEGATIVE, "Standard deviation of the speed.", Number, |d, _| &mut d.vehicle.noise.speed_sigma_mps),
        number!("noise.speed_sigma_ratio", "", Range::NOT_NEGATIVE, "The same as a share of the speed; adds in quadrature.", Number, |d, _| &mut d.vehicle.noise.speed_sigma_ratio),
        number!("noise.turn_sigma", "rad/s", Range::NOT_NEGATIVE, "Standard deviation of the turn rate, or of a car's steering angle, rad.", Number, |d, _| &mut d.vehicle.noise.turn_sigma),
        number!("noise.turn_sigma_ratio", "", Range::NOT_NEGATIVE, "The same as a share of it; adds in quadrature.", Number, |d, _| &mut d.vehicle.noise.turn_sigma_ratio),
        number!("noise.interval_s", "s", Range::NOT_NEGATIVE, "How long an error lasts; 0: drawn anew in every prediction.", Number, |d, _| &mut d.vehicle.noise.interval_s),
        choice!("filter", ["mixture", "joint"], "Which filter; another one than before has its defaults.", |d, _| Some(usize::from(matches!(d.filter, Filter::Joint(_)))), |d, _, n| other_filter(d, n == 1)),
        number!("mixture.particles", "", Range::within(1.0, 65535.0, "between 1 and 65535"), "Particles kept between scans.", Count, |d, _| &mut mixture(d)?.particles),
        number!("mixture.samples", "", Range::within(1.0, 65535.0, "between 1 and 65535"), "Samples of each in a prediction.", Count, |d, _| &mut mixture(d)?.samples),
        choice!("mixture.proposal", ["blind", "informed"], "Where samples are drawn from: the motion, or a Gaussian that the scan has been taken into.", |d, _| match d.filter { Filter::Mixture(c) => Some(usize::from(matches!(c.proposal, Proposal::Informed(_)))), Filter::Joint(_) => None }, |d, _, n| other_proposal(d, n == 1)),
        number!("mixture.informed.rounds", "", Range::within(1.0, 16.0, "between 1 and 16"), "Informed: linearisations at most.", Count, |d, _| &mut informed(d)?.rounds),
        number!("mixture.informed.sampled_fraction", "", Range::SHARE, "Informed: share of the covariance that is drawn from.", Number, |d, _| &mut informed(d)?.sampled_fraction),
        number!("mixture.informed.min_responsibility", "", Range::INSIDE_ONE, "Informed: a component speaks for a measurement of which it explains this share.", Number, |d, _| &mut informed(d)?.min_responsibility),
        number!("mixture.resample_threshold", "", Range::SHARE, "Resampled where N_eff / N is below.", Number, |d, _| &mut mixture(d)?.resample_threshold),
        number!("mixture.prune_weight", "", Range::INSIDE_ONE, "Components below this weight are dropped.", Number, |d, _| &mut mixture(d)?.prune_weight),
        number!("mixture.confirming_detections", "", Range::NOT_NEGATIVE, "A component is confirmed where it is better known than by so many measurements, at least 1.", Number, |d, _| &mut mixture(d)?.confirming_detections),
        number!("mixture.unconfirmed_weight", "", Range::SHARE, "One that leaves the view lighter than this, not confirmed, is forgotten; 0: none is.", Number, |d, _| &mut mixture(d)?.unconfirmed_weight),
        number!("mixture.confirmed_weight", "", Range::SHARE, "Misses take a confirmed component no further down; 0: they do.", Number, |d, _| &mut mixture(d)?.confirmed_weight),
        number!("mixture.merge_distance", "", Range::NOT_NEGATIVE, "Squared Mahalanobis distance within which components are merged.", Number, |d, _| &mut mixture(d)?.merge_distance),
        number!("mixture.extraction_weight", "", Range::SHARE, "Least weight of an estimated feature.", Number, |d, _| &mut mixture(d)?.extraction_weight),
        number!("mixture.negligible", "", Range::INSIDE_ONE, "Terms below this share of what explains a measurement without features are left out; at most prune_weight.", Number, |d, _| &mut mixture(d)?.negligible),
        number!("mixture.max_components", "", Range::AT_LEAST_ONE, "Components that a reduction leaves in view at most.", Count, |d, _| &mut mixture(d)?.max_components),
        choice!("mixture.extraction", ["heaviest", "peaks", "confirmed"], "Which components are the estimated features.", |d, _| match d.filter { Filter::Mixture(c) => Some(c.extraction as usize), Filter::Joint(_) => None }, |d, _, n| mixture(d).is_some_and(|c| put(&mut c.extraction, [Extraction::Heaviest, Extraction::Peaks, Extraction::Confirmed].get(n)))),
        number!("joint.birth_share", "", Range::SHARE, "A measurement gives birth where nothing else explains at least this share of it.", Number, |d, _| &mut joint(d)?.config.birth_share),
        number!("joint.gate", "", Range::NOT_NEGATIVE, "Squared Mahalanobis distance beyond which a measurement says nothing of a feature.", Number, |d, _| &mut joint(d)?.config.gate),
        number!("joint.behind", "", Range::SHARE, "Share of the probability of detection that is left behind a nearer detection.", Number, |d, _| &mut joint(d)?.config.behind),
        number!("joint.least_existence", "", Range::SHARE, "A feature is dropped below this probability that it is there.", Number, |d, _| &mut joint(d)?.config.least_existence),
        number!("joint.least_tentative", "", Range::SHARE, "The same while it was detected less than twice.", Number, |d, _| &mut joint(d)?.config.least_tentative),
        number!("joint.extraction_existence", "", Range::SHARE, "A feature is part of the estimate from this probability on.", Number, |d, _| &mut joint(d)?.config.extraction_existence),
        number!("joint.merge_distance", "", Range::NOT_NEGATIVE, "Squared Mahalanobis distance within which two features are one.", Number, |d, _| &mut joint(d)?.config.merge_distance),
        number!("joint.in_sight_s", "s", Range::LIMIT, "Mean time that a landmark stays in sight before something hides it; infinite: nothing does.", Number, |d, _| &mut joint(d)?.config.persistence.in_sight_s),
        number!("joint.hidden_s", "s", Range::LIMIT, "Mean time that it stays hidden.", Number, |d, _| &mut joint(d)?.config.persistence.hidden_s),
        number!("joint.lifetime_s", "s", Range::LIMIT, "Mean time until it is taken away; infinite: never.", Number, |d, _| &mut joint(d)?.config.persistence.lifetime_s),
        choice!("joint.movers", ["no", "yes"], "Whether features that move are kept beside the map.", |d, _| match d.filter { Filter::Joint(j) => Some(usize::from(j.movers.is_some())), Filter::Mixture(_) => None }, |d, _, n| joint(d).is_some_and(|j| switch(&mut j.movers, n == 1, || MovingConfig::walkers()))),
        choice!("joint.odometry", ["no", "yes"], "Whether what the odometry is off by is learnt.", |d, _| match d.filter { Filter::Joint(j) => Some(usize::from(j.odometry.is_some())), Filter::Mixture(_) => None }, |d, _, n| joint(d).is_some_and(|j| switch(&mut j.odometry, n == 1, || prior()))),
        choice!("joint.archive", ["no", "yes"], "Whether features that are far away go to an archive.", |d, _| match d.filter { Filter::Joint(j) => Some(usize::from(j.archive_reach_m.is_some())), Filter::Mixture(_) => None }, |d, _, n| joint(d).is_some_and(|j| switch(&mut j.archive_reach_m, n == 1, || T::from_f64(15.0)))),
        number!("joint.archive.reach_m", "m", Range::POSITIVE, "How far the farthest-looking sensor sees.", Number, |d, _| joint(d)?.archive_reach_m.as_mut()?),
        number!("joint.odometry.speed_scale", "", Range::NOT_NEGATIVE, "Standard deviation of what the speed is off by, as a share of it.", Number, |d, _| &mut joint(d)?.odometry.as_mut()?.sigma.speed_scale),
        number!("joint.odometry.turn_scale", "", Range::NOT_NEGATIVE, "The same of the turn rate or steering angle.", Number, |d, _| &mut joint(d)?.odometry.as_mut()?.sigma.turn_scale),
        number!("joint.odometry.turn_offset", "rad/s", Range::NOT_NEGATIVE, "Standard deviation of the offset of the turn rate, or of the steering angle, rad.", Number, |d, _| &mut joint(d)?.odometry.as_mut()?.sigma.turn_offset),
        number!("joint.odometry.lasts_s", "s", Range::LIMIT, "How long it takes until it has walked as far as that; infinite: it never changes.", Number, |d, _| &mut joint(d)?.odometry.as_mut()?.lasts_s),
        number!("moving.velocity_sigma_mps", "m/s", Range::SIGMA, "Features that move: standard deviation of the velocity of a new one, along each axis.", Number, |d, _| &mut moving(d)?.velocity_sigma_mps),
        number!("moving.acceleration_psd", "m^2/s^3", Range::NOT_NEGATIVE, "Features that move: power spectral density of their acceleration.", Number, |d, _| &mut moving(d)?.motion.acceleration_psd),
        number!("moving.lifetime_s", "s", Range::LIMIT, "Features that move: mean time until one vanishes.", Number, |d, _| &mut moving(d)?.motion.lifetime_s),
        number!("moving.spread_max_m", "m", Range::POSITIVE, "Features that move: one less certain than this is forgotten.", Number, |d, _| &mut moving(d)?.spread_max_m),
        number!("moving.extraction_weight", "", Range::SHARE, "Features that move: least weight of an estimated one.", Number, |d, _| &mut moving(d)?.extraction_weight),
        number!("plausible.step_max_s", "s", Range::LIMIT, "Longest step of a prediction. Beyond it a prediction is refused; infinite: no limit.", Number, |d, _| &mut plausible(d).step_max_s),
        number!("plausible.speed_max_mps", "m/s", Range::LIMIT, "Greatest speed. Beyond it a prediction is refused; infinite: no limit.", Number, |d, _| &mut plausible(d).speed_max_mps),
        number!("plausible.turn_rate_max_radps", "rad/s", Range::LIMIT, "Greatest turn rate. Beyond it a prediction is refused; infinite: no limit.", Number, |d, _| &mut plausible(d).turn_rate_max_radps),
        number!("plausible.jump_max_m", "m", Range::LIMIT, "Greatest distance of one step. Beyond it a prediction is refused; infinite: no limit.", Number, |d, _| &mut plausible(d).jump_max_m),
        choice!("sensor.model", ["none", "range_bearing", "bearing"], "What the sensor measures; one that was none has defaults.", |d, i| d.sensors.get(i).map(|sensor| match sensor { None => 0, Some(sensor) => 1 + sensor.model as usize }), |d, i, n| other_sensor(d, i, n)),
        number!("sensor.range_sigma_m", "m", Range::SIGMA, "Standard deviation of the range.", Number, |d, i| &mut sensor(d, i)?.range_sigma_m),
        number!("sensor.bearing_sigma_rad", "rad", Range::SIGMA, "Standard deviation of the bearing.", Number, |d, i| &mut sensor(d, i)?.bearing_sigma_rad),
        number!("sensor.range_min_m", "m", Range::NOT_NEGATIVE, "Least range.", Number, |d, i| &mut sensor(d, i)?.window.range_min_m),
        number!("sensor.range_max_m", "m", Range::POSITIVE, "Greatest range.", Number, |d, i| &mut sensor(d, i)?.window.range_max_m),
        number!("sensor.range_edge_m", "m", Range::NOT_NEGATIVE, "Half width of the soft edge at either range.", Number, |d, i| &mut sensor(d, i)?.window.range_edge_m),
        number!("sensor.bearing_center_rad", "rad", Range::FINITE, "Middle of the window.", Number, |d, i| &mut sensor(d, i)?.window.bearing_center_rad),
        number!("sensor.bearing_half_width_rad", "rad", Range::POSITIVE, "Half width of the window; pi or more for a full circle.", Number, |d, i| &mut sensor(d, i)?.window.bearing_half_width_rad),
        number!("sensor.bearing_edge_rad", "rad", Range::NOT_NEGATIVE, "Half width of the soft edge at either side.", Number, |d, i| &mut sensor(d, i)?.window.bearing_edge_rad),
        number!("sensor.probability_near", "", Range::BELOW_ONE, "Probability of detection at range zero.", Number, |d, i| &mut sensor(d, i)?.window.probability_near),
        number!("sensor.probability_far", "", Range::BELOW_ONE, "The same at the greatest range.", Number, |d, i| &mut sensor(d, i)?.window.probability_far),
        number!("sensor.clutter_per_scan", "", Range::within(0.0, 1e9, "between 0 and 1000000000"), "False measurements to expect of a scan.", Number, |d, i| &mut sensor(d, i)?.clutter_per_scan),
        number!("sensor.births_still", "1/(m rad)", Range::NOT_NEGATIVE, "Intensity of births of features that stand still.", Number, |d, i| &mut sensor(d, i)?.births.of_static),
        number!("sensor.births_moving", "1/(m rad)", Range::NOT_NEGATIVE, "Intensity of births of features that move.", Number, |d, i| &mut sensor(d, i)?.births.of_moving),
        number!("sensor.births_nearest_m", "m", Range::POSITIVE, "Of bearings: range of the innermost ring of births.", Number, |d, i| &mut sensor(d, i)?.grid.nearest_m),
        number!("sensor.births_farthest_m", "m", Range::POSITIVE, "Of bearings: range of the outermost ring.", Number, |d, i| &mut sensor(d, i)?.grid.farthest_m),
        number!("sensor.births_rings", "", Range::within(2.0, 65535.0, "between 2 and 65535"), "Of bearings: number of rings.", Small, |d, i| &mut sensor(d, i)?.grid.rings),
        number!("sensor.births_sectors", "", Range::within(1.0, 65535.0, "between 1 and 65535"), "Of bearings: births in a ring.", Small, |d, i| &mut sensor(d, i)?.grid.sectors),
        number!("sensor.births_weight", "", Range::NOT_NEGATIVE, "Of bearings: weight of every birth.", Number, |d, i| &mut sensor(d, i)?.grid.weight),
        number!("sensor.forward_m", "m", Range::FINITE, "How far ahead of the pose the sensor sits.", Number, |d, i| sensor(d, i)?.seat_m.first_mut()?),
        number!("sensor.left_m", "m", Range::FINITE, "How far left of the pose it sits.", Number, |d, i| sensor(d, i)?.seat_m.last_mut()?),
        number!("sensor.yaw_rad", "rad", Range::FINITE, "Where it looks, to the left.", Number, |d, i| &mut sensor(d, i)?.yaw_rad),
        choice!("position", ["no", "yes"], "Whether the position is measured.", |d, _| Some(usize::from(d.position.is_some())), |d, _, n| switch(&mut d.position, n == 1, || FixSpec::of_sigma(T::ONE))),
        number!("position.sigma", "m", Range::SIGMA, "Standard deviation of a measured position.", Number, |d, _| &mut d.position.as_mut()?.sigma),
        number!("position.forward_m", "m", Range::FINITE, "How far ahead of the pose the antenna is.", Number, |d, _| d.position.as_mut()?.antenna_m.first_mut()?),
        number!("position.left_m", "m", Range::FINITE, "How far left of the pose it is.", Number, |d, _| d.position.as_mut()?.antenna_m.last_mut()?),
        number!("position.gate", "", Range::LIMIT, "Squared Mahalanobis distance beyond which it is an outlier; infinite: none is.", Number, |d, _| &mut d.position.as_mut()?.gate),
        choice!("position.watch", ["no", "yes"], "Whether outliers that agree with each other show that the filter is wrong, which is moved then.", |d, _| Some(usize::from(d.position?.watch.is_some())), |d, _, n| d.position.as_mut().is_some_and(|fix| switch(&mut fix.watch, n == 1, FixRule::default))),
        number!("position.watch.patience_s", "s", Range::GATE, "So long is waited from the first outlier; infinite: for ever.", Number, |d, _| &mut d.position.as_mut()?.watch.as_mut()?.patience_s),
        number!("position.watch.fewest", "", Range::within(3.0, 1000.0, "between 3 and 1000"), "So many must be refused in a row.", Small, |d, _| &mut d.position.as_mut()?.watch.as_mut()?.fewest),
        choice!("heading", ["no", "yes"], "Whether the heading is measured.", |d, _| Some(usize::from(d.heading.is_some())), |d, _, n| switch(&mut d.heading, n == 1, || FixSpec::of_sigma(T::ONE))),
        number!("heading.sigma", "rad", Range::SIGMA, "Standard deviation of a measured heading.", Number, |d, _| &mut d.heading.as_mut()?.sigma),
        number!("heading.gate", "", Range::LIMIT, "Squared Mahalanobis distance beyond which it is an outlier; infinite: none is.", Number, |d, _| &mut d.heading.as_mut()?.gate),
        choice!("heading.watch", ["no", "yes"], "Whether outliers that agree with each other show that the filter is wrong, which is moved then.", |d, _| Some(usize::from(d.heading?.watch.is_some())), |d, _, n| d.heading.as_mut().is_some_and(|fix| switch(&mut fix.watch, n == 1, FixRule::default))),
        number!("heading.watch.patience_s", "s", Range::GATE, "So long is waited from the first outlier; infinite: for ever.", Number, |d, _| &mut d.heading.as_mut()?.watch.as_mut()?.patience_s),
        number!("heading.watch.fewest", "", Range::within(3.0, 1000.0, "between 3 and 1000"), "So many must be refused in a row.", Small, |d, _| &mut d.heading.as_mut()?.watch.as_mut()?.fewest),
        number!("start.x_m", "m", Range::FINITE, "Start: x.", Number, |d, _| &mut d.start.pose.x_m),
        number!("start.y_m", "m", Range::FINITE, "Start: y.", Number, |d, _| &mut d.start.pose.y_m),
        number!("start.heading_rad", "rad", Range::FINITE, "Start: heading, from x to y.", Number, |d, _| &mut d.start.pose.heading_rad),
        number!("start.position_sigma_m", "m", Range::NOT_NEGATIVE, "Standard deviation of the position at the start; 0 with the next: certain.", Number, |d, _| &mut d.start.position_sigma_m),
        number!("start.heading_sigma_rad", "rad", Range::NOT_NEGATIVE, "Standard deviation of the heading at the start.", Number, |d, _| &mut d.start.heading_sigma_rad),
        number!("start.seed", "", Range::within(0.0, 9007199254740992.0, "between 0 and 9007199254740992"), "Seed of the random numbers of a mixture.", Seed, |d, _| &mut d.start.seed),
    ];
}

//! Default settings for a log, from its description of vehicle, sensor and noise, never from its name.
//!
//! Stated values are used as stated. Others are from a table of physical figures ([`UNSTATED`]), the same for every vehicle,
//! sensor and place. These are round; they were chosen on the random worlds of the seeds 100 to 199 (`scenario::worlds`), not on
//! recorded logs, except those for drives that lose their heading, for which robots 1 to 3 of MRCLAM were used. A simulated log
//! states its noise exactly; a data sheet states only the white part, so that a margin is added.

use super::moving_objects;
use super::odometry_noise;
use super::white::{AS_STATED, WhitePart};
use super::{
    Extraction, FilterSettings, JointSettings, Likelihood, MovingSettings, Proposal, SensorSettings, Settings,
    VehicleSettings,
};
use scphd::JointConfig;
use scphd::models::ControlNoise;
use scphd_log::angle::wrap;
use scphd_log::log::{FixNoise, Log, Nominal, Odometry, Sensor, Vehicle};
use scphd_log::vehicle::{FASTEST_MPS, Way};
use scphd_worlds::scenario::{is_of_thesis, thesis_run};
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Samples M of every particle in a prediction: more cost as much as more particles.
const SAMPLES: usize = 1;
/// Resample below this N_eff / N: section 5.3.1, and most of the literature.
const RESAMPLE_THRESHOLD: f64 = 0.5;
/// Greatest expected number of false measurements within three standard deviations of a feature in a scan at which clutter is
/// sparse: a feature is then not confirmed by chance, and one with a few detections exists.
const SPARSE_CLUTTER: f64 = 0.005;

/// Rules for keeping and dropping features in a simulation.
struct Memory {
    particles: usize,
    /// κ / w_b. An unexplained measurement starts as a feature of weight 1/(1 + κ/w_b). The next detection near it makes it a
    /// likely feature (the peak of a Gaussian is far above κ); the weight of a single false measurement decays.
    clutter_over_birth: f64,
    prune_weight: f64,
    confirming_detections: f64,
    unconfirmed_weight: f64,
    confirmed_weight: f64,
    merge_distance: f64,
    extraction: Extraction,
    extraction_weight: f64,
    /// Sampled share of the informed proposal's covariance.
    drawn: f64,
}

/// Dense clutter: the weights decide. A component is dropped at about the weight of a false measurement after one miss (at p_D =
/// 0.95): lighter ones have less information than the next measurement, and were most of the map. A component with a single
/// detection and less than the weight 0.5 was clutter when it leaves the view. Components within two standard deviations are
/// merged.
const DENSE: Memory = Memory {
    particles: 100,
    clutter_over_birth: 20.0,
    prune_weight: 2.5e-3,
    confirming_detections: 1.0,
    unconfirmed_weight: 0.5,
    confirmed_weight: 0.0,
    merge_distance: 4.0,
    extraction: Extraction::Peaks,
    extraction_weight: 0.0,
    drawn: 0.2,
};

/// Sparse clutter: components that are not confirmed by three measurements are forgotten when they leave the view, with any
/// weight. Confirmed ones remain, with a weight of at least a fifth. Distances between features are large compared with their
/// uncertainty, so that components within four standard deviations are of one feature, seen from wrong poses. The association is
/// nearly certain: the mean of the proposal is better than a sample, and one particle is as good as many.
const SPARSE: Memory = Memory {
    particles: 1,
    clutter_over_birth: 50.0,
    prune_weight: 1e-3,
    confirming_detections: 3.0,
    unconfirmed_weight: 1.0,
    confirmed_weight: 0.2,
    merge_distance: 16.0,
    extraction: Extraction::Confirmed,
    extraction_weight: 0.08,
    drawn: 0.0,
};

/// w_m / w_b: most new features are static.
const MOVING_BIRTH_SHARE: f64 = 0.5;
/// The same for a log that shows moving objects: until the scans have decided whether a feature moves, it corrects the pose less.
const SEEN_MOVING_BIRTH_SHARE: f64 = 2.0;
/// For a simulation, or a vehicle that stands: somewhat more than walking pace.
const MOVING_VELOCITY_SIGMA_MPS: f64 = 1.0;
/// Time after which the speed of a moving feature has changed completely, s: for pedestrians, by half a metre a second after
/// three seconds.
const MOVING_STEADY_S: f64 = 10.0;
/// p_S = 0.999 for a tenth of a second.
const MOVING_LIFETIME_S: f64 = 100.0;
/// Least speed of the vehicle, m/s, from which that of moving features is derived.
const LEAST_SPEED_MPS: f64 = 0.01;
/// Standard deviation of the position, m, above which a moving feature is forgotten.
const MOVING_SPREAD_MAX_M: f64 = 1.5;
/// Least weight of an estimated moving feature: it distinguishes moving features from clutter.
const MOVING_EXTRACTION_WEIGHT: f64 = 0.4;
/// Number of linearisations of the informed proposal.
const PROPOSAL_ROUNDS: usize = 3;
/// Least responsibility for a measurement with which a component steers the proposal.
const LEAST_SHARE: f64 = 0.02;
/// Factor for the correlation time of odometry errors in mixtures: the particles do not represent the correlation of features
/// with the pose.
const INTERVAL_MARGIN: f64 = 2.0;
/// A time longer than any log, s: in a simulation landmarks are never occluded or removed.
const NEVER_S: f64 = 1e9;
/// Greatest number of components in view. Published logs need less than half; it bounds the time of a scan after a failure.
const MAX_COMPONENTS: usize = 1000;

/// Births a scan in logs without clutter.
const BIRTHS_PER_SCAN: f64 = 0.1;

/// Values for properties that a log does not state.
struct Unstated {
    /// Factor for the noise of a data sheet, which is that of one good measurement. Other errors add to it: the width of a trunk,
    /// time stamps, the duration of a scan, outliers (one return in fifty), and the ignored correlation of features.
    noise_margin: f64,
    /// p_D. Too low a value costs little: false features remain longer. Too high a value removes features that are occluded for a
    /// moment.
    detection: f64,
    /// Half width of the soft edges of the view in standard deviations: the true edges are less sharp than in a data sheet.
    edge_sigmas: f64,
    /// Unconfirmed features that leave the view with less than this weight were probably clutter, and are forgotten.
    unconfirmed_weight: f64,
    /// Number of false measurements a scan.
    clutter_per_scan: f64,
    /// κ / w_b.
    clutter_over_birth: f64,
    /// Components within three standard deviations are merged.
    merge_distance: f64,
    /// Standard deviation of the velocity of moving features, as a share of the vehicle's own speed: a robot meets robots, a car
    /// meets cars. A coordinate of a velocity is less than its magnitude, and some objects are slow.
    mover_speed_share: f64,
    /// Enough for several hypotheses of the heading; more bring little (docs/studies.md).
    particles: usize,
    /// Sampled share of the informed proposal's covariance.
    drawn: f64,
}

/// Relative noise of turns for a drive that loses its heading. The landmarks do not correct its heading for a long time, so that
/// slip, and the difference between a commanded turn and the turn made, count in full.
const LOST_TURN_SHARE: f64 = 0.3;
/// Greatest expected number of other detections within three standard deviations of a detection at which several hypotheses help:
/// in denser scans the noise itself makes landmarks ambiguous.
const CROWDED: f64 = 0.1;
/// Number of hypotheses of data association for a drive that loses its heading, or among moving objects, which may be taken for
/// landmarks. With two to four the likeliest ones of some such drives are all wrong.
const HYPOTHESES: usize = 8;

/// The stated noise of a sensor is white if this share of its variance is ([`WhitePart`]). If it is greater, also without what
/// odometry adds, the sensor has more noise than stated.
const WHITE: RangeInclusive<f64> = 0.7..=AS_STATED;
/// Factor for white stated noise, instead of [`Unstated::noise_margin`].
const WHITE_MARGIN: f64 = 1.1;
/// Correlation time of odometry errors with such sensors, s. The usual one goes with the larger margin: both variances are about
/// half as large, so that their ratio, and the estimate, remain nearly the same.
const WHITE_INTERVAL_S: f64 = 0.25;

const UNSTATED: Unstated = Unstated {
    noise_margin: 1.5,
    detection: 0.7,
    edge_sigmas: 3.0,
    unconfirmed_weight: 0.5,
    clutter_per_scan: 1.0,
    clutter_over_birth: 20.0,
    merge_distance: 9.0,
    mover_speed_share: 0.5,
    particles: 16,
    drawn: 0.05,
};

/// Half width of a soft edge in standard deviations of its coordinate: within it, noise and pose decide whether a feature is
/// detected. The wider the edge, the more weight a feature loses whenever it leaves the view.
const EDGE_SIGMAS: f64 = 1.0;
/// A window is a full circle if it differs by less than this, rad: logs give π with a few digits.
const CIRCLE_SLACK_RAD: f64 = 1e-3;
/// Bounds within which every filter works: p_D below 1, and noise whose square is not zero in single precision.
const GREATEST_DETECTION: f64 = 0.999;
const LEAST_RANGE_SIGMA_M: f64 = 1e-3;
const LEAST_BEARING_SIGMA_RAD: f64 = 1e-4;

impl FilterSettings {
    /// Whether the reference has all parts of these settings; it has those after [`Settings::restrict_to_reference`].
    pub fn check_reference_has_all(&self) -> Result<(), String> {
        let forgets = || Some("filter.unconfirmed_weight = 0".to_owned()).filter(|_| self.unconfirmed_weight > 0.0);
        let waits = || Some("filter.births_wait = false".to_owned()).filter(|_| self.births_wait);
        let blind = || Some("filter.proposal = \"blind\"".to_owned()).filter(|_| self.proposal != Proposal::Blind);
        blind().or_else(forgets).or_else(waits).map_or(Ok(()), |needed| {
            Err(format!("the reference is the recursion of the thesis alone; compare with {needed}"))
        })
    }
}

impl Settings {
    /// Default settings for `log`.
    pub fn for_log(log: &Log) -> Self {
        let sensor = sensor(log.simulated, &log.sensor, &log.nominal);
        let measure = sensor.measure();
        // Unstated clutter is taken as sparse: features with a few detections exist, and are remembered.
        let memory = if log.simulated { memory(&sensor) } else { &SPARSE };
        let clutter_over_birth = if log.simulated { memory.clutter_over_birth } else { UNSTATED.clutter_over_birth };
        let births = |sensor: &SensorSettings| {
            if sensor.clutter_per_scan > 0.0 { sensor.clutter_per_scan / clutter_over_birth } else { BIRTHS_PER_SCAN }
        };
        let birth_intensity = births(&sensor) / measure;
        let of = |simulated, unstated| if log.simulated { simulated } else { unstated };
        let filter = FilterSettings {
            particles: if log.simulated { memory.particles } else { UNSTATED.particles },
            samples: SAMPLES,
            birth_intensity,
            resample_threshold: RESAMPLE_THRESHOLD,
            prune_weight: memory.prune_weight,
            unconfirmed_weight: of(memory.unconfirmed_weight, UNSTATED.unconfirmed_weight),
            confirming_detections: memory.confirming_detections,
            confirmed_weight: memory.confirmed_weight,
            merge_distance: of(memory.merge_distance, UNSTATED.merge_distance),
            max_components: MAX_COMPONENTS,
            extraction: memory.extraction,
            extraction_weight: memory.extraction_weight,
            proposal: Proposal::Informed,
            births_wait: false,
            proposal_rounds: PROPOSAL_ROUNDS,
            proposal_sampled_fraction: of(memory.drawn, UNSTATED.drawn),
            proposal_min_responsibility: LEAST_SHARE,
            interval_margin: INTERVAL_MARGIN,
            likelihood: Likelihood::SingleCluster,
        };
        let own_speed = if log.simulated { None } else { speed_mps(&log.odometry) };
        let velocity_sigma_mps =
            own_speed.map_or(MOVING_VELOCITY_SIGMA_MPS, |speed| UNSTATED.mover_speed_share * speed);
        let moving = MovingSettings {
            birth_intensity: 0.0,
            velocity_sigma_mps,
            acceleration_psd: velocity_sigma_mps * velocity_sigma_mps / MOVING_STEADY_S,
            lifetime_s: MOVING_LIFETIME_S,
            spread_max_m: MOVING_SPREAD_MAX_M,
            extraction_weight: MOVING_EXTRACTION_WEIGHT,
        };
        let JointConfig { persistence, occlusion_factor, merge_distance, .. } = JointConfig::<f64>::default();
        let joint = JointSettings {
            visible_s: of(NEVER_S, persistence.visible_s),
            occluded_s: persistence.occluded_s,
            lifetime_s: of(NEVER_S, persistence.lifetime_s),
            occlusion_factor: of(1.0, occlusion_factor),
            merge_distance,
            hypotheses: 1,
        };
        let others = log.others.iter().map(|other| {
            let of = self::sensor(log.simulated, &other.sensor, &other.nominal);
            let birth_factor = births(&of) / of.measure() / birth_intensity;
            (other.name.clone(), SensorSettings { birth_factor, ..of })
        });
        let others = others.collect();
        let sensor_name = log.sensor_name.clone();
        Self {
            filter,
            vehicle: vehicle(log),
            sensor,
            sensor_name,
            others,
            moving,
            joint,
            fixes: fixes(log),
            calibration: None,
        }
    }

    /// Whether one of the log's sensors detects moving objects.
    fn sees_moving_objects(&self, log: &Log) -> bool {
        let way = Way::of(log);
        let mut sensors = log.sensors().zip(self.sensors()).enumerate();
        sensors.any(|(index, ((_, sensor, _), noise))| {
            moving_objects::are_seen(log, &way, index, sensor, noise, &self.moving)
        })
    }

    /// The default settings of a scenario: the recursion of the thesis without extensions, with the thesis's parameters of the
    /// experiment.
    pub fn for_scenario(name: &str, log: &Log) -> Self {
        let mut settings = Self::for_log(log);
        if !is_of_thesis(name) {
            return settings;
        }
        settings.restrict_to_reference();
        if let Some(run) = thesis_run(name) {
            settings.filter.particles = run.particles;
            settings.filter.samples = run.samples;
            settings.filter.resample_threshold = run.resample_threshold;
            settings.set_moving(run.moving);
        }
        settings
    }

    /// Changes default settings for `log` to those for a joint map. Unless the log is simulated, objects may move, and stated
    /// measurement noise has a smaller margin if it is white. If, moreover, its scans are not crowded and the drive loses its
    /// heading, turns have more noise, unless the log states it, and there are several hypotheses of data association; there are
    /// also several, and more births of moving features, if the log shows moving objects.
    pub fn set_for_joint_map(&mut self, log: &Log) {
        if log.simulated {
            return;
        }
        self.set_moving(true);
        let turn_sigma_ratio = if stated_turn(log).is_some() { 0.0 } else { LOST_TURN_SHARE };
        let noise = VehicleSettings { turn_sigma_ratio, ..self.vehicle };
        let is_crowded = near(&self.sensor, detections_per_scan(log)) > CROWDED;
        let is_lost = !is_crowded && loses_heading(log, &noise);
        if is_lost {
            self.joint.hypotheses = HYPOTHESES;
            self.vehicle = noise;
        } else if !is_crowded && self.sees_moving_objects(log) {
            self.joint.hypotheses = HYPOTHESES;
            self.moving.birth_intensity = SEEN_MOVING_BIRTH_SHARE * self.filter.birth_intensity;
        }
        let margins: Vec<_> = log
            .sensors()
            .enumerate()
            .map(|(index, (_, sensor, nominal))| white_margins(log, index, sensor, nominal, &self.vehicle))
            .collect();
        let all_white = margins.iter().flatten().all(Option::is_some);
        if all_white {
            self.vehicle.noise_interval_s = WHITE_INTERVAL_S;
        }
        for (sensor, white) in self.sensors_mut().zip(margins) {
            let least = if all_white { 0.0 } else { UNSTATED.noise_margin };
            let [range, bearing] = white.map(|margin| margin.unwrap_or(least).max(least) / UNSTATED.noise_margin);
            sensor.range_sigma_m = (range * sensor.range_sigma_m).max(LEAST_RANGE_SIGMA_M);
            sensor.range_sigma_ratio = (range * sensor.range_sigma_ratio).min(1.0);
            sensor.bearing_sigma_rad = (bearing * sensor.bearing_sigma_rad).max(LEAST_BEARING_SIGMA_RAD);
        }
        if all_white && !is_lost {
            self.measure_odometry_noise(log);
        }
    }

    /// Changes the standard deviations of odometry that the log states to those that have the measured effect with the settings'
    /// correlation time.
    fn measure_odometry_noise(&mut self, log: &Log) {
        let is_stated = [log.nominal.speed_sigma_mps.is_some(), stated_turn(log).is_some()];
        if is_stated == [false; 2] {
            return;
        }
        let sensors: Vec<_> = self.sensors().collect();
        let sigmas = |index: usize, range_m| {
            let sensor: &SensorSettings = sensors[index];
            [sensor.range_sigma_at(range_m), sensor.bearing_sigma_rad].map(|sigma| sigma / WHITE_MARGIN)
        };
        let times_s = odometry_noise::correlation_times(log, &self.vehicle, sigmas);
        let noise = &mut self.vehicle;
        for ((is_stated, time_s), sigma) in
            is_stated.into_iter().zip(times_s).zip([&mut noise.speed_sigma_mps, &mut noise.turn_sigma])
        {
            if is_stated {
                *sigma *= (time_s / noise.noise_interval_s).sqrt();
            }
        }
    }

    /// Switches off extensions of the recursion of the thesis, which the reference does not have.
    pub fn restrict_to_reference(&mut self) {
        self.filter.proposal = Proposal::Blind;
        self.filter.unconfirmed_weight = 0.0;
        self.filter.confirmed_weight = 0.0;
        self.filter.extraction = Extraction::Heaviest;
        self.filter.extraction_weight = 0.0;
        self.filter.births_wait = false;
    }

    /// Switches moving features on or off; births of moving features that are on already stay as frequent as they are.
    pub fn set_moving(&mut self, moving: bool) {
        if !moving {
            self.moving.birth_intensity = 0.0;
        } else if self.moving.birth_intensity == 0.0 {
            self.moving.birth_intensity = MOVING_BIRTH_SHARE * self.filter.birth_intensity;
        }
    }
}

/// The rules by the expected number of false measurements in a scan within three standard deviations of a feature.
fn memory(sensor: &SensorSettings) -> &'static Memory {
    if near(sensor, sensor.clutter_per_scan) < SPARSE_CLUTTER { &SPARSE } else { &DENSE }
}

/// The number of `measurements` of a scan that are expected within three standard deviations of a feature, if they are uniform in the
/// view: 9π σ_r σ_b times their density, with σ_r in the middle of the view.
fn near(sensor: &SensorSettings, measurements: f64) -> f64 {
    let density = measurements / sensor.measure();
    let range_sigma_m = sensor.range_sigma_at(0.5 * (sensor.range_min_m + sensor.range_max_m));
    density * 9.0 * PI * range_sigma_m * sensor.bearing_sigma_rad
}

/// Mean number of detections of the scans that have any; 0 without detections.
fn detections_per_scan(log: &Log) -> f64 {
    let detections = || log.scans.iter().map(|scan| scan.detections.len()).filter(|&count| count > 0);
    detections().sum::<usize>() as f64 / detections().count().max(1) as f64
}

/// Root mean square of the vehicle's speed over the time of its odometry, m/s; `None` if it does not move. Implausible rows do
/// not count: one of them would make moving features too fast.
fn speed_mps(odometry: &[Odometry]) -> Option<f64> {
    let (mut way, mut time) = (0.0, 0.0);
    for rows in odometry.windows(2).filter(|rows| rows[0].speed_mps().abs() <= FASTEST_MPS) {
        let dt_s = rows[1].t_s - rows[0].t_s;
        way += rows[0].speed_mps() * rows[0].speed_mps() * dt_s;
        time += dt_s;
    }
    Some(way / time).filter(|square| square.is_finite()).map(f64::sqrt).filter(|&speed| speed >= LEAST_SPEED_MPS)
}

/// Factors for the standard deviations of range and bearing of the sensor with this index, where its noise is white: as stated, or
/// more. `None` where it is not, or less than stated.
fn white_margins(
    log: &Log,
    index: usize,
    sensor: &Sensor,
    nominal: &Nominal,
    vehicle: &VehicleSettings,
) -> [Option<f64>; 2] {
    let is_stated = nominal.range_sigma_m.is_some() && nominal.bearing_sigma_rad.is_some();
    let Some(WhitePart { shares, of_odometry }) = WhitePart::of(log, index, sensor, nominal, vehicle) else {
        return [None; 2];
    };
    std::array::from_fn(|k| {
        let of_sensor = shares[k] - of_odometry[k];
        if of_sensor > AS_STATED {
            Some(WHITE_MARGIN * of_sensor.sqrt())
        } else {
            (is_stated && WHITE.contains(&shares[k])).then_some(WHITE_MARGIN)
        }
    })
}

/// The noise that the log states, or the default: constant and relative part.
fn vehicle(log: &Log) -> VehicleSettings {
    let (nominal, wheeled) = (&log.nominal, ControlNoise::<f64>::wheeled());
    let stated_turn = stated_turn(log);
    // Stated noise is white, with independent values in each row, only if it was simulated so.
    let white = log.simulated && nominal.speed_sigma_mps.is_some() && stated_turn.is_some();
    let share = |stated: Option<f64>, share| if stated.is_some() { 0.0 } else { share };
    VehicleSettings {
        speed_sigma_mps: nominal.speed_sigma_mps.unwrap_or(wheeled.speed_sigma_mps),
        speed_sigma_ratio: share(nominal.speed_sigma_mps, wheeled.speed_sigma_ratio),
        turn_sigma: stated_turn.unwrap_or(wheeled.turn_sigma),
        turn_sigma_ratio: share(stated_turn, wheeled.turn_sigma_ratio),
        noise_interval_s: if white { 0.0 } else { ControlNoise::<f64>::wheeled().interval_s },
    }
}

/// The noise of the second control that the log states.
pub(super) fn stated_turn(log: &Log) -> Option<f64> {
    match log.vehicle {
        Vehicle::Ackermann { .. } => log.nominal.steering_sigma_rad,
        Vehicle::Unicycle | Vehicle::UnicycleArc | Vehicle::Holonomic => log.nominal.rate_sigma_radps,
    }
}

/// Whether the heading's error grows so much in a time without detections and fixes that the gate of data association is wider than
/// the view: then the next detection may be of any landmark near the view.
fn loses_heading(log: &Log, noise: &VehicleSettings) -> bool {
    let view_rad = |sensor: &Sensor| sensor.bearing_max_rad - sensor.bearing_min_rad;
    let half_view_rad = 0.5 * log.sensors().map(|(_, sensor, _)| view_rad(sensor)).fold(0.0, f64::max);
    let limit = half_view_rad * half_view_rad / JointConfig::<f64>::default().gate;
    let detected = log.scans.iter().filter(|scan| !scan.detections.is_empty()).map(|scan| scan.t_s);
    // Before the first detection there is no map.
    let Some(mut last_s) = detected.clone().next() else { return false };
    let fixed = log.fixes.iter().map(|fix| (fix.t_s, false)).filter(|&(t_s, _)| t_s > last_s);
    let mut known: Vec<_> = detected.skip(1).map(|t_s| (t_s, true)).chain(fixed).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut known = known.into_iter().peekable();
    // Integral of the variance of the turn rate since the last detection or fix.
    let mut spread = 0.0;
    for rows in log.odometry.windows(2) {
        let until_s = rows[1].t_s;
        if log.vehicle.implausible(rows[0].control, until_s - rows[0].t_s).is_some() {
            continue;
        }
        let variance = turn_rate_variance(log.vehicle, rows[0].control, noise);
        let mut from_s = rows[0].t_s.max(last_s);
        while let Some((t_s, is_detection)) = known.next_if(|&(t_s, _)| t_s <= until_s) {
            spread += variance * (t_s - from_s).max(0.0);
            if is_detection && spread * noise.noise_interval_s.min(t_s - last_s) > limit {
                return true;
            }
            (spread, last_s, from_s) = (0.0, t_s, t_s.max(from_s));
        }
        spread += variance * (until_s - from_s).max(0.0);
    }
    false
}

/// Variance of the vehicle's turn rate by the noise of the second control, rad²/s².
pub(super) fn turn_rate_variance(vehicle: Vehicle, [speed, turn, left]: [f64; 3], noise: &VehicleSettings) -> f64 {
    const STEP: f64 = 1e-3;
    let heading = |turn| vehicle.step([0.0; 3], [speed, turn, left], STEP)[2];
    let by_turn = wrap(heading(turn + STEP) - heading(turn - STEP)) / (2.0 * STEP * STEP);
    let share = noise.turn_sigma_ratio * turn;
    by_turn * by_turn * (noise.turn_sigma * noise.turn_sigma + share * share)
}

/// The noise of fixes, if there are any: as stated, or with the margin of a data sheet.
fn fixes(log: &Log) -> Option<FixNoise> {
    let FixNoise { position_sigma_m, heading_sigma_rad, .. } = log.fix_noise;
    let margin = if log.simulated { 1.0 } else { UNSTATED.noise_margin };
    let with_margin = |sigma: Option<f64>| sigma.map(|sigma| margin * sigma);
    (!log.fixes.is_empty()).then(|| FixNoise {
        position_sigma_m: with_margin(position_sigma_m),
        heading_sigma_rad: with_margin(heading_sigma_rad),
        gate: Some(log.fix_noise.gate()),
        patience_s: Some(log.fix_noise.rule().patience_s),
        ..log.fix_noise
    })
}

fn sensor(simulated: bool, window: &Sensor, nominal: &Nominal) -> SensorSettings {
    let margin = if simulated { 1.0 } else { UNSTATED.noise_margin };
    let [range, bearing] = nominal.sigmas(window);
    let range_sigma_m = (margin * range).max(LEAST_RANGE_SIGMA_M);
    let bearing_sigma_rad = (margin * bearing).max(LEAST_BEARING_SIGMA_RAD);
    let edge_sigmas = if simulated { EDGE_SIGMAS } else { UNSTATED.edge_sigmas };
    let stated = nominal.detection_probability.map(|detection| detection.min(GREATEST_DETECTION));
    let detection = stated.unwrap_or(UNSTATED.detection);
    let all_around = window.bearing_max_rad - window.bearing_min_rad > 2.0 * PI - CIRCLE_SLACK_RAD;
    let (bearing_min_rad, bearing_max_rad) =
        if all_around { (-PI, PI) } else { (window.bearing_min_rad, window.bearing_max_rad) };
    SensorSettings {
        range_sigma_m,
        range_sigma_ratio: (margin * nominal.range_sigma_ratio).min(1.0),
        bearing_sigma_rad,
        range_min_m: window.range_min_m,
        range_max_m: window.range_max_m,
        range_edge_m: edge_sigmas * range_sigma_m,
        bearing_min_rad,
        bearing_max_rad,
        bearing_edge_rad: if all_around { 0.0 } else { edge_sigmas * bearing_sigma_rad },
        detection_near: detection,
        detection_far: detection,
        clutter_per_scan: nominal.clutter_per_scan.unwrap_or(UNSTATED.clutter_per_scan),
        forward_m: window.mounting.forward_m,
        left_m: window.mounting.left_m,
        yaw_rad: window.mounting.yaw_rad,
        birth_factor: 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_log::dimensions::PoseFix;
    use scphd_log::log::{Fix, Scan};
    use scphd_worlds::scenario;
    use scphd_worlds::scenario::worlds::{self, Misbehaviour};

    #[test]
    fn the_stated_noise_of_a_simulation_is_used() {
        let log = scenario::survey(1);
        let settings = Settings::for_log(&log);
        let sensor = &settings.sensor;
        assert_eq!((settings.vehicle.speed_sigma_mps, settings.vehicle.noise_interval_s), (1.0, 0.0));
        assert_eq!(Some(settings.vehicle.turn_sigma), log.nominal.steering_sigma_rad);
        assert_eq!((sensor.range_sigma_m, sensor.clutter_per_scan), (0.25, 20.0));
        assert_eq!((sensor.detection_near, sensor.detection_far), (0.95, 0.95));
        assert_eq!((sensor.bearing_edge_rad, sensor.range_edge_m), (0.0, 0.25));
        // κ = 20 w_b, and one birth a scan from 20 false measurements.
        assert!((settings.filter.birth_intensity * 15.0 * 2.0 * PI - 1.0).abs() < 1e-12);
        assert_eq!(settings.check(), Ok(()));
    }

    #[test]
    fn with_sparse_clutter_confirmed_features_are_remembered() {
        let mut log = scenario::survey(1);
        let dense = Settings::for_log(&log).filter;
        assert_eq!((dense.confirmed_weight, dense.merge_distance, dense.extraction), (0.0, 4.0, Extraction::Peaks));
        // κ 9π σ_r σ_b of 20 false measurements a scan is 0.0131.
        log.nominal.clutter_per_scan = Some(20.0 * 0.0049 / 0.0131);
        let sparse = Settings::for_log(&log).filter;
        assert_eq!((sparse.confirming_detections, sparse.extraction), (3.0, Extraction::Confirmed));
        assert!(sparse.extraction_weight < sparse.confirmed_weight);
        let mut thesis = Settings::for_log(&log);
        thesis.restrict_to_reference();
        assert_eq!((thesis.filter.confirmed_weight, thesis.filter.extraction_weight), (0.0, 0.0));
    }

    #[test]
    fn a_data_sheet_has_a_margin_for_any_name_and_vehicle() {
        let mut log = scenario::survey(1);
        log.simulated = false;
        log.nominal = Nominal { range_sigma_m: Some(0.4), range_sigma_ratio: 0.02, ..Default::default() };
        (log.sensor.bearing_min_rad, log.sensor.bearing_max_rad) = (-1.0, 1.0);
        let settings = Settings::for_log(&log);
        assert!((settings.sensor.range_sigma_m - 0.6).abs() < 1e-12);
        assert!((settings.sensor.range_sigma_ratio - 0.03).abs() < 1e-12);
        assert!((settings.sensor.bearing_sigma_rad - 0.03).abs() < 1e-12);
        assert_eq!((settings.sensor.range_max_m, settings.filter.particles), (log.sensor.range_max_m, 16));
        assert_eq!((settings.vehicle.noise_interval_s, settings.vehicle.speed_sigma_ratio), (0.5, 0.1));
        assert_eq!(settings.check(), Ok(()));
        log.name = "another".into();
        assert_eq!(Settings::for_log(&log), settings);
        log.vehicle = Vehicle::Unicycle;
        assert_eq!(Settings::for_log(&log), settings);
        // Slightly less noise makes a small difference, not another filter.
        log.nominal.range_sigma_m = Some(0.1);
        let mut finer = Settings::for_log(&log);
        assert!((finer.sensor.range_sigma_m - 0.15).abs() < 1e-12);
        (finer.sensor.range_sigma_m, finer.sensor.range_edge_m) =
            (settings.sensor.range_sigma_m, settings.sensor.range_edge_m);
        assert_eq!(finer, settings);
    }

    /// A robot meets robots, a car meets cars.
    #[test]
    fn moving_features_are_about_as_fast_as_the_vehicle() {
        let mut log = scenario::survey(1);
        let walkers = |moving: MovingSettings| {
            assert_eq!((moving.velocity_sigma_mps, moving.acceleration_psd), (1.0, 0.1));
        };
        walkers(Settings::for_log(&log).moving);
        log.simulated = false;
        for row in &mut log.odometry {
            row.control[0] = -0.06;
        }
        let moving = Settings::for_log(&log).moving;
        assert!((moving.velocity_sigma_mps - 0.03).abs() < 1e-12 && (moving.acceleration_psd - 9e-5).abs() < 1e-12);
        assert_eq!(Settings::for_log(&log).check(), Ok(()));
        // A single implausible row does not count.
        log.odometry[3].control[0] = 1e5;
        let spiked = Settings::for_log(&log);
        assert!((spiked.moving.velocity_sigma_mps - 0.03).abs() < 1e-12 && spiked.check() == Ok(()));
        log.odometry.truncate(1);
        walkers(Settings::for_log(&log).moving);
    }

    #[test]
    fn stated_p_d_clutter_and_odometry_noise_of_a_real_log_are_used() {
        let mut log = scenario::survey(1);
        log.simulated = false;
        let settings = Settings::for_log(&log);
        assert_eq!((settings.sensor.detection_near, settings.sensor.clutter_per_scan), (0.95, 20.0));
        assert_eq!((settings.vehicle.speed_sigma_mps, settings.vehicle.speed_sigma_ratio), (1.0, 0.0));
        // Its errors are nevertheless correlated in time: only a simulation states that they are white.
        assert_eq!(settings.vehicle.noise_interval_s, 0.5);
    }

    #[test]
    fn of_odometry_only_stated_noise_is_measured() {
        let mut log = worlds::misbehaving(3, Misbehaviour::NONE);
        let noise = |log: &Log| {
            let mut settings = Settings::for_log(log);
            settings.set_for_joint_map(log);
            assert_eq!(settings.vehicle.noise_interval_s, WHITE_INTERVAL_S);
            [settings.vehicle.speed_sigma_mps, settings.vehicle.turn_sigma]
        };
        let unstated = noise(&log);
        log.nominal.speed_sigma_mps = Some(0.02 * log.sensor.range_max_m);
        let [speed, turn] = noise(&log);
        assert!(speed < 0.5 * 0.02 * log.sensor.range_max_m, "{speed}");
        assert_eq!(turn, unstated[1]);
        // Nor if the noise of the sensor is not white.
        log.nominal.range_sigma_m = log.nominal.range_sigma_m.map(|sigma| 3.0 * sigma);
        let mut settings = Settings::for_log(&log);
        settings.set_for_joint_map(&log);
        assert_eq!(settings.vehicle.speed_sigma_mps, 0.02 * log.sensor.range_max_m);
    }

    #[test]
    fn a_recorded_drive_has_tracks_and_one_that_loses_its_heading_also_hypotheses_and_more_noise_of_turns() {
        let mut log = scenario::survey(1);
        (log.simulated, log.nominal) = (false, Nominal::default());
        (log.sensor.bearing_min_rad, log.sensor.bearing_max_rad) = (-0.4, 0.4);
        log.scans.iter_mut().for_each(|scan| scan.detections.truncate(2));
        // The settings, where they differ from those of every recorded drive.
        let differs = |log: &Log| {
            let (mut usual, mut settings) = (Settings::for_log(log), Settings::for_log(log));
            settings.set_for_joint_map(log);
            assert_eq!(settings.check(), Ok(()));
            usual.set_moving(!log.simulated);
            // The noise is measured.
            usual.sensor = settings.sensor.clone();
            (settings != usual).then_some(settings)
        };
        assert_eq!(differs(&log), None);
        let back = log.scans.len() / 2;
        log.scans[1..back].iter_mut().for_each(|scan| scan.detections.clear());
        let lost = differs(&log).unwrap();
        assert_eq!((lost.vehicle.turn_sigma_ratio, lost.joint.hypotheses), (0.3, 8));
        assert_eq!(lost.moving.birth_intensity, 0.5 * lost.filter.birth_intensity);
        assert!(Settings::for_log(&log).moving.birth_intensity == 0.0);
        // After the last detection nothing returns, and before the first there is nothing to lose.
        for scans in [back..log.scans.len(), 0..1] {
            let mut at_an_end = log.clone();
            at_an_end.scans[scans].iter_mut().for_each(|scan| scan.detections.clear());
            assert_eq!(differs(&at_an_end), None);
        }
        // Fixes limit the error of the heading as long as there are any.
        let mut with_fixes = log.clone();
        let fix = |scan: &Scan| Fix { t_s: scan.t_s, measured: PoseFix::Heading(0.0) };
        with_fixes.fixes = log.scans.iter().map(fix).collect();
        assert_eq!(differs(&with_fixes), None);
        with_fixes.fixes.truncate(back / 4);
        assert_eq!(differs(&with_fixes).unwrap().joint.hypotheses, 8);
        // A wide view has landmarks on every side.
        let mut wide = log.clone();
        (wide.sensor.bearing_min_rad, wide.sensor.bearing_max_rad) = (-PI, PI);
        assert_eq!(differs(&wide), None);
        let mut crowded = log.clone();
        crowded.scans[back..].iter_mut().for_each(|scan| scan.detections = vec![[5.0, 0.0]; 100]);
        assert_eq!(differs(&crowded), None);
        // Stated noise is used.
        let mut stated = log.clone();
        stated.nominal.steering_sigma_rad = Some(1e-4);
        assert_eq!(differs(&stated), None);
        stated.nominal.steering_sigma_rad = Some(0.2);
        assert_eq!(differs(&stated).unwrap().vehicle.turn_sigma_ratio, 0.0);
        log.simulated = true;
        assert_eq!(differs(&log), None);
    }

    #[test]
    fn white_stated_noise_has_a_smaller_margin_in_a_joint_map() {
        let white = worlds::world(worlds::Kind::DataSheet, 900_000);
        let joint = |log: &Log| {
            let mut settings = Settings::for_log(log);
            settings.set_for_joint_map(log);
            assert_eq!(settings.check(), Ok(()));
            settings
        };
        let margins = |log: &Log| {
            let (Settings { sensor, vehicle, .. }, nominal) = (joint(log), log.nominal.sigmas(&log.sensor));
            let ratios = [sensor.range_sigma_m / nominal[0], sensor.bearing_sigma_rad / nominal[1]];
            (ratios.map(|ratio| (1e9 * ratio).round() / 1e9), vehicle.noise_interval_s)
        };
        assert_eq!(margins(&white), ([1.1; 2], 0.25));
        // The edges of the view are not of the noise alone.
        assert_eq!(joint(&white).sensor.range_edge_m, Settings::for_log(&white).sensor.range_edge_m);
        // A data sheet that states half the noise, and one that states twice the noise, or only one of both.
        let wrong = |factor: f64| {
            let mut wrong = white.clone();
            wrong.nominal.bearing_sigma_rad = wrong.nominal.bearing_sigma_rad.map(|sigma| factor * sigma);
            margins(&wrong)
        };
        let ([range, bearing], interval_s) = wrong(0.5);
        assert!((range, interval_s) == (1.1, 0.25) && (2.0..2.6).contains(&bearing), "{range} {bearing} {interval_s}");
        assert_eq!(wrong(2.0), ([1.5; 2], 0.5));
        let mut unstated = white;
        unstated.nominal.bearing_sigma_rad = None;
        assert_eq!(margins(&unstated), ([1.5; 2], 0.5));
    }

    #[test]
    fn extreme_values_are_within_the_limits() {
        let mut log = scenario::survey(1);
        log.nominal = Nominal {
            range_sigma_m: Some(0.0),
            range_sigma_ratio: 1.0,
            bearing_sigma_rad: Some(0.0),
            speed_sigma_mps: Some(0.0),
            steering_sigma_rad: Some(0.0),
            rate_sigma_radps: None,
            detection_probability: Some(1.0),
            clutter_per_scan: Some(0.0),
        };
        (log.sensor.bearing_min_rad, log.sensor.bearing_max_rad) = (-PI + 1e-4, PI - 1e-4);
        let settings = Settings::for_log(&log);
        assert_eq!(settings.check(), Ok(()));
        assert!(settings.filter.birth_intensity > 0.0);
        assert_eq!(settings.sensor.bearing_max_rad, PI);
    }
}

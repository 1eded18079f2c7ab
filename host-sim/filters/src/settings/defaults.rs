//! Settings that suit a log, from what its head says of vehicle, sensor and noise; never from its name.
//!
//! What is stated is used as stated. What is not comes from one table of physical figures ([`UNSTATED`]), the same for every
//! vehicle, sensor and place. Its figures are round; they were chosen on the random worlds of the seeds 100 to 199
//! (`scenario::worlds`), and no recorded log had a say. A log that says it is simulated states its noise exactly; a data
//! sheet states the white part of it alone, so that it is taken with a margin.

use super::{
    Extraction, FilterSettings, JointSettings, Likelihood, MovingSettings, Proposal, SensorSettings, Settings,
    VehicleSettings,
};
use scphd::JointConfig;
use scphd::models::ControlNoise;
use scphd_log::log::{FixNoise, Log, Nominal, Odometry, Sensor, Vehicle};
use scphd_log::vehicle::FASTEST_MPS;
use scphd_worlds::scenario::{is_of_thesis, thesis_run};
use std::f64::consts::PI;

/// Samples M of every particle a prediction: one, because drawing more is paid for as more particles would be.
const SAMPLES: usize = 1;
/// Resample below this N_eff / N: section 5.3.1, and most of the literature.
const RESAMPLE_THRESHOLD: f64 = 0.5;
/// Where clutter is so sparse that fewer false measurements than this fall within three standard deviations of a feature in
/// a scan, the same feature is not confirmed by chance, and what has been seen a few times is there.
const SPARSE_CLUTTER: f64 = 0.005;

/// What becomes of features of a simulation by how often they have been seen.
struct Memory {
    particles: usize,
    /// κ / w_b. A measurement that nothing explains starts as a feature of weight 1/(1 + κ/w_b): the next detection near
    /// it makes it a likely feature (a Gaussian's peak is far above κ), a lone false measurement dies out.
    clutter_over_birth: f64,
    prune_weight: f64,
    confirming_detections: f64,
    unconfirmed_weight: f64,
    confirmed_weight: f64,
    merge_distance: f64,
    extraction: Extraction,
    extraction_weight: f64,
    /// Share of the informed proposal's covariance that is drawn.
    drawn: f64,
}

/// Dense clutter: weights alone tell. A component is dropped at about what a false measurement leaves behind after one miss (at
/// p_D = 0.95): a lighter one says less than the next measurement does, and they were most of the map. What has been seen but
/// once and leaves the view lighter than half a feature was clutter; components within two standard deviations are one.
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

/// Sparse clutter: what leaves the view and is not better known than from three measurements is forgotten, whatever it weighs;
/// what is, stays, and is found again from a fifth of a feature. Features are far apart for their uncertainty, so that what lies
/// within four standard deviations of one is the same, seen from errant poses. Associations leave little to draw for: the mean
/// of the proposal is better than a sample of it, and one particle is as good as many.
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

/// w_m / w_b: most of what turns up stands still.
const MOVING_BIRTH_SHARE: f64 = 0.5;
/// Of a simulation, or where the vehicle stands: walking pace and somewhat more.
const MOVING_VELOCITY_SIGMA_MPS: f64 = 1.0;
/// What moves has become another speed after this long, s: with walkers, half a metre a second more or less after three seconds.
const MOVING_STEADY_S: f64 = 10.0;
/// p_S = 0.999 a tenth of a second.
const MOVING_LIFETIME_S: f64 = 100.0;
/// Slower than this, m/s, a vehicle says nothing of how fast others are.
const LEAST_SPEED_MPS: f64 = 0.01;
/// What has moved out of view for longer than this takes is forgotten, m.
const MOVING_SPREAD_MAX_M: f64 = 1.5;
/// What clutter begets is told from what moves by its weight.
const MOVING_EXTRACTION_WEIGHT: f64 = 0.4;
/// Linearisations of the informed proposal.
const PROPOSAL_ROUNDS: usize = 3;
/// A component that explains less of a measurement than this does not steer the proposal.
const LEAST_SHARE: f64 = 0.02;
/// A mixture's particles do not know what the features of one map have in common with the pose: odometry errors count for longer there.
const INTERVAL_MARGIN: f64 = 2.0;
/// A time that no log lasts for, s: in a simulation nothing hides a landmark or takes it away.
const NEVER_S: f64 = 1e9;
/// Components in view. No view of the published logs needs half of it; it bounds the time of a scan gone wrong.
const MAX_COMPONENTS: usize = 1000;

/// Births a scan where there is no clutter for them to be measured against.
const BIRTHS_PER_SCAN: f64 = 0.1;

/// What is taken for granted where a log does not say.
struct Unstated {
    /// Noise over what a data sheet states: it speaks of one good measurement. The width of a trunk, a time stamp, a scan that
    /// takes a while, one return in fifty that is far off, and what features of one map have in common and do not know of
    /// each other come on top.
    noise_margin: f64,
    /// p_D. Taking it too low costs little: false features live longer. Taking it too high deletes what is hidden for a moment.
    detection: f64,
    /// Half width of the soft edges of the view in standard deviations: a data sheet's view ends less sharply than it says.
    edge_sigmas: f64,
    /// What leaves the view lighter than this and is not confirmed was most likely clutter, and is forgotten.
    unconfirmed_weight: f64,
    /// False measurements a scan.
    clutter_per_scan: f64,
    /// κ / w_b.
    clutter_over_birth: f64,
    /// Components within three standard deviations are one.
    merge_distance: f64,
    /// Standard deviation of the velocity of what moves, as a share of the vehicle's own speed: robots move among robots, cars among cars.
    /// One coordinate of a velocity is less than all of it, and some of what moves is slow.
    mover_speed_share: f64,
    /// Enough for a few hypotheses of the heading; more bring little (docs/studies.md).
    particles: usize,
    /// Share of the informed proposal's covariance that is drawn.
    drawn: f64,
}

/// [`Unstated::noise_margin`].
pub(super) const DATA_SHEET_MARGIN: f64 = UNSTATED.noise_margin;

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

/// Half width of a soft edge in standard deviations of its coordinate: noise and pose decide whether a feature this near
/// to the rim is seen. The wider the edge, the more weight a feature loses every time it leaves the view.
const EDGE_SIGMAS: f64 = 1.0;
/// A window this near the full circle is one, rad: logs give π with a few digits.
const CIRCLE_SLACK_RAD: f64 = 1e-3;
/// Bounds within which every filter works: no certain detection, no noise so small that its square vanishes.
const GREATEST_DETECTION: f64 = 0.999;
const LEAST_RANGE_SIGMA_M: f64 = 1e-3;
const LEAST_BEARING_SIGMA_RAD: f64 = 1e-4;

impl FilterSettings {
    /// Whether the reference has all that is asked for; what [`Settings::restrict_to_reference`] leaves, it has.
    ///
    /// # Errors
    /// Says what would have to be otherwise.
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
    /// Settings that suit `log`.
    #[must_use]
    pub fn for_log(log: &Log) -> Self {
        let sensor = sensor(log.simulated, &log.sensor, &log.nominal);
        let measure = sensor.measure();
        // Without a word on clutter, it is sparse: what has been seen a few times is there, and is remembered.
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

    /// The settings a scenario is run with unless told otherwise: the recursion of the thesis and nothing beyond it, with what the
    /// thesis says about its experiment.
    #[must_use]
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

    /// Leaves out what goes beyond the recursion of the thesis, and so has no counterpart in the reference.
    pub fn restrict_to_reference(&mut self) {
        self.filter.proposal = Proposal::Blind;
        self.filter.unconfirmed_weight = 0.0;
        self.filter.confirmed_weight = 0.0;
        self.filter.extraction = Extraction::Heaviest;
        self.filter.extraction_weight = 0.0;
        self.filter.births_wait = false;
    }

    /// Lets features move, or takes them all for static.
    pub fn set_moving(&mut self, moving: bool) {
        self.moving.birth_intensity = if moving { MOVING_BIRTH_SHARE * self.filter.birth_intensity } else { 0.0 };
    }
}

/// By how many false measurements a scan has near a feature, within three standard deviations: κ 9π σ_r σ_b.
fn memory(sensor: &SensorSettings) -> &'static Memory {
    let density = sensor.clutter_per_scan / sensor.measure();
    let near = density * 9.0 * PI * sensor.range_sigma_m * sensor.bearing_sigma_rad;
    if near < SPARSE_CLUTTER { &SPARSE } else { &DENSE }
}

/// Root mean square of the vehicle's own speed over the time of its odometry, m/s, if it moves at all. Rows that no vehicle drives
/// do not count: one of them would make all that moves faster than anything that does.
fn speed_mps(odometry: &[Odometry]) -> Option<f64> {
    let (mut way, mut time) = (0.0, 0.0);
    for rows in odometry.windows(2).filter(|rows| rows[0].speed_mps().abs() <= FASTEST_MPS) {
        let dt_s = rows[1].t_s - rows[0].t_s;
        way += rows[0].speed_mps() * rows[0].speed_mps() * dt_s;
        time += dt_s;
    }
    Some(way / time).filter(|square| square.is_finite()).map(f64::sqrt).filter(|&speed| speed >= LEAST_SPEED_MPS)
}

/// The noise that the log states, or what is taken for granted where it does not: constant and share.
fn vehicle(log: &Log) -> VehicleSettings {
    let (nominal, wheeled) = (&log.nominal, ControlNoise::<f64>::wheeled());
    let stated_turn = match log.vehicle {
        Vehicle::Ackermann { .. } => nominal.steering_sigma_rad,
        Vehicle::Unicycle | Vehicle::UnicycleArc | Vehicle::Holonomic => nominal.rate_sigma_radps,
    };
    // Stated noise is white, one draw a row, only where it was simulated so.
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

/// How fixes are taken, where there are some: as stated, or with the margin of any data sheet.
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
    use scphd_worlds::scenario;

    #[test]
    fn a_simulation_is_taken_at_its_word() {
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
    fn sparse_clutter_leaves_features_that_are_remembered() {
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
    fn a_data_sheet_is_taken_with_a_margin_whatever_the_name_and_the_vehicle() {
        let mut log = scenario::survey(1);
        log.simulated = false;
        log.nominal = Nominal { range_sigma_m: Some(0.4), ..Default::default() };
        (log.sensor.bearing_min_rad, log.sensor.bearing_max_rad) = (-1.0, 1.0);
        let settings = Settings::for_log(&log);
        assert!((settings.sensor.range_sigma_m - 0.6).abs() < 1e-12);
        assert!((settings.sensor.bearing_sigma_rad - 0.03).abs() < 1e-12);
        assert_eq!((settings.sensor.range_max_m, settings.filter.particles), (log.sensor.range_max_m, 16));
        assert_eq!((settings.vehicle.noise_interval_s, settings.vehicle.speed_sigma_ratio), (0.5, 0.1));
        assert_eq!(settings.check(), Ok(()));
        log.name = "another".into();
        assert_eq!(Settings::for_log(&log), settings);
        log.vehicle = Vehicle::Unicycle;
        assert_eq!(Settings::for_log(&log), settings);
        // A little less noise makes a little difference, not another filter.
        log.nominal.range_sigma_m = Some(0.1);
        let mut finer = Settings::for_log(&log);
        assert!((finer.sensor.range_sigma_m - 0.15).abs() < 1e-12);
        (finer.sensor.range_sigma_m, finer.sensor.range_edge_m) =
            (settings.sensor.range_sigma_m, settings.sensor.range_edge_m);
        assert_eq!(finer, settings);
    }

    /// Robots move among robots, cars among cars.
    #[test]
    fn what_moves_is_about_as_fast_as_the_vehicle() {
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
        // One absurd row does not count.
        log.odometry[3].control[0] = 1e5;
        let spiked = Settings::for_log(&log);
        assert!((spiked.moving.velocity_sigma_mps - 0.03).abs() < 1e-12 && spiked.check() == Ok(()));
        log.odometry.truncate(1);
        walkers(Settings::for_log(&log).moving);
    }

    #[test]
    fn what_a_real_log_states_of_p_d_clutter_and_odometry_is_used_as_stated() {
        let mut log = scenario::survey(1);
        log.simulated = false;
        let settings = Settings::for_log(&log);
        assert_eq!((settings.sensor.detection_near, settings.sensor.clutter_per_scan), (0.95, 20.0));
        assert_eq!((settings.vehicle.speed_sigma_mps, settings.vehicle.speed_sigma_ratio), (1.0, 0.0));
        // Its errors last all the same: that they are white is what a simulation says.
        assert_eq!(settings.vehicle.noise_interval_s, 0.5);
    }

    #[test]
    fn extremes_stay_within_the_limits() {
        let mut log = scenario::survey(1);
        log.nominal = Nominal {
            range_sigma_m: Some(0.0),
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

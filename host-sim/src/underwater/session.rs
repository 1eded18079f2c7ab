//! One filter over one whole underwater log: what it estimated, how well, how fast.

use super::log::{Instruments, Log};
use super::record::{FrameRecord, MapFeature, Record, distance, position};
use super::settings::Settings;
use super::slam::{Slam, Transparent, core_filter};
use super::timeline::{Step, Timeline};
use super::truth::Seen;
use crate::angle::wrap;
use crate::monte_carlo::{Curve, Job, RunResult, Series};
use crate::output::json::Summary;
use crate::score::cutoff::Cutoff;
use crate::score::moving::median;
use crate::score::{gospa, ospa};
use crate::session::{Filter, GOSPA, OSPA, SessionError, percentile, with_roomy_stack};
use crate::slam::Refusal;
use crate::stream::underwater_models;
use nalgebra::Vector3;
use scphd::{AuvControl, DeadReckoning, Health, Navigator};
use scphd_stream::Helm;
use std::time::Instant;

/// A map of hundreds of features is compared with the truth at every so many frames only.
const FRAMES_A_MAP_ERROR: usize = 200;
/// A row of the truth holds for this long, s.
const TRUTH_WITHIN_S: f64 = 0.06;

/// What a session leaves behind.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    /// Every frame and the final map.
    pub record: Record,
    /// The figures of the run.
    pub summary: Summary,
    /// In how many frames the filter reported each condition.
    pub health: Vec<(Health, usize)>,
}

/// Runs `filter` over `log`, in a thread with a stack that has room for any state; `progress` is told the number of
/// frames done after each.
///
/// # Errors
/// The filter refused the settings or a step.
pub fn run(
    log: &Log,
    settings: &Settings,
    filter: Filter,
    seed: u64,
    progress: &mut (dyn FnMut(usize) + Send),
) -> Result<Session, SessionError> {
    let session = || {
        let mut slam = start(log, settings, filter, seed).map_err(SessionError::Start)?;
        let (record, health) = drive(log, settings, &mut *slam, progress)?;
        let summary = summary(log, settings, filter, seed, &record, &mut *slam);
        Ok(Session { record, summary, health })
    };
    with_roomy_stack(session).map_err(SessionError::Thread)?
}

fn start(log: &Log, settings: &Settings, filter: Filter, seed: u64) -> Result<Box<dyn Transparent>, Refusal> {
    match filter {
        Filter::Core(precision) => core_filter(log, settings, precision, seed),
        Filter::Reference => Err(Refusal("in space the reference runs in lockstep only: scphd-sim compare".into())),
    }
}

/// The small filters beside the particles, and how far the log has been read.
#[derive(Debug)]
pub struct Pilot<'a> {
    timeline: Timeline<'a>,
    /// The last row taken in.
    row: Option<&'a Instruments>,
    navigator: Navigator<f64>,
    reckoning: DeadReckoning<f64>,
}

impl<'a> Pilot<'a> {
    /// At the first row of the instruments.
    ///
    /// # Errors
    /// The noise is out of range, or there are no instruments.
    pub fn new(log: &'a Log, settings: &Settings) -> Result<Self, Refusal> {
        let models = underwater_models(log, settings)?;
        let refused = |error: scphd::ModelError| Refusal(error.to_string());
        Ok(Self {
            timeline: Timeline::new(log, settings.vehicle.yaw_rate_sigma_radps),
            row: None,
            navigator: models.navigator().map_err(refused)?,
            reckoning: DeadReckoning::new(models.velocity_noise(), Vector3::from(models.start_m)).map_err(refused)?,
        })
    }

    /// The steps from here to `t_s`: up to every row of the instruments by then, and from the last one on.
    ///
    /// # Errors
    /// The instruments say what is not finite.
    pub fn steps_to(&mut self, t_s: f64) -> Result<Vec<(AuvControl<f64>, f64)>, Refusal> {
        let mut controls = Vec::new();
        for Step { navigation, row } in self.timeline.steps_to(t_s) {
            if let Some(last) = self.row {
                self.reckoning.predict(last.roll_rad, last.pitch_rad, last.yaw_rad, navigation.dt_s);
            }
            let control = self.navigator.control(&navigation).map_err(|error| Refusal(error.to_string()))?;
            controls.extend(control);
            if let Some(row) = row {
                if let Some(velocity) = row.velocity_mps {
                    self.reckoning.dvl(&Vector3::from(velocity));
                }
                if let Some(z) = row.z_m {
                    self.reckoning.z(z);
                }
                self.row = Some(row);
            }
        }
        Ok(controls)
    }

    /// Position by dead reckoning, m.
    #[must_use]
    pub fn dead_reckoning(&self) -> [f64; 3] {
        self.reckoning.position_m().into()
    }
}

/// Feeds a whole log to a filter.
fn drive(
    log: &Log,
    settings: &Settings,
    slam: &mut dyn Slam,
    progress: &mut (dyn FnMut(usize) + Send),
) -> Result<(Record, Vec<(Health, usize)>), SessionError> {
    let mut pilot = Pilot::new(log, settings).map_err(SessionError::Start)?;
    let mut seen = Seen::new(log);
    let mut frames = Vec::with_capacity(log.frames.len());
    let mut map: Vec<MapFeature> = Vec::new();
    let mut counts = vec![0; Health::all().count()];
    for (scan, frame) in log.frames.iter().enumerate() {
        let refused = |step| move |refusal| SessionError::Step { scan, t_s: frame.t_s, step, refusal };
        for (control, dt_s) in pilot.steps_to(frame.t_s).map_err(refused("the instruments"))? {
            slam.predict(&control, dt_s).map_err(refused("the prediction"))?;
        }
        let clock = Instant::now();
        let outcome = slam.scan(&frame.keypoints).map_err(refused("the scan"))?;
        let scan_us = clock.elapsed().as_secs_f64() * 1e6;
        for (count, condition) in counts.iter_mut().zip(Health::all()) {
            *count += usize::from(outcome.health.contains(condition));
        }
        let (pose, covariance) = slam.pose().map_err(refused("the pose"))?;
        let truth = log.truth_at(frame.t_s, TRUTH_WITHIN_S);
        if let Some(truth) = truth {
            seen.look(truth);
        }
        let last = scan + 1 == log.frames.len();
        let (features_estimated, features) = slam.map().map_err(refused("the map"))?;
        map = features;
        let compared = (scan + 1).is_multiple_of(FRAMES_A_MAP_ERROR) || last;
        frames.push(FrameRecord {
            t_s: frame.t_s,
            pose,
            sigmas: std::array::from_fn(|k| covariance[k][k].max(0.0).sqrt()),
            dead_reckoning: pilot.dead_reckoning(),
            true_position: truth.map(|row| row.position),
            true_yaw_rad: truth.map(|row| row.yaw_rad),
            measurements: frame.keypoints.len(),
            features_estimated,
            n_eff: outcome.n_eff,
            in_view: outcome.in_view,
            no_birth: outcome.no_birth,
            pages_used: outcome.pages_used,
            scan_us,
            map_error: if compared { seen.error(&map) } else { None },
        });
        progress(frames.len());
    }
    let health = Health::all().zip(counts).filter(|&(_, count)| count > 0).collect();
    Ok((Record { frames, map }, health))
}

fn summary(log: &Log, settings: &Settings, filter: Filter, seed: u64, record: &Record, slam: &mut dyn Slam) -> Summary {
    let frames = &record.frames;
    let errors: Vec<f64> = frames.iter().filter_map(|f| Some(distance(position(f), f.true_position?))).collect();
    let reckoned: Vec<f64> = frames.iter().filter_map(|f| Some(distance(f.dead_reckoning, f.true_position?))).collect();
    let headings: Vec<f64> =
        frames.iter().filter_map(|f| Some(wrap(f.pose[3] - f.true_yaw_rad?).to_degrees())).collect();
    let features: Vec<[f64; 3]> = record.map.iter().map(|feature| feature.mean).collect();
    let mut seen = Seen::new(log);
    for frame in &log.frames {
        if let Some(truth) = log.truth_at(frame.t_s, TRUTH_WITHIN_S) {
            seen.look(truth);
        }
    }
    let truth = seen.features();
    let known = !log.landmarks.is_empty();
    let ospa = known.then(|| ospa::ospa(&features, &truth, &OSPA));
    let matched = known.then(|| Matched::of(&features, &truth));
    let mut times: Vec<f64> = frames.iter().map(|frame| frame.scan_us).collect();
    times.sort_by(f64::total_cmp);
    Summary {
        log: log.name.clone(),
        filter: filter.name(settings.filter.likelihood).into(),
        precision: filter.precision().into(),
        particles: settings.filter.particles as u64,
        seed,
        scans: frames.len() as u64,
        position_rmse_m: root_mean_square(&errors),
        heading_rmse_deg: root_mean_square(&headings),
        dead_reckoning_rmse_m: root_mean_square(&reckoned),
        final_position_error_m: errors.last().copied(),
        ospa_m: ospa.map(|score| score.distance),
        ospa_localization_m: ospa.map(|score| score.localization),
        ospa_cardinality_m: ospa.map(|score| score.cardinality),
        gospa_m: known.then(|| gospa::gospa(&features, &truth, &GOSPA).distance),
        features_estimated: frames.last().map(|frame| frame.features_estimated),
        scan_us_mean: (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64),
        scan_us_p99: percentile(&times, 99),
        state_bytes: slam.state_bytes(),
        digest: slam.digest(),
        moving_hit_rate: None,
        moving_settled_rate: None,
        moving_position_error_median_m: None,
        false_moving_tracks_per_scan: None,
        static_features_matched: matched.as_ref().map(|matched| matched.distances.len() as u64),
        static_features_false: matched.as_ref().map(|matched| matched.left_over as u64),
        static_position_error_median_m: matched.as_ref().and_then(|matched| median(&matched.distances)),
        ln_evidence: None,
        nis_mean: None,
        nees_mean: None,
    }
}

/// Features of an estimated map paired with true ones that are within half a metre.
struct Matched {
    distances: Vec<f64>,
    left_over: usize,
}

impl Matched {
    fn of(features: &[[f64; 3]], truth: &[[f64; 3]]) -> Self {
        let pairs = Cutoff::new(1.0, 0.5).pairs(features, truth);
        Self { left_over: features.len() - pairs.len(), distances: pairs.into_iter().map(|pair| pair.2).collect() }
    }
}

fn root_mean_square(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt())
}

/// What is kept of a session in a Monte Carlo study.
#[must_use]
pub fn result(job: &Job, samples: usize, session: Session) -> RunResult {
    let frames = &session.record.frames;
    let start_s = frames.first().map_or(0.0, |frame| frame.t_s);
    let value = |curve: Curve, frame: &FrameRecord| {
        let value = match curve {
            Curve::PositionError => distance(position(frame), frame.true_position?),
            Curve::HeadingError => wrap(frame.pose[3] - frame.true_yaw_rad?).abs().to_degrees(),
            Curve::DeadReckoningError => distance(frame.dead_reckoning, frame.true_position?),
            Curve::OspaNear => frame.map_error?.near.distance,
            Curve::OspaNearLocalization => frame.map_error?.near.localization,
            Curve::OspaNearCardinality => frame.map_error?.near.cardinality,
            Curve::OspaFar => frame.map_error?.far.distance,
            Curve::OspaFarLocalization => frame.map_error?.far.localization,
            Curve::OspaFarCardinality => frame.map_error?.far.cardinality,
        };
        Some(value).filter(|value| value.is_finite())
    };
    let series = Series {
        t_s: frames.iter().map(|frame| frame.t_s - start_s).collect(),
        values: Curve::ALL.map(|curve| frames.iter().map(|frame| value(curve, frame)).collect()),
    };
    RunResult {
        run: job.run,
        log: session.summary.log,
        filter: session.summary.filter,
        scenario_seed: job.scenario_seed,
        filter_seed: job.filter_seed,
        particles: session.summary.particles,
        samples: samples as u64,
        series,
        moving: None,
        scan_us_mean: session.summary.scan_us_mean,
    }
}

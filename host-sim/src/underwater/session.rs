//! One filter over one whole underwater log: what it estimated, how well, how fast.

use super::joint::joint_filter;
use super::log::{Instruments, Log};
use super::record::{FrameRecord, MapFeature, Record, distance, position};
use super::settings::Settings;
use super::slam::{Slam, core_filter};
use super::timeline::{Step, Timeline};
use super::truth::Seen;
use crate::angle::wrap;
use crate::monte_carlo::{Job, RunResult, ScanErrors};
use crate::output::json::{self, Format, Summary, worse};
use crate::score::consistency::{self, Consistency};
use crate::score::final_map::FinalMap;
use crate::session::{Filter, SessionError, with_roomy_stack};
use crate::slam::Refusal;
use crate::stream::underwater_models;
use crate::tally::{HealthCounts, ScanTimes};
use crate::threads::Threads;
use nalgebra::Vector3;
use scphd::{AuvControl, DeadReckoning, Health, Implausible, Navigator};
use scphd_stream::Helm;
use std::array;
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
    /// Steps that the filter left out: the time of the frame that they led to, s, and what is wrong.
    pub left_out: Vec<(f64, Implausible)>,
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
    run_on(&Threads::default(), log, settings, filter, seed, progress)
}

/// [`run`], with the candidates weighed by `threads`.
///
/// # Errors
/// As for `run`.
pub fn run_on(
    threads: &Threads,
    log: &Log,
    settings: &Settings,
    filter: Filter,
    seed: u64,
    progress: &mut (dyn FnMut(usize) + Send),
) -> Result<Session, SessionError> {
    let session = || {
        let mut slam = start(log, settings, filter, seed).map_err(SessionError::Start)?;
        slam.weigh_on(threads);
        let run = drive(log, settings, &mut *slam, progress)?;
        let summary = summary(log, settings, filter, seed, &run, &mut *slam);
        Ok(Session { record: run.record, summary, health: run.health, left_out: run.left_out })
    };
    with_roomy_stack(session).map_err(SessionError::Thread)?
}

fn start(log: &Log, settings: &Settings, filter: Filter, seed: u64) -> Result<Box<dyn Slam>, Refusal> {
    match filter {
        Filter::Core(precision) => Ok(core_filter(log, settings, precision, seed)?),
        Filter::Reference => Err(Refusal("in space the reference runs in lockstep only: scphd-sim compare".into())),
        Filter::Joint(precision) => joint_filter(log, settings, precision),
        Filter::Ekf(_) => Err(Refusal("the EKF is of the plane alone".into())),
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

/// What [`drive`] saw.
struct Run {
    record: Record,
    health: Vec<(Health, usize)>,
    left_out: Vec<(f64, Implausible)>,
    /// The true features that were shown, m; `None` where no frame has a true pose.
    seen: Option<Vec<[f64; 3]>>,
    consistency: Consistency,
}

/// Feeds a whole log to a filter.
fn drive(
    log: &Log,
    settings: &Settings,
    slam: &mut dyn Slam,
    progress: &mut (dyn FnMut(usize) + Send),
) -> Result<Run, SessionError> {
    let mut pilot = Pilot::new(log, settings).map_err(SessionError::Start)?;
    let mut seen = Seen::new(log);
    let mut frames = Vec::with_capacity(log.frames.len());
    let mut map: Vec<MapFeature> = Vec::new();
    let mut health = HealthCounts::default();
    let mut consistency = Consistency::default();
    let mut left_out = Vec::new();
    for (scan, frame) in log.frames.iter().enumerate() {
        let refused = |step| move |refusal| SessionError::Step { scan, t_s: frame.t_s, step, refusal };
        for (control, dt_s) in pilot.steps_to(frame.t_s).map_err(refused("the instruments"))? {
            let implausible = slam.predict(&control, dt_s).map_err(refused("the prediction"))?;
            left_out.extend(implausible.map(|what| (frame.t_s, what)));
        }
        let clock = Instant::now();
        let outcome = slam.scan(&frame.keypoints).map_err(refused("the scan"))?;
        let scan_us = clock.elapsed().as_secs_f64() * 1e6;
        health.add(outcome.health);
        consistency.scan(Some(outcome.ln_evidence), outcome.innovation);
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
            pose_covariance: covariance,
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
    let told = frames.iter().any(|frame| frame.true_position.is_some());
    let seen = told.then(|| seen.features());
    Ok(Run { record: Record { frames, map }, health: health.reported(), left_out, seen, consistency })
}

fn summary(log: &Log, settings: &Settings, filter: Filter, seed: u64, run: &Run, slam: &mut dyn Slam) -> Summary {
    let frames = &run.record.frames;
    let of_frames = |error: fn(ScanErrors) -> Option<f64>| -> Vec<f64> {
        frames.iter().filter_map(|frame| error(errors(frame))).collect()
    };
    let positions = of_frames(|errors| errors.position_m);
    let reckoned = of_frames(|errors| errors.dead_reckoning_m);
    let headings = of_frames(|errors| errors.heading_rad.map(f64::to_degrees));
    let features: Vec<[f64; 3]> = run.record.map.iter().map(|feature| feature.mean).collect();
    let landmarks: Vec<[f64; 3]> = log.stable().collect();
    let map = FinalMap::of(&features, &landmarks, run.seen.as_deref());
    let laid_over = map.map(|map| map.laid_over);
    // Births per px⁴, over the pixels that clutter is uniform over.
    let measure = settings.camera.clutter_per_scan / settings.clutter_intensity(log);
    let expected = settings.camera.clutter_per_scan + settings.filter.birth_intensity * measure;
    let position_errors = frames.iter().filter_map(|frame| {
        let truth = frame.true_position?;
        let covariance: [[f64; 3]; 3] = array::from_fn(|i| array::from_fn(|k| frame.pose_covariance[i][k]));
        Some((array::from_fn(|k| frame.pose[k] - truth[k]), covariance))
    });
    let times = ScanTimes::of(frames.iter().map(|frame| frame.scan_us));
    Summary {
        format: Format,
        log: log.name.clone(),
        filter: filter.name(settings.filter.likelihood).into(),
        precision: filter.precision().into(),
        particles: filter.particles(&settings.filter) as u64,
        seed,
        scans: frames.len() as u64,
        position_rmse_m: root_mean_square(&positions),
        heading_rmse_deg: root_mean_square(&headings),
        dead_reckoning_rmse_m: root_mean_square(&reckoned),
        final_position_error_m: positions.last().copied(),
        ospa_m: map.map(|map| map.ospa.distance),
        ospa_localization_m: map.map(|map| map.ospa.localization),
        ospa_cardinality_m: map.map(|map| map.ospa.cardinality),
        gospa_m: map.map(|map| map.gospa_m),
        ospa_seen_m: map.and_then(|map| map.ospa_seen_m),
        gospa_seen_m: map.and_then(|map| map.gospa_seen_m),
        features_estimated: frames.last().map(|frame| frame.features_estimated),
        scan_us_mean: times.mean_us,
        scan_us_p99: times.p99_us,
        state_bytes: slam.state_bytes(),
        digest: slam.digest(),
        moving_hit_rate: None,
        moving_settled_rate: None,
        moving_position_error_median_m: None,
        false_moving_tracks_per_scan: None,
        static_features_matched: laid_over.map(|score| score.matched as u64),
        static_features_false: laid_over.map(|score| score.spurious as u64),
        static_position_error_median_m: laid_over.and_then(|score| score.position_error_median_m),
        ln_evidence: run.consistency.ln_evidence(expected),
        nis_mean: run.consistency.innovation(),
        nees_median: consistency::of_positions(position_errors),
        worse_than_dead_reckoning: worse(root_mean_square(&positions), root_mean_square(&reckoned)),
        settings: json::settings(settings),
    }
}

fn root_mean_square(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt())
}

/// What is kept of a session in a Monte Carlo study.
#[must_use]
pub fn result(job: &Job, samples: usize, session: Session) -> RunResult {
    let errors: Vec<_> = session.record.frames.iter().map(|frame| (frame.t_s, errors(frame))).collect();
    RunResult::of_errors(job, samples, session.summary, &errors)
}

fn errors(frame: &FrameRecord) -> ScanErrors {
    let apart = |place| Some(distance(place, frame.true_position?));
    ScanErrors {
        position_m: apart(position(frame)),
        heading_rad: frame.true_yaw_rad.map(|truth| wrap(frame.pose[3] - truth)),
        dead_reckoning_m: apart(frame.dead_reckoning),
        map: frame.map_error,
    }
}

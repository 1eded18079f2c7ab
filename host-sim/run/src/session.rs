//! Runs one filter over one log, and collects its estimates, errors and times.

use crate::film::Film;
use crate::map_truth::MapTruth;
use crate::tally::{HealthCounts, ScanTimes};
use scphd::Health;
use scphd::errors::Implausible;
use scphd_filters::kind::Kind;
use scphd_filters::slam::{Refusal, Search, Slam, Taken};
use scphd_filters::threads::Threads;
use scphd_log::dimensions::{Coordinates, Dimensions, Planar};
use scphd_log::events::Event;
use scphd_log::log::TruePose;
use scphd_log::truth;
use scphd_score::consistency::{Consistency, SquaredErrors};
use scphd_score::final_map::FinalMap;
use scphd_score::map_error::MapError;
use scphd_score::moving::{MovingScore, MovingTally};
use scphd_score::record::{MapFeature, Record, ScanRecord};
use scphd_score::results::json::{self, Format, Summary, worse};
use scphd_score::trajectory;
use std::io;
use std::thread;
use std::time::Instant;

pub use scphd_filters::slam::Filter;

/// Stack of the thread in which a filter runs, bytes. The state of the filter takes tens of MB and is on the heap, but an
/// unoptimised build first creates several copies of it on the stack. A stack uses physical memory only where it is written.
const STACK_BYTES: usize = 512 << 20;

/// Results of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Session<D: Dimensions = Planar> {
    /// Every scan and the final map.
    pub record: Record<D>,
    pub summary: Summary,
    /// Scores of the moving landmarks; `None` if the log does not have their true positions.
    pub moving: Option<MovingScore>,
    /// Number of scans in which the filter reported each condition. Empty for the reference filter, which reports none.
    pub health: Vec<(Health, usize)>,
    /// Odometry rows that the filter rejected as implausible.
    pub left_out: Vec<LeftOut>,
}

/// Counts of the fixes (measurements of the pose).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct FixCounts {
    given: u64,
    left_out: u64,
    relocations: u64,
}

/// An odometry row with a motion that the vehicle cannot make.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOut {
    pub row: usize,
    pub t_s: f64,
    pub what: Implausible,
}

/// Why a run failed.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    #[error("the filter refuses the settings: {0}")]
    Start(Refusal),
    #[error("scan {scan} at {t_s} s: {step} refused: {refusal}")]
    Step {
        /// Number of the scan that was processed, or of the next one, from 0.
        scan: usize,
        t_s: f64,
        /// The operation.
        step: &'static str,
        refusal: Refusal,
    },
    /// The filter cannot start with this map, or cannot save its map.
    #[error("the map of another drive: {0}")]
    Map(Refusal),
    /// The operating system cannot start a thread.
    #[error("cannot start a thread: {0}")]
    Thread(io::Error),
}

/// Runs `filter` over `log`, in a thread with a stack that is large enough for any state. `progress` is called after each scan
/// with the number of scans so far.
pub fn run<K: Kind>(
    log: &K::Log,
    settings: &K::Settings,
    filter: Filter,
    seed: u64,
    progress: &mut (dyn FnMut(usize) + Send),
) -> Result<Session<K>, SessionError> {
    run_on(&Threads::default(), log, settings, filter, seed, progress)
}

/// [`run`] with these worker threads.
pub fn run_on<K: Kind>(
    threads: &Threads,
    log: &K::Log,
    settings: &K::Settings,
    filter: Filter,
    seed: u64,
    progress: &mut (dyn FnMut(usize) + Send),
) -> Result<Session<K>, SessionError> {
    let (maps, film) = (MapUse::default(), None);
    run_in_map::<K>(threads, log, settings, filter, seed, maps, film, progress).map(|(session, _)| session)
}

/// Use of maps of earlier drives: which map a run starts with, and whether it saves one.
#[derive(Debug, Clone, Copy, Default)]
pub struct MapUse<'m> {
    /// The initial map, made by [`Slam::map_file`].
    pub file: Option<&'m [u8]>,
    /// Whether the initial pose in the map is unknown and must be found (global localisation).
    pub locate: bool,
    /// Whether the final map is returned.
    pub save: bool,
    /// Whether only the final map is compared with the truth. This saves time if no table or plot shows the earlier errors.
    pub last_error_alone: bool,
}

/// Results of a run that concern maps of earlier drives.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MapOutcome {
    /// The final map, if [`MapUse::save`] is set.
    pub file: Option<Vec<u8>>,
    /// Result of the global localisation, if there was one.
    pub search: Option<Search>,
}

/// [`run_on`] with the use of maps of earlier drives. `film` records maps and particles for the HTML page and for MCAP.
#[expect(clippy::too_many_arguments, reason = "every parameter is a part of a run")]
pub fn run_in_map<K: Kind>(
    threads: &Threads,
    log: &K::Log,
    settings: &K::Settings,
    filter: Filter,
    seed: u64,
    maps: MapUse<'_>,
    film: Option<&mut Film<K>>,
    progress: &mut (dyn FnMut(usize) + Send),
) -> Result<(Session<K>, MapOutcome), SessionError> {
    let session = || {
        let mut slam = K::slam(filter, log, settings, seed).map_err(SessionError::Start)?;
        slam.work_on(threads);
        if let Some(file) = maps.file {
            slam.start_in(file, !maps.locate).map_err(SessionError::Map)?;
        }
        if maps.save {
            // A filter that cannot save a map fails here, before the run.
            slam.map_file().map_err(SessionError::Map)?;
        }
        let session = run_filter(log, settings, (filter, seed), &mut *slam, film, maps.last_error_alone, progress)?;
        let file = if maps.save { Some(slam.map_file().map_err(SessionError::Map)?) } else { None };
        Ok((session, MapOutcome { file, search: slam.search() }))
    };
    with_roomy_stack(session).map_err(SessionError::Thread)?
}

/// [`run`] with an existing filter that has processed nothing of the log. `filter` and `seed` describe it in the summary.
pub fn run_of<K: Kind>(
    slam: &mut dyn Slam<K>,
    log: &K::Log,
    settings: &K::Settings,
    filter: Filter,
    seed: u64,
) -> Result<Session<K>, SessionError> {
    run_filter(log, settings, (filter, seed), slam, None, false, &mut |_| {})
}

/// Processes a log and makes the summary.
fn run_filter<K: Kind>(
    log: &K::Log,
    settings: &K::Settings,
    (filter, seed): (Filter, u64),
    slam: &mut dyn Slam<K>,
    film: Option<&mut Film<K>>,
    last_error_alone: bool,
    progress: &mut (dyn FnMut(usize) + Send),
) -> Result<Session<K>, SessionError> {
    let run = process_log(log, settings, slam, film, last_error_alone, progress)?;
    let summary = summary(log, settings, filter, seed, &run, slam);
    let Run { record, health, left_out, moving, .. } = run;
    Ok(Session { record, summary, moving, health, left_out })
}

/// Runs `work` in a new thread whose stack is large enough for any filter state.
pub fn with_roomy_stack<T: Send>(work: impl FnOnce() -> T + Send) -> io::Result<T> {
    thread::scope(|scope| {
        let handle = thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, work)?;
        Ok(handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}

/// Results of [`process_log`].
struct Run<D: Dimensions> {
    record: Record<D>,
    health: Vec<(Health, usize)>,
    left_out: Vec<LeftOut>,
    moving: Option<MovingScore>,
    /// True positions of the static landmarks that were in view, m; `None` if the log does not have them.
    seen: Option<Vec<D::Position>>,
    consistency: Consistency,
    fixes: FixCounts,
}

/// Processes all events of a log with a filter.
fn process_log<K: Kind>(
    log: &K::Log,
    settings: &K::Settings,
    slam: &mut dyn Slam<K>,
    mut film: Option<&mut Film<K>>,
    last_error_alone: bool,
    progress: &mut (dyn FnMut(usize) + Send),
) -> Result<Run<K>, SessionError> {
    let mut map_truth: MapTruth<'_, K> = MapTruth::new(log, settings);
    let view = K::view(log, settings);
    let mut tally = MovingTally::default();
    let dead_reckoning = K::dead_reckoning(log, settings).map_err(SessionError::Start)?;
    let mut watch = K::fix_watch(settings).map_err(SessionError::Start)?;
    let all = K::scans(log);
    let mut scans = Vec::with_capacity(all.len());
    let mut map: Vec<MapFeature<K>> = Vec::new();
    let mut health = HealthCounts::default();
    let mut consistency = Consistency::default();
    let (mut left_out, mut fixes) = (Vec::new(), FixCounts::default());
    for event in K::events(log, settings).map_err(SessionError::Start)? {
        let next = scans.len();
        let refused = |step| {
            let t_s = all[next].t_s;
            move |refusal| SessionError::Step { scan: next, t_s, step, refusal }
        };
        match event {
            Event::Predict { row, control, dt_s } => {
                watch.wait(dt_s);
                let implausible = slam.predict(control, dt_s).map_err(refused("the prediction"))?;
                // A row that a scan splits into several predictions is counted once.
                if let Some(what) = implausible
                    && left_out.last().is_none_or(|last: &LeftOut| last.row != row)
                {
                    left_out.push(LeftOut { row, t_s: K::row_t_s(log, row), what });
                }
            }
            Event::Fix { fix } => {
                fixes.given += 1;
                let taken = watch.show(slam, &fix).map_err(refused("the fix"))?;
                fixes.left_out += u64::from(taken != Taken::In);
                fixes.relocations += u64::from(taken == Taken::Relocated);
            }
            Event::Scan { index } => {
                let scan = &all[index];
                let start = Instant::now();
                let outcome = slam.scan(scan.sensor, &scan.detections).map_err(refused("the scan"))?;
                let scan_us = start.elapsed().as_secs_f64() * 1e6;
                health.add(outcome.health);
                let detections = scan.detections.len().min(outcome.usage.in_view);
                consistency.scan(outcome.ln_evidence, outcome.innovation, detections, K::Measurement::COUNT);
                let (pose, pose_covariance) = slam.pose().map_err(refused("the pose"))?;
                let (features_estimated, features) = slam.map().map_err(refused("the map"))?;
                let mut moving = slam.moving().map_err(refused("the moving features"))?;
                // Moving features out of view are not scored, because the truth of a scan has only landmarks in view.
                let present_pose =
                    TruePose { t_s: scan.t_s, position: K::position(&pose), heading_rad: Some(K::heading(&pose)) };
                moving.retain(|feature| view(&present_pose, feature.position) != Some(false));
                map = features;
                let truth = truth::at(K::truth(log), scan.t_s);
                let true_map = map_truth.at(scan.t_s, truth.as_ref());
                let known = true_map.as_ref();
                let landmarks = known.filter(|_| map_truth.knows_landmarks());
                let is_due = !last_error_alone && (index + 1).is_multiple_of(K::SCANS_A_MAP_ERROR);
                let compared = is_due || index + 1 == all.len();
                let mut estimated: Vec<K::Position> = moving.iter().map(|feature| feature.position).collect();
                let movers =
                    known.filter(|_| map_truth.knows_movers()).map(|true_map| tally.scan(&true_map.movers, &estimated));
                estimated.extend(map.iter().map(|feature| feature.mean));
                if let Some(film) = film.as_deref_mut() {
                    film.scan(&outcome);
                    if film.has(index) {
                        let particles = slam.particles().map_err(refused("the particles"))?;
                        let true_movers = known.filter(|_| map_truth.knows_movers()).map(|true_map| &true_map.movers);
                        let true_movers = true_movers.map(|movers| movers.iter().map(|&(_, place)| place).collect());
                        film.add(map.clone(), moving.clone(), particles, true_movers);
                    }
                }
                if movers.is_none() {
                    tally.unknown();
                }
                scans.push(ScanRecord {
                    t_s: scan.t_s,
                    pose,
                    pose_covariance,
                    dead_reckoning: dead_reckoning[index],
                    true_position: truth.map(|truth| truth.position),
                    truth_sigma_m: K::truth_sigma_m(log),
                    true_heading_rad: truth.and_then(|truth| truth.heading_rad),
                    measurements: scan.detections.len(),
                    features_estimated,
                    n_eff: outcome.n_eff,
                    usage: outcome.usage,
                    scan_us,
                    map_error: landmarks.filter(|_| compared).map(|truth| MapError::of(&estimated, &truth.points())),
                    landmarks_seen: landmarks.map(|truth| truth.landmarks.len()),
                    moving,
                    movers,
                });
                progress(scans.len());
            }
        }
    }
    let moving = map_truth.knows_movers().then(|| tally.score()).filter(|score| score.scans > 0);
    let seen = map_truth.seen();
    Ok(Run { record: Record { scans, map }, health: health.reported(), left_out, moving, seen, consistency, fixes })
}

/// The figures of a run.
fn summary<K: Kind>(
    log: &K::Log,
    settings: &K::Settings,
    filter: Filter,
    seed: u64,
    run: &Run<K>,
    slam: &mut dyn Slam<K>,
) -> Summary {
    let (scans, recursion) = (&run.record.scans, K::recursion(settings));
    let estimate = trajectory::of_estimate(scans);
    let dead_reckoning = trajectory::of_dead_reckoning(scans);
    let features: Vec<K::Position> = run.record.map.iter().map(|feature| feature.mean).collect();
    let map = FinalMap::of(&features, &K::landmarks(log), run.seen.as_deref());
    let laid_over = map.map(|map| map.laid_over);
    let (positions, poses) = (SquaredErrors::of_positions(scans), SquaredErrors::of_poses(scans));
    let moving = run.moving.as_ref();
    let times = ScanTimes::of(scans.iter().map(|scan| scan.scan_us));
    Summary {
        format: Format,
        log: K::name(log).to_owned(),
        filter: filter.name(recursion.likelihood).into(),
        precision: filter.precision().into(),
        particles: filter.particles(recursion) as u64,
        seed,
        scans: scans.len() as u64,
        position_rmse_m: estimate.map(|score| score.position_rmse_m),
        position_rmse_aligned_m: trajectory::aligned_rmse_m(scans),
        heading_rmse_deg: estimate.and_then(|score| score.heading_rmse_deg),
        dead_reckoning_rmse_m: dead_reckoning.map(|score| score.position_rmse_m),
        final_position_error_m: estimate.map(|score| score.final_position_error_m),
        ospa_m: map.map(|map| map.ospa.distance),
        ospa_localization_m: map.map(|map| map.ospa.localization),
        ospa_cardinality_m: map.map(|map| map.ospa.cardinality),
        gospa_m: map.map(|map| map.gospa_m),
        ospa_seen_m: map.and_then(|map| map.ospa_seen_m),
        gospa_seen_m: map.and_then(|map| map.gospa_seen_m),
        features_estimated: scans.last().map(|scan| scan.features_estimated),
        scan_us_mean: times.mean_us,
        scan_us_p99: times.p99_us,
        state_bytes: slam.state_bytes(),
        digest: slam.digest(),
        moving_hit_rate: moving.and_then(MovingScore::hit_rate),
        moving_settled_rate: moving.and_then(MovingScore::settled_rate),
        moving_position_error_median_m: moving.and_then(MovingScore::position_error_median_m),
        false_moving_tracks_per_scan: moving.and_then(MovingScore::false_per_scan),
        static_features_matched: laid_over.map(|score| score.matched as u64),
        static_features_false: laid_over.map(|score| score.spurious as u64),
        static_position_error_median_m: laid_over.and_then(|score| score.position_error_median_m),
        ln_evidence: run.consistency.ln_evidence(K::unexplained_per_scan(log, settings)),
        nis_mean: run.consistency.innovation(),
        nis_within_95: run.consistency.innovation_within(),
        nees_median: positions.median(),
        nees_within_95: positions.within(),
        nees_final: positions.last(),
        nees_pose_median: poses.median(),
        nees_pose_within_95: poses.within(),
        worse_than_dead_reckoning: worse(
            estimate.map(|score| score.position_rmse_m),
            dead_reckoning.map(|score| score.position_rmse_m),
        ),
        fixes: run.fixes.given,
        fixes_left_out: run.fixes.left_out,
        fix_relocations: run.fixes.relocations,
        settings: json::settings(settings),
    }
}

pub fn condition_name(condition: Health) -> String {
    format!("{condition:?}").trim_matches(['{', '"', '}']).to_owned()
}

#[cfg(test)]
mod far_out;
#[cfg(test)]
mod fixes;
#[cfg(test)]
mod growing_noise;
#[cfg(test)]
mod several;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod unused_settings;

//! Checks whether a filter on a device has the same state as the one on the host after every scan.

use crate::batch::Batch;
use crate::device::Device;
use crate::source::{FILTER, Source};
use crate::study::{StudyError, played};
use scphd_filters::kind::Kind;
use scphd_filters::settings::Settings;
use scphd_gpu_kernels::Status;
use scphd_log::dimensions::Planar;
use scphd_log::events::{Event, events};
use scphd_log::log::Log;
use scphd_run::session::{SessionError, with_roomy_stack};
use std::time::Instant;

/// The result of a comparison of all scans of several runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    /// Number of digests that were compared.
    pub digests: usize,
    /// The first difference of every run that has one.
    pub differences: Vec<Difference>,
    /// Wall time of the launches, s.
    pub launched_s: f64,
    /// The greatest numbers of pages of static and of moving features that a scan has used.
    pub peak_pages: [u32; 2],
    /// The greatest numbers of estimated features and of moving ones per scan, each averaged over a run.
    pub features_a_scan: [f64; 2],
}

/// A digest of the device that differs from the host's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Difference {
    /// Seed of scenario and filter.
    pub seed: u64,
    /// The scan, from 0.
    pub scan: usize,
    /// The digest of the host.
    pub host: u64,
    /// The digest of the device.
    pub device: u64,
}

/// Runs the filter over a log on the host, as `scphd-sim` does, for at most `most_scans` scans. Returns the digest after each,
/// and the wall time of all predictions and scans, s.
///
/// # Errors
/// The filter refused the settings or a step.
pub fn digests_of_host(
    log: &Log,
    settings: &Settings,
    seed: u64,
    most_scans: usize,
) -> Result<(Vec<u64>, f64), SessionError> {
    on_host(log, settings, seed, most_scans, true)
}

/// [`digests_of_host`] without digests, whose computation would count as time. Returns the wall time, s.
pub fn drive_on_host(log: &Log, settings: &Settings, seed: u64) -> Result<f64, SessionError> {
    on_host(log, settings, seed, usize::MAX, false).map(|(_, seconds)| seconds)
}

fn on_host(
    log: &Log,
    settings: &Settings,
    seed: u64,
    most_scans: usize,
    digests: bool,
) -> Result<(Vec<u64>, f64), SessionError> {
    let drive = || {
        let mut slam = Planar::slam(FILTER, log, settings, seed).map_err(SessionError::Start)?;
        let (mut found, mut seconds, mut scan) = (Vec::new(), 0.0, 0);
        for event in events(log) {
            let refused = |step, t_s| move |refusal| SessionError::Step { scan, t_s, step, refusal };
            let started = Instant::now();
            match event {
                Event::Predict { control, dt_s, .. } => {
                    let t_s = log.scans[scan].t_s;
                    slam.predict(control, dt_s).map_err(refused("the prediction", t_s))?;
                }
                Event::Fix { fix } => {
                    slam.observe(&fix).map_err(refused("the fix", log.scans[scan].t_s))?;
                }
                Event::Scan { index } => {
                    let taken = &log.scans[index];
                    slam.scan(taken.sensor, &taken.detections).map_err(refused("the scan", taken.t_s))?;
                    scan += 1;
                }
            }
            seconds += started.elapsed().as_secs_f64();
            if digests && matches!(event, Event::Scan { .. }) {
                found.extend(slam.digest());
            }
            if scan == most_scans {
                break;
            }
        }
        Ok((found, seconds))
    };
    with_roomy_stack(drive).map_err(SessionError::Thread)?
}

impl Checked {
    /// Runs the source on the device with each of the seeds (of the scenario and of the filter), and compares the digests after
    /// the first `most_scans` scans with the host's.
    ///
    /// # Errors
    /// The kernels cannot do a run, a run has stopped, or the device does not work.
    pub fn of(device: &mut dyn Device, source: &Source, seeds: &[u64], most_scans: usize) -> Result<Self, StudyError> {
        let (mut batch, mut hosts) = (Batch::default(), Vec::new());
        for (run, &seed) in seeds.iter().enumerate() {
            let mut log = source.log(seed)?;
            let settings = source.settings(&log)?;
            log.scans.truncate(most_scans);
            batch.push(&log, &settings, seed)?;
            let of_host = digests_of_host(&log, &settings, seed, most_scans);
            hosts.push(of_host.map_err(|why| StudyError::Session { run, why })?.0);
        }
        let outcome = device.run(&batch, 1)?;
        let mut checked = Self {
            digests: 0,
            differences: Vec::new(),
            launched_s: outcome.launched_s,
            peak_pages: [0; 2],
            features_a_scan: [0.0; 2],
        };
        for (run, (&seed, host)) in seeds.iter().zip(&hosts).enumerate() {
            let played = played(&batch, &outcome, run, run, 0)?;
            let results = played.results();
            if results.len() != host.len() {
                let Status { code, scans } = outcome.statuses[run];
                return Err(StudyError::Stopped { run, scan: scans, why: Status::text(code) });
            }
            checked.digests += host.len();
            let pairs = host.iter().zip(results).enumerate();
            let mut differ = pairs.filter(|(_, (host, result))| **host != result.digest);
            checked.differences.extend(differ.next().map(|(scan, (host, result))| Difference {
                seed,
                scan,
                host: *host,
                device: result.digest,
            }));
            let mut sums = [0.0; 2];
            for result in results {
                let peaks = [result.peak_pages, result.peak_moving_pages];
                checked.peak_pages = std::array::from_fn(|kind| checked.peak_pages[kind].max(peaks[kind]));
                sums = std::array::from_fn(|kind| sums[kind] + f64::from([result.features, result.movers][kind]));
            }
            let means = sums.map(|sum| sum / results.len().max(1) as f64);
            checked.features_a_scan = std::array::from_fn(|kind| checked.features_a_scan[kind].max(means[kind]));
        }
        Ok(checked)
    }
}

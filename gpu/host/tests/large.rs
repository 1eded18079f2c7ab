//! One large filter, launch by launch on the host, has the same state as the library's own scan, bit for bit.

use scphd_gpu::{Batch, Emulated, LargeRun, Source, Tuning, digests_of_host, large};
use scphd_gpu_kernels::ScanResult;

const SEED: u64 = 3;

fn source(scenario: &str, particles: usize) -> Source {
    Source::new(scenario, Tuning { particles: Some(particles), ..Tuning::default() }).unwrap()
}

/// Runs the batch on the emulated device, and compares every scan with the library's own.
fn same_digests(batch: &Batch, scans: usize) -> LargeRun {
    let found = LargeRun::on(&mut Emulated::new(None), batch, 1).unwrap();
    let host = LargeRun::alone(batch, 1).unwrap();
    assert_eq!(found.results.len(), scans);
    assert!(found.results.iter().all(|result| result.digest != 0));
    assert_eq!(found.difference(&host, SEED), None);
    // Reports and estimates are the same too, except for the peak of pages: maps that are stored at once allocate their pages
    // after all others have freed theirs.
    let plain = |run: &LargeRun| -> Vec<ScanResult> {
        let of_scan = |result: &ScanResult| ScanResult { peak_pages: 0, peak_moving_pages: 0, ..*result };
        run.results.iter().map(of_scan).collect()
    };
    assert_eq!(plain(&found), plain(&host));
    found
}

#[test]
fn sixty_four_particles_match_the_simulator_over_300_scans() {
    let source = source("thesis-dynamic", 64);
    let found = same_digests(&large(&source, SEED, 300).unwrap(), 300);
    assert!(found.results.iter().any(|result| result.resampled != 0));
    let mut log = source.log(SEED).unwrap();
    log.scans.truncate(300);
    let (digests, _) = digests_of_host(&log, &source.settings(&log).unwrap(), SEED, 300).unwrap();
    let of_device: Vec<u64> = found.results.iter().map(|result| result.digest).collect();
    assert_eq!(of_device, digests);
}

#[test]
fn thousands_of_particles_match_the_library() {
    let found = same_digests(&large(&source("thesis-dynamic", 4096), SEED, 12).unwrap(), 12);
    assert!(found.results.iter().any(|result| result.resampled != 0));
    assert_eq!(found.short_scans(), 0, "{:?}", found.peak_pages());
}

#[test]
fn more_particles_than_pages_match_the_library() {
    let found = same_digests(&large(&source("thesis-dynamic", 16_384), SEED, 4).unwrap(), 4);
    assert!(found.short_scans() > 0, "{:?}", found.peak_pages());
}

#[test]
fn informed_particles_match_the_library() {
    let text = "[filter]\nproposal = \"informed\"\nproposal_sampled_fraction = 0.2\n".to_owned();
    let tuning = Tuning { particles: Some(16), settings: Some(text), ..Tuning::default() };
    let source = Source::new("survey", tuning).unwrap();
    same_digests(&large(&source, SEED, 60).unwrap(), 60);
}

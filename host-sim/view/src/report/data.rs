//! The data of a page.

use crate::meaning;
use nalgebra::DMatrix;
use scphd::Health;
use scphd_filters::kind::Kind;
use scphd_filters::slam::STAGES;
use scphd_log::angle::wrap;
use scphd_log::dimensions::{Coordinates, Dimensions};
use scphd_log::log::TruePose;
use scphd_run::film::{FRAMES, Film, Frame, PARTICLES};
use scphd_run::session::{Session, condition_name};
use scphd_score::record::ScanRecord;
use scphd_score::results::json::Summary;
use serde::Serialize;

/// Greatest number of points of a curve.
const POINTS: usize = 4000;
/// The 99 % quantiles of χ² with two and three degrees of freedom.
const GATES: [f64; 2] = [9.210, 11.345];
/// Least weight of a feature whose detection is expected.
const EXPECTED: f64 = 0.5;

/// All data of a page; `page.js` uses these names.
#[derive(Debug, Serialize)]
pub(super) struct Data<'a> {
    summary: &'a Summary,
    meanings: Vec<(String, String)>,
    settings_text: &'a str,
    /// Pairs of axes for the maps, and the names of all axes.
    looks: Vec<[usize; 2]>,
    axes: Vec<&'static str>,
    notes: Vec<String>,
    series: Series,
    landmarks: Vec<Vec<f64>>,
    frames: Vec<Picture>,
    health: Vec<Reported>,
}

/// Curves: a list for each quantity, all of the same length.
#[derive(Debug, Serialize)]
struct Series {
    scan: Vec<usize>,
    t_s: Vec<f64>,
    position: Vec<Vec<f64>>,
    truth: Vec<Option<Vec<f64>>>,
    dead_reckoning: Vec<Vec<f64>>,
    position_error_m: Vec<Option<f64>>,
    position_2sigma_m: Vec<f64>,
    dead_reckoning_error_m: Vec<Option<f64>>,
    heading_error_deg: Vec<Option<f64>>,
    heading_2sigma_deg: Vec<f64>,
    ospa_m: Vec<Option<f64>>,
    n_eff: Vec<f64>,
    features_estimated: Vec<f64>,
    pages_used: Vec<Option<usize>>,
    in_view: Vec<usize>,
    measurements: Vec<usize>,
    scan_us: Vec<f64>,
    stage_predict_us: Vec<Option<f64>>,
    stage_weigh_us: Vec<Option<f64>>,
    stage_resample_us: Vec<Option<f64>>,
    stage_update_us: Vec<Option<f64>>,
    stage_reduce_us: Vec<Option<f64>>,
}

/// The map at a scan. Coordinates in steps of a millimetre, covariances of a square millimetre.
#[derive(Debug, Serialize)]
struct Picture {
    scan: usize,
    t_s: f64,
    /// Position, then heading.
    pose: Vec<f64>,
    /// Covariance of the position: the upper triangle, row by row.
    covariance: Vec<f64>,
    truth: Option<Vec<f64>>,
    /// Label, weight, position, covariance; the last number is 1 for a detected feature, -1 for a missed one, 0 out of view.
    features: Vec<Feature>,
    moving: Vec<Mover>,
    /// Position and weight of the particles.
    particles: Vec<Vec<f64>>,
    /// Position, and whether it is near a feature of the map.
    detections: Vec<(Vec<f64>, bool)>,
    movers: Vec<Vec<f64>>,
}

#[derive(Debug, Serialize)]
struct Feature(u32, f64, Vec<f64>, Vec<f64>, i8);

#[derive(Debug, Serialize)]
struct Mover(u32, f64, Vec<f64>, Vec<f64>, Vec<f64>, i8);

/// A condition and the scans with it.
#[derive(Debug, Serialize)]
struct Reported {
    name: String,
    #[serde(flatten)]
    meaning: Option<meaning::Condition>,
    scans: usize,
    /// First and last scan of every interval, and their times, s.
    spells: Vec<(usize, usize, f64, f64)>,
}

impl<'a> Data<'a> {
    pub(super) fn of<K: Kind>(
        log: &K::Log,
        settings: &K::Settings,
        session: &'a Session<K>,
        film: &Film<K>,
        settings_text: &'a str,
    ) -> Self {
        let scans = &session.record.scans;
        let chosen = thinned(scans);
        let mut notes = vec![
            format!(
                "The map has {} pictures: of every scan, or of {FRAMES} that are evenly spread, the first and the last among them. A \
                 picture has at most {PARTICLES} particles, the heaviest.",
                film.frames.len()
            ),
            format!(
                "The curves have {} of {} scans: all, or one of each of {POINTS} equal pieces, that with the greatest position error, so that no peak is \
                 left out.",
                chosen.len(),
                scans.len()
            ),
            "A detection is drawn as one of a known feature where it lies within the 99 % gate of a feature of the estimated map, as seen from the \
             estimated pose; otherwise as unexplained: false or new. A feature is missed where it is expected in view and no detection lies \
             within that gate. The filter itself makes no such decisions."
                .to_owned(),
            "Ellipses hold 95 % by the filter's own covariance. 2 σ of the position is twice the root of the sum of its variances, with those of a truth that has noise of its own; the error lies under it \
             nearly always where the filter knows how wrong it is."
                .to_owned(),
        ];
        if scans.iter().any(|scan| scan.map_error.is_some()) {
            notes.push(
                "OSPA: order 1, cut-off 10 m, of all estimated features, static and moving, to the true ones that have been in view."
                    .to_owned(),
            );
        }
        Self {
            summary: &session.summary,
            meanings: meaning::of_figures(),
            settings_text,
            looks: K::LOOKS.to_vec(),
            axes: K::POSE.iter().take(K::Position::COUNT).map(|(name, _)| *name).collect(),
            notes,
            series: Series::of(chosen.iter().map(|&place| (place, &scans[place])), &film.stages_us),
            landmarks: K::landmarks(log).iter().chain(&K::seldom(log)).map(millimetres).collect(),
            frames: film.frames.iter().map(|frame| picture::<K>(log, settings, &scans[frame.scan], frame)).collect(),
            health: reported(scans, &film.health),
        }
    }
}

/// Indices of the scans for the curves.
fn thinned<D: Dimensions>(scans: &[ScanRecord<D>]) -> Vec<usize> {
    if scans.len() <= POINTS {
        return (0..scans.len()).collect();
    }
    let worst = |piece: usize| {
        let (from, until) = (piece * scans.len() / POINTS, (piece + 1) * scans.len() / POINTS);
        let error = |place: &usize| scans[*place].position_error_m().unwrap_or(f64::NEG_INFINITY);
        match piece {
            0 => from,
            _ if piece + 1 == POINTS => until - 1,
            // Of several equal ones the first is taken.
            _ => (from..until).rev().max_by(|a, b| error(a).total_cmp(&error(b))).unwrap_or(from),
        }
    };
    (0..POINTS).map(worst).collect()
}

impl Series {
    fn of<'s, D: Dimensions>(
        scans: impl Iterator<Item = (usize, &'s ScanRecord<D>)> + Clone,
        stages_us: &[Option<[f64; STAGES]>],
    ) -> Self {
        fn list<'s, D: Dimensions, T>(
            scans: &(impl Iterator<Item = (usize, &'s ScanRecord<D>)> + Clone),
            of: impl Fn(&'s ScanRecord<D>) -> T,
        ) -> Vec<T> {
            scans.clone().map(|(_, scan)| of(scan)).collect()
        }
        let n = D::Position::COUNT;
        let heading_variance = |scan: &ScanRecord<D>| scan.pose_covariance.as_ref()[n].as_ref()[n];
        let stage = |stage: usize| scans.clone().map(|(place, _)| Some((*stages_us.get(place)?)?[stage])).collect();
        let heading_error =
            |scan: &ScanRecord<D>| Some(wrap(D::heading(&scan.pose) - scan.true_heading_rad?).abs().to_degrees());
        Self {
            scan: scans.clone().map(|(place, _)| place).collect(),
            t_s: list(&scans, |scan| scan.t_s),
            position: list(&scans, |scan| D::position(&scan.pose).as_ref().to_vec()),
            truth: list(&scans, |scan| scan.true_position.map(|place| place.as_ref().to_vec())),
            dead_reckoning: list(&scans, |scan| scan.dead_reckoning.as_ref()[..n].to_vec()),
            position_error_m: list(&scans, ScanRecord::position_error_m),
            position_2sigma_m: list(&scans, |scan| 2.0 * scan.expected_error_m()),
            dead_reckoning_error_m: list(&scans, ScanRecord::dead_reckoning_error_m),
            heading_error_deg: list(&scans, heading_error),
            heading_2sigma_deg: list(&scans, |scan| 2.0 * heading_variance(scan).sqrt().to_degrees()),
            ospa_m: list(&scans, |scan| scan.map_error.map(|error| error.far.distance)),
            n_eff: list(&scans, |scan| scan.n_eff),
            features_estimated: list(&scans, |scan| scan.features_estimated),
            pages_used: list(&scans, |scan| scan.usage.pages_used),
            in_view: list(&scans, |scan| scan.usage.in_view),
            measurements: list(&scans, |scan| scan.measurements),
            scan_us: list(&scans, |scan| scan.scan_us),
            stage_predict_us: stage(0),
            stage_weigh_us: stage(1),
            stage_resample_us: stage(2),
            stage_update_us: stage(3),
            stage_reduce_us: stage(4),
        }
    }
}

/// A detection in the map: position and its standard deviation, m.
type Seen<K> = (<K as Dimensions>::Position, f64);

fn picture<K: Kind>(log: &K::Log, settings: &K::Settings, scan: &ScanRecord<K>, frame: &Frame<K>) -> Picture {
    let n = K::Position::COUNT;
    let seen: Vec<Seen<K>> = K::scans(log)[frame.scan]
        .detections
        .iter()
        .filter_map(|detection| K::place(log, settings, frame.scan, &scan.pose, detection))
        .collect();
    let here = TruePose { t_s: scan.t_s, position: K::position(&scan.pose), heading_rad: Some(K::heading(&scan.pose)) };
    let view = K::view(log, settings);
    let gate = Gate::of(&seen);
    let (mut features, mut moving) = (Vec::new(), Vec::new());
    let mut met = vec![false; seen.len()];
    let mut fate = |weight: f64, place: K::Position, covariance: &[&[f64]]| {
        let hits = gate.hits(place.as_ref(), covariance, &seen);
        hits.iter().for_each(|&hit| met[hit] = true);
        match hits.is_empty() {
            false => 1,
            true if weight >= EXPECTED && view(&here, place) == Some(true) => -1,
            true => 0,
        }
    };
    for feature in &frame.map {
        let rows: Vec<&[f64]> = feature.covariance.as_ref().iter().map(AsRef::as_ref).collect();
        let fate = fate(feature.weight, feature.mean, &rows);
        features.push(Feature(
            feature.id,
            hundredths(feature.weight),
            millimetres(&feature.mean),
            squares(&rows),
            fate,
        ));
    }
    for feature in &frame.moving {
        let rows: Vec<&[f64]> = feature.covariance.as_ref().iter().map(AsRef::as_ref).collect();
        let fate = fate(feature.weight, feature.position, &rows);
        let (place, velocity) = (millimetres(&feature.position), millimetres(&feature.velocity));
        moving.push(Mover(feature.id, hundredths(feature.weight), place, squares(&rows), velocity, fate));
    }
    let of_place: Vec<&[f64]> = scan.pose_covariance.as_ref().iter().take(n).map(|row| &row.as_ref()[..n]).collect();
    let mut pose = millimetres(&K::position(&scan.pose));
    pose.push((K::heading(&scan.pose) * 1e4).round() / 1e4);
    Picture {
        scan: frame.scan,
        t_s: scan.t_s,
        pose,
        covariance: squares(&of_place),
        truth: scan.true_position.map(|place| millimetres(&place)),
        features,
        moving,
        particles: frame
            .particles
            .iter()
            .map(|(pose, weight)| {
                let mut particle = millimetres(&K::position(pose));
                particle.push((weight * 1e4).round() / 1e4);
                particle
            })
            .collect(),
        detections: seen.iter().zip(met).map(|((place, _), met)| (millimetres(place), met)).collect(),
        movers: frame.movers.iter().flatten().map(millimetres).collect(),
    }
}

/// Gate for detections near a feature.
struct Gate {
    most: f64,
}

impl Gate {
    fn of<P: Coordinates>(_seen: &[(P, f64)]) -> Self {
        Self { most: GATES[usize::from(P::COUNT > 2)] }
    }

    fn hits<P: Coordinates>(&self, place: &[f64], covariance: &[&[f64]], seen: &[(P, f64)]) -> Vec<usize> {
        let n = P::COUNT;
        let spread = (0..n).map(|k| covariance[k][k]).sum::<f64>();
        let near = |(at, sigma_m): &(P, f64)| {
            let off: Vec<f64> = (0..n).map(|k| at.as_ref()[k] - place[k]).collect();
            let square: f64 = off.iter().map(|x| x * x).sum();
            // Above this bound the distance is always beyond the gate, so that most detections need no inverse.
            if !(square <= self.most * (spread + sigma_m * sigma_m)) {
                return false;
            }
            let noise = |row, column| if row == column { sigma_m * sigma_m } else { 0.0 };
            let sum = DMatrix::from_fn(n, n, |row, column| covariance[row][column] + noise(row, column));
            let off = DMatrix::from_column_slice(n, 1, &off);
            sum.cholesky().is_some_and(|root| (off.transpose() * root.solve(&off))[0] <= self.most)
        };
        seen.iter().enumerate().filter(|(_, one)| near(one)).map(|(index, _)| index).collect()
    }
}

fn reported<D: Dimensions>(scans: &[ScanRecord<D>], health: &[Health]) -> Vec<Reported> {
    let of = |condition: Health| {
        let mut spells: Vec<(usize, usize, f64, f64)> = Vec::new();
        let mut count = 0;
        for (place, (scan, health)) in scans.iter().zip(health).enumerate() {
            if !health.contains(condition) {
                continue;
            }
            count += 1;
            match spells.last_mut() {
                Some(last) if last.1 + 1 == place => (last.1, last.3) = (place, scan.t_s),
                _ => spells.push((place, place, scan.t_s, scan.t_s)),
            }
        }
        let name = condition_name(condition);
        Reported { meaning: meaning::of_condition(&name), name, scans: count, spells }
    };
    Health::all().map(of).filter(|reported| reported.scans > 0).collect()
}

fn millimetres(place: &impl AsRef<[f64]>) -> Vec<f64> {
    place.as_ref().iter().map(|x| (x * 1e3).round() / 1e3).collect()
}

/// The upper triangle, row by row, in steps of 10⁻⁶.
fn squares(rows: &[&[f64]]) -> Vec<f64> {
    let upper = rows.iter().enumerate().flat_map(|(k, row)| &row[k..]);
    upper.map(|x| (x * 1e6).round() / 1e6).collect()
}

fn hundredths(number: f64) -> f64 {
    (number * 100.0).round() / 100.0
}

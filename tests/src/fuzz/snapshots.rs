//! Snapshots of every kind: damaged, truncated, concatenated, with changed words and correct checksums, of other versions,
//! scalars and capacities, and from sources that change. A refused snapshot leaves the state unchanged or not started; an
//! accepted one gives a valid state, and the filter continues.

use super::counts::count;
use super::draw::Draw;
use super::session::Seeded;
use super::worlds::{Diver, Models, Rover, World};
use super::{Failure, Operations, Run, Watch, require};
use crc::{CRC_32_ISO_HDLC, Crc};
use nalgebra::{Vector2, Vector3};
use scphd::diagnostics::Scrubber;
use scphd::models::{PlanarPose, Pose, Reading, Sensor};
use scphd::navigation::{Instruments, Navigator, VelocityNoise};
use scphd::numerics::Symmetric;
use scphd::snapshot::{RestoreError, SliceEnd, from_slice, restore_map, save_map};
use scphd::storage::{Dynamic, JointArchive, MapMemory, Static, joint_numbers};
use scphd::{
    Births, Component, Config, Detector, DetectorMemory, JointConfig, JointSlam, JointState, Real, ScPhd, State,
};
use std::panic::{self, AssertUnwindSafe};

/// Vehicle type in all snapshots.
const KIND: u32 = 9;
/// Bytes of the header: eight words and their checksum.
const HEAD: usize = 36;
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A filter or part of one with certain capacities that is saved and restored.
trait Kind {
    /// A snapshot after some steps of a drive.
    fn save(draw: &mut Draw) -> Vec<u8>;
    /// Restores these bytes over a state, and continues if possible. Returns an error if anything is wrong.
    fn restore(draw: &mut Draw, bytes: &[u8], source: &Source) -> Result<(), String>;
}

/// The behaviour of a source of bytes: it may fail or change at a later read.
#[derive(Debug, Clone, Copy)]
struct Source {
    /// Index of the read that fails, and whether it gives wrong bytes instead.
    fails: Option<(usize, bool)>,
}

impl Source {
    fn over(self, bytes: &[u8]) -> impl FnMut(usize, &mut [u8]) -> Result<(), SliceEnd> {
        let (mut readings, mut source) = (0, from_slice(bytes));
        move |at, into: &mut [u8]| {
            readings += 1;
            source(at, into)?;
            match self.fails {
                Some((reading, false)) if reading == readings => Err(SliceEnd),
                Some((reading, true)) if reading == readings => {
                    if let Some(byte) = into.last_mut() {
                        *byte ^= 0x41;
                    }
                    Ok(())
                }
                _ => Ok(()),
            }
        }
    }
}

/// Saves to a vector.
fn bytes_of<E: std::fmt::Debug>(
    save: impl FnOnce(&mut dyn FnMut(&[u8]) -> Result<(), SliceEnd>) -> Result<usize, E>,
) -> Result<Vec<u8>, E> {
    let mut bytes = Vec::new();
    save(&mut |piece| {
        bytes.extend_from_slice(piece);
        Ok(())
    })?;
    Ok(bytes)
}

fn robot<T: Real>() -> Models<<Rover<T> as World>::Motion, <Rover<T> as World>::Sensing> {
    let mut calm = Draw::new(3, 0.0);
    loop {
        if let Ok(models) = Rover::<T>::models(&mut calm) {
            return models;
        }
    }
}

/// Random detections of some landmarks from a pose, with some false measurements.
fn seen<T: Real>(draw: &mut Draw, pose: &PlanarPose<T>, sensing: &<Rover<T> as World>::Sensing) -> Vec<Vector2<T>> {
    let frame = sensing.sensor.frame(pose);
    let mut places = Draw::new(77, 0.0);
    let mut scan = Vec::new();
    for _ in 0..7 {
        let at = [places.even(-9.0, 9.0), places.even(-9.0, 9.0)].map(T::from_f64);
        if let Some(expected) = sensing.sensor.expect(&frame, &Vector2::from(at)).filter(|_| draw.chance(0.9)) {
            let off = [draw.even(-0.1, 0.1), draw.even(-0.01, 0.01)].map(T::from_f64);
            scan.push(expected.measurement + Vector2::from(off));
        }
    }
    for _ in 0..draw.below(2) {
        scan.push(Rover::<T>::clutter(draw));
    }
    // The pose of an accepted snapshot may be arbitrary.
    scan.retain(|z| z.iter().all(|number| number.is_finite()));
    scan
}

/// A mixture with moving features, with or without the informed proposal.
struct Mixture<T, const N: usize, const PAGES: usize, const MAP: usize, const INFORMED: bool>(
    std::marker::PhantomData<T>,
);

impl<T: Real, const N: usize, const PAGES: usize, const MAP: usize, const INFORMED: bool> Kind
    for Mixture<T, N, PAGES, MAP, INFORMED>
{
    fn save(draw: &mut Draw) -> Vec<u8> {
        let mut state = Self::state();
        let mut slam = ScPhd::new(robot::<T>().motion, Self::config(), &mut *state).expect("it fits");
        slam.reset(PlanarPose::ZERO, draw.word()).expect("a pose");
        Self::drive(draw, &mut slam, 1 + draw.clone().below(6)).expect("a plain drive");
        bytes_of(|sink| slam.save(KIND, sink)).expect("a sound state is saved")
    }

    fn restore(draw: &mut Draw, bytes: &[u8], source: &Source) -> Result<(), String> {
        let mut state = Self::state();
        let mut slam = ScPhd::new(robot::<T>().motion, Self::config(), &mut *state).expect("it fits");
        slam.reset(PlanarPose::ZERO, 3).expect("a pose");
        let before = slam.digest();
        let outcome = slam.restore(KIND, source.over(bytes));
        count("mixture", &outcome);
        slam.audit().map_err(|flaw| format!("{outcome:?} leaves {flaw}"))?;
        if outcome.is_err() {
            let kept = slam.digest() == before;
            return require(kept || slam.candidates().is_empty(), || format!("{outcome:?} leaves another state"));
        }
        Self::drive(draw, &mut slam, 3)?;
        slam.audit().map_err(|flaw| format!("driven on to {flaw}"))?;
        bytes_of(|sink| slam.save(KIND, sink)).map(drop).map_err(|error| format!("not saved again: {error}"))
    }
}

type Movers<T, const N: usize, const PAGES: usize, const MAP: usize> = State<
    PlanarPose<T>,
    N,
    N,
    MapMemory<Static<Vector2<T>>, N, PAGES, MAP, 24>,
    MapMemory<Dynamic<Vector2<T>>, N, 6, 3, 24>,
>;

impl<T: Real, const N: usize, const PAGES: usize, const MAP: usize, const INFORMED: bool>
    Mixture<T, N, PAGES, MAP, INFORMED>
{
    fn state() -> Box<Movers<T, N, PAGES, MAP>> {
        Box::new(State::new())
    }

    fn config() -> Config<T> {
        if INFORMED { Config::informed(N) } else { Config::blind(N, 1) }
    }

    fn drive(draw: &mut Draw, slam: &mut ScPhd<'_, <Rover<T> as World>::Motion>, steps: usize) -> Result<(), String> {
        let sensing = robot::<T>().sensing;
        let mut scratch = DetectorMemory::<Vector2<T>, 16>::new();
        let births = Births { of_static: T::from_f64(0.01), of_moving: T::from_f64(0.002) };
        let eyes = Detector::new(sensing, births).map_err(|error| error.to_string())?;
        let mut eyes = eyes.over(&mut scratch).map_err(|error| error.to_string())?;
        for _ in 0..steps {
            let _ = slam.predict(&Rover::<T>::control(draw, &PlanarPose::ZERO), T::from_f64(0.1));
            let Some(pose) = slam.estimate_pose() else { return Err("no pose".into()) };
            let scan = seen(draw, &pose.mean, &sensing);
            slam.scan(&mut eyes, &scan).map_err(|error| error.to_string())?;
        }
        Ok(())
    }
}

/// A joint map; with an archive if its capacity is not zero.
struct Joint<T, const F: usize, const NUMBERS: usize, const ARCHIVE: usize>(std::marker::PhantomData<T>);

impl<T: Real, const F: usize, const NUMBERS: usize, const ARCHIVE: usize> Kind for Joint<T, F, NUMBERS, ARCHIVE> {
    fn save(draw: &mut Draw) -> Vec<u8> {
        Self::over(|slam| {
            slam.reset(PlanarPose::ZERO).expect("a pose");
            let steps = 1 + draw.below(6);
            Self::drive(draw, slam, steps).expect("a plain drive");
            bytes_of(|sink| slam.save(KIND, sink)).expect("a sound state is saved")
        })
    }

    fn restore(draw: &mut Draw, bytes: &[u8], source: &Source) -> Result<(), String> {
        Self::over(|slam| {
            slam.reset(PlanarPose::ZERO).expect("a pose");
            let before = slam.digest();
            let outcome = slam.restore(KIND, source.over(bytes));
            count("joint map", &outcome);
            slam.audit().map_err(|flaw| format!("{outcome:?} leaves {flaw}"))?;
            if outcome.is_err() {
                let kept = slam.digest() == before;
                return require(kept || slam.estimate_pose().is_none(), || format!("{outcome:?} leaves another state"));
            }
            Self::drive(draw, slam, 3)?;
            // Numbers that are valid separately, but not together, may lead to an invalid state. Saving then reports it, and
            // scrubbing repairs it or reports that it cannot.
            let driven = slam.audit();
            count("joint map driven on", &driven);
            let saved = bytes_of(|sink| slam.save(KIND, sink));
            require(saved.is_ok() == driven.is_ok(), || format!("{driven:?}, and saved: {:?}", saved.err()))?;
            for _ in 0..2 * (F + ARCHIVE + 2) {
                if slam.scrub(&mut Scrubber::new(), F + ARCHIVE + 2).is_err() {
                    return Ok(());
                }
            }
            slam.audit().map_err(|flaw| format!("scrubbed, and still {flaw}"))
        })
    }
}

type Window<'s, T> =
    JointSlam<'s, <Rover<T> as World>::Motion, Vector2<T>, scphd::storage::Archived<'s, PlanarPose<T>>>;

impl<T: Real, const F: usize, const NUMBERS: usize, const ARCHIVE: usize> Joint<T, F, NUMBERS, ARCHIVE> {
    fn over<R>(work: impl FnOnce(&mut Window<'_, T>) -> R) -> R {
        let mut state = Box::new(JointState::<PlanarPose<T>, Vector2<T>, F, NUMBERS, 16>::new());
        let mut archive = Box::new(JointArchive::<PlanarPose<T>, ARCHIVE>::new());
        let slam = JointSlam::new(robot::<T>().motion, JointConfig::default(), &mut *state).expect("a plain filter");
        let mut slam = slam.with_archive(&mut archive, T::from_f64(4.0)).expect("a reach");
        work(&mut slam)
    }

    fn drive(draw: &mut Draw, slam: &mut Window<'_, T>, steps: usize) -> Result<(), String> {
        let sensing = robot::<T>().sensing;
        let eyes = Detector::new(sensing, Births::of_static(T::from_f64(0.01))).map_err(|error| error.to_string())?;
        for _ in 0..steps {
            let _ = slam.predict(&Rover::<T>::control(draw, &PlanarPose::ZERO), T::from_f64(0.1));
            let Some(pose) = slam.estimate_pose() else { return Err("no pose".into()) };
            let scan = seen(draw, &pose.mean, &sensing);
            slam.scan(&eyes, &scan).map_err(|error| error.to_string())?;
        }
        Ok(())
    }
}

struct Map<T, const ROOM: usize>(std::marker::PhantomData<T>);

impl<T: Real, const ROOM: usize> Kind for Map<T, ROOM> {
    fn save(draw: &mut Draw) -> Vec<u8> {
        let map: Vec<Component<Vector2<T>>> = (0..draw.below(9))
            .map(|label| Component {
                label: label as u32,
                ln_weight: draw.real(-2.0, 0.0),
                mean: Vector2::new(draw.real(-50.0, 50.0), draw.real(-50.0, 50.0)),
                covariance: Symmetric::from_diagonal([T::from_f64(0.01), T::from_f64(0.04)]),
            })
            .collect();
        bytes_of(|sink| save_map(KIND, map.iter().copied(), sink)).expect("a sound map is saved")
    }

    fn restore(_: &mut Draw, bytes: &[u8], source: &Source) -> Result<(), String> {
        let held = Component::<Vector2<T>> { label: 7, ..Component::ZERO };
        let mut map = vec![held; ROOM];
        let outcome: Result<usize, RestoreError<SliceEnd>> = restore_map(KIND, &mut map, source.over(bytes));
        count("map", &outcome);
        let Ok(len) = outcome else { return Ok(()) };
        require(len <= ROOM && map[len..].iter().all(|slot| *slot == held), || "beyond what was read".into())?;
        let sound = map[..len].iter().all(|c| c.covariance.factor().is_some() && c.mean.iter().all(|x| x.is_finite()));
        require(sound, || format!("taken: {map:?}"))
    }
}

/// The velocity filter of a vehicle under water.
struct Beside<T>(std::marker::PhantomData<T>);

impl<T: Real> Kind for Beside<T> {
    fn save(draw: &mut Draw) -> Vec<u8> {
        let mut navigator = Self::navigator();
        Self::dive(draw, &mut navigator).expect("a plain dive");
        bytes_of(|sink| navigator.save(KIND, sink)).expect("a sound state is saved")
    }

    fn restore(draw: &mut Draw, bytes: &[u8], source: &Source) -> Result<(), String> {
        let mut navigator = Self::navigator();
        let before = navigator;
        let outcome = navigator.restore(KIND, source.over(bytes));
        count("navigator", &outcome);
        if outcome.is_err() {
            return require(navigator == before, || format!("{outcome:?} changed it"));
        }
        // Arbitrary valid numbers may lead to an invalid state; saving then reports it.
        let _ = Self::dive(draw, &mut navigator);
        let _ = bytes_of(|sink| navigator.save(KIND, sink));
        Ok(())
    }
}

impl<T: Real> Beside<T> {
    fn navigator() -> Navigator<T> {
        let noise = VelocityNoise {
            walk_mps_rts: T::from_f64(0.1),
            dvl_sigma_mps: T::from_f64(0.1),
            z_sigma_m: T::from_f64(0.02),
            gate_sigmas: T::from_f64(4.0),
            outliers_believed: 5,
        };
        Navigator::new(noise, T::from_f64(-2.0), [T::ZERO; 2]).expect("a plain navigator")
    }

    fn dive(draw: &mut Draw, navigator: &mut Navigator<T>) -> Result<(), String> {
        for _ in 0..1 + draw.below(8) {
            let row = Instruments {
                roll_rad: draw.real(-0.1, 0.1),
                pitch_rad: draw.real(-0.1, 0.1),
                yaw_rate_radps: Reading { value: draw.real(-0.2, 0.2), sigma: T::from_f64(0.02) },
                velocity_mps: draw.chance(0.7).then(|| [draw.real(-1.0, 1.0), T::ZERO, T::ZERO]),
                z_m: draw.chance(0.7).then(|| draw.real(-2.5, -1.5)),
            };
            navigator.instruments(&row, T::from_f64(0.1)).map_err(|error| error.to_string())?;
        }
        Ok(())
    }
}

/// A mixture under water, whose poses have more coordinates.
struct Dive;

type DiveState = State<scphd::models::AuvPose<f32>, 2, 2, MapMemory<Static<Vector3<f32>>, 2, 6, 4, 24>>;

impl Kind for Dive {
    fn save(draw: &mut Draw) -> Vec<u8> {
        let mut state = Box::new(DiveState::new());
        let models = Self::models();
        let mut slam = ScPhd::new(models.motion, Config::informed(2), &mut *state).expect("it fits");
        slam.reset(scphd::models::AuvPose::new(1.0, 2.0, -3.0, 0.4), draw.word()).expect("a pose");
        for _ in 0..3 {
            let at = slam.candidates()[0].pose;
            let _ = slam.predict(&Diver::<f32>::control(draw, &at), 0.1);
        }
        bytes_of(|sink| slam.save(KIND, sink)).expect("a sound state is saved")
    }

    fn restore(draw: &mut Draw, bytes: &[u8], source: &Source) -> Result<(), String> {
        let mut state = Box::new(DiveState::new());
        let models = Self::models();
        let mut slam = ScPhd::new(models.motion, Config::informed(2), &mut *state).expect("it fits");
        let outcome = slam.restore(KIND, source.over(bytes));
        count("mixture under water", &outcome);
        slam.audit().map_err(|flaw| format!("{outcome:?} leaves {flaw}"))?;
        if outcome.is_err() {
            return require(slam.candidates().is_empty(), || format!("{outcome:?} leaves a state"));
        }
        let mut scratch = DetectorMemory::<nalgebra::Vector4<f32>, 8>::new();
        let eyes = Detector::new(models.sensing, Births::of_static(1e-4)).map_err(|error| error.to_string())?;
        let mut eyes = eyes.over(&mut scratch).map_err(|error| error.to_string())?;
        for _ in 0..2 {
            let at = slam.candidates()[0].pose;
            let _ = slam.predict(&Diver::<f32>::control(draw, &at), 0.1);
            let scan = [Diver::<f32>::clutter(draw), Diver::<f32>::clutter(draw)];
            slam.scan(&mut eyes, &scan).map_err(|error| error.to_string())?;
        }
        slam.audit().map_err(|flaw| format!("driven on to {flaw}"))
    }
}

impl Dive {
    fn models() -> Models<<Diver<f32> as World>::Motion, <Diver<f32> as World>::Sensing> {
        let mut calm = Draw::new(5, 0.0);
        loop {
            if let Ok(models) = Diver::<f32>::models(&mut calm) {
                return models;
            }
        }
    }
}

type Save = fn(&mut Draw) -> Vec<u8>;
type Restore = fn(&mut Draw, &[u8], &Source) -> Result<(), String>;

/// The kinds; some have the same content with other capacities and scalars.
const KINDS: [(&str, Save, Restore); 13] = {
    const fn of<K: Kind>(name: &'static str) -> (&'static str, Save, Restore) {
        (name, K::save, K::restore)
    }
    [
        of::<Mixture<f32, 3, 8, 3, false>>("mixture of three"),
        of::<Mixture<f32, 2, 4, 2, false>>("mixture of two"),
        of::<Mixture<f32, 3, 8, 3, true>>("informed mixture"),
        of::<Mixture<f64, 3, 8, 3, false>>("mixture in double precision"),
        of::<Joint<f32, 5, { joint_numbers(3, 2, 5) }, 0>>("joint map"),
        of::<Joint<f32, 2, { joint_numbers(3, 2, 2) }, 0>>("joint map of two"),
        of::<Joint<f32, 4, { joint_numbers(3, 2, 4) }, 6>>("joint map with an archive"),
        of::<Joint<f64, 5, { joint_numbers(3, 2, 5) }, 6>>("joint map in double precision"),
        of::<Map<f32, 8>>("map"),
        of::<Map<f64, 4>>("map in double precision"),
        of::<Beside<f32>>("navigator"),
        of::<Beside<f64>>("navigator in double precision"),
        of::<Dive>("mixture under water"),
    ]
};

/// Corrects both checksums, if the snapshot is long enough for them.
fn seal(bytes: &mut [u8]) {
    let end = bytes.len().saturating_sub(4);
    if end < HEAD {
        return;
    }
    let head = CRC.checksum(&bytes[..HEAD - 4]).to_le_bytes();
    bytes[HEAD - 4..HEAD].copy_from_slice(&head);
    let mut check = CRC.digest();
    check.update(&bytes[..HEAD - 4]);
    check.update(&bytes[HEAD..end]);
    let whole = check.finalize().to_le_bytes();
    bytes[end..].copy_from_slice(&whole);
}

/// Words that no filter writes, or that are near limits.
const STRANGE: [u32; 16] = [
    0,
    1,
    2,
    3,
    8,
    0xffff,
    1 << 31,
    1 << 31 | 8,
    1 << 31 | 9,
    u32::MAX,
    0x7fc0_0000,
    0x7f80_0000,
    0xff80_0000,
    0x7f7f_ffff,
    0x3f80_0000,
    0x0000_8000,
];

/// Damages a snapshot. Returns a description.
fn damage(draw: &mut Draw, bytes: &mut Vec<u8>, other: &[u8]) -> &'static str {
    let len = bytes.len().max(1);
    match draw.below(10) {
        0 => "as it is",
        1 => {
            for _ in 0..1 + draw.below(8) {
                let bit = draw.below(8 * len);
                bytes.iter_mut().skip(bit / 8).take(1).for_each(|byte| *byte ^= 1 << (bit % 8));
            }
            "bits flipped"
        }
        2 => {
            bytes.truncate(draw.below(len));
            "cut"
        }
        3 => {
            let at = draw.below(len);
            bytes.splice(at.., other.iter().skip(at).copied());
            "glued to another"
        }
        4 => {
            bytes.extend_from_slice(other);
            "with another behind it"
        }
        5 => {
            // Version, content, scalar, vehicle type, dimensions, flags, length and sizes.
            let word = 1 + draw.below(7);
            let strange = STRANGE[draw.below(STRANGE.len())].to_le_bytes();
            let byte = 4 * word + draw.below(4);
            if draw.chance(0.5) {
                bytes.iter_mut().skip(byte).take(1).for_each(|slot| *slot = slot.wrapping_add(1));
            } else {
                bytes.iter_mut().skip(4 * word).zip(strange).for_each(|(slot, byte)| *slot = byte);
            }
            "another head"
        }
        6 => {
            let from = draw.below(len);
            let to = (from + 1 + draw.below(64)).min(bytes.len());
            bytes.drain(from.min(to)..to);
            "a piece left out"
        }
        7 => {
            let from = draw.below(len);
            let piece: Vec<u8> = bytes.iter().skip(from).take(1 + draw.below(64)).copied().collect();
            bytes.splice(from..from, piece);
            "a piece twice"
        }
        _ => {
            for _ in 0..1 + draw.below(4) {
                let word = draw.below(len / 4 + 1);
                let with = if draw.chance(0.5) {
                    STRANGE[draw.below(STRANGE.len())]
                } else {
                    (draw.even(-100.0, 100.0) as f32).to_bits()
                };
                bytes.iter_mut().skip(4 * word).zip(with.to_le_bytes()).for_each(|(slot, byte)| *slot = byte);
            }
            "words replaced"
        }
    }
}

fn run(seeded: Seeded, operations: &Operations<'_>, watch: &Watch) -> Result<(), Failure> {
    for &index in operations.indices {
        watch.at(seeded.seed, index);
        let mut draw = seeded.draw(index);
        let mut calm = Draw::new(draw.word(), 0.0);
        let [(name, save, restore), (of_other, save_other, into_other)] =
            [draw.below(KINDS.len()), draw.below(KINDS.len())].map(|kind| KINDS[kind]);
        let mut bytes = save(&mut calm);
        let other = save_other(&mut calm);
        let damaged = damage(&mut draw, &mut bytes, &other);
        let sealed = draw.chance(0.7);
        if sealed {
            seal(&mut bytes);
        }
        let source = Source { fails: draw.chance(0.1).then(|| (1 + draw.below(40), draw.chance(0.5))) };
        let (into, restore) = if draw.chance(0.85) { (name, restore) } else { (of_other, into_other) };
        if operations.tell {
            println!("  {index}: {name} {damaged}, {of_other}; sealed {sealed}, {source:?}, into {into}");
        }
        let done = panic::catch_unwind(AssertUnwindSafe(|| restore(&mut calm, &bytes, &source)));
        let done = done.unwrap_or_else(|_| Err("a panic".into()));
        let told = |what| format!("{name} {damaged}, sealed {sealed}, {source:?}, into {into}: {what}");
        done.map_err(|what| Failure { operation: index, what: told(what) })?;
    }
    Ok(())
}

pub(super) fn kind_of(seed: u64) -> (String, Run) {
    let (seeded, _) = Seeded::of(seed, 0x54a9);
    ("snapshots".into(), Box::new(move |operations, watch| run(seeded, operations, watch)))
}

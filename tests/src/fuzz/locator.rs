//! Sessions of a locator: hostile maps, transformed views of them, and views of other places.

use super::counts::count;
use super::draw::Draw;
use super::session::Seeded;
use super::worlds::{Drawn, Rover, World};
use super::{Failure, Operations, Run, Watch, named};
use nalgebra::Vector2;
use scphd::errors::ConfigError;
use scphd::locate::{Locator, LocatorConfig, LocatorReport, LocatorState};
use scphd::models::{Mounting, PlanarPose, Pose};
use scphd::numerics::{Symmetric, wrap};
use scphd::{Births, Component, Detector, PoseEstimate, Real};
use std::fmt::Write;

type Landmark<T> = Component<Vector2<T>>;
type Eye<T> = Detector<<Rover<T> as World>::Sensing>;

/// A random configuration; out of range if one of its numbers is hostile.
fn config<T: Real>(draw: &mut Draw) -> LocatorConfig<T> {
    if draw.chance(0.3) {
        return LocatorConfig::default();
    }
    LocatorConfig {
        elsewhere: draw.real(0.01, 0.99),
        remains: draw.real(0.01, 0.99),
        new_share: draw.real(0.01, 0.99),
        inflation: draw.real(0.5, 4.0),
        gate: draw.real(1.0, 30.0),
        sure: draw.real(0.5, 0.999),
        least_matched: 1 + draw.below(6),
        least_share: draw.real(0.1, 0.9),
        trials: 1 + draw.below(60),
        searched: 1 + draw.below(6),
    }
}

fn eye<T: Real>(draw: &mut Draw) -> Option<Eye<T>> {
    let models = Rover::<T>::models(draw).ok()?;
    let detector = Detector::new(models.sensing, Births::of_static(T::from_f64(0.01))).ok()?;
    if !draw.chance(0.5) {
        return Some(detector);
    }
    let mounting: Mounting<T> = PlanarPose::<T>::mounting(draw).ok()?;
    detector.mounted(mounting).ok()
}

struct Session<T: Real> {
    features: usize,
    hypotheses: usize,
    map: Vec<Landmark<T>>,
    /// The pose of the vehicle's frame in the map, and the vehicle's pose in its frame.
    offset: [f64; 3],
    here: [f64; 3],
    told: String,
}

/// Runs a session with a state of these capacities.
fn run<T: Real, const F: usize, const H: usize>(
    seeded: Seeded,
    operations: &Operations<'_>,
    watch: &Watch,
) -> Result<(), Failure> {
    let mut state = Box::new(LocatorState::<T, F, H>::new());
    let mut session =
        Session { features: F, hypotheses: H, map: Vec::new(), offset: [0.0; 3], here: [0.0; 3], told: String::new() };
    let (mut setup, mut calm) = (Draw::new(seeded.seed, seeded.hostility), Draw::new(seeded.seed, 0.0));
    let mut left = operations.indices.iter().copied().peekable();
    while left.peek().is_some() {
        let tuning = loop {
            let drawn = config::<T>(if setup.chance(0.9) { &mut setup } else { &mut calm });
            let checked: Result<(), ConfigError> = drawn.check();
            count("set up", &checked);
            if checked.is_ok() {
                break drawn;
            }
        };
        let mut eyes = loop {
            if let Some(eyes) = eye::<T>(if setup.chance(0.5) { &mut setup } else { &mut calm }) {
                break eyes;
            }
        };
        let locator = Locator::new(tuning, &mut *state);
        let mut locator = locator.map_err(|error| Failure { operation: 0, what: error.to_string() })?;
        for index in left.by_ref() {
            watch.at(seeded.seed, index);
            let mut draw = seeded.draw(index);
            session.told.clear();
            let other = draw.below(100);
            let done = match other {
                0..12 => session.load(&mut locator, &mut draw),
                12..16 => {
                    locator.restart();
                    session.begin(&mut draw);
                    Ok(())
                }
                16..20 => {
                    if let Some(other) = eye(&mut draw) {
                        eyes = other;
                    }
                    Ok(())
                }
                _ => session.look(&mut locator, &tuning, &eyes, &mut draw),
            };
            if operations.tell {
                println!("  {index}: {}", session.told);
            }
            done.map_err(|what| Failure { operation: index, what })?;
            if other >= 97 {
                break;
            }
        }
    }
    Ok(())
}

fn component<T: Real>(draw: &mut Draw, label: u32, [x, y]: [f64; 2], sigma: f64) -> Landmark<T> {
    let mut number = |plausible: f64| T::from_f64(draw.spoilt(plausible));
    let mean = Vector2::new(number(x), number(y));
    let variance = sigma * sigma;
    let covariance = Symmetric::from_fn(|row, column| number(if row == column { variance } else { 0.2 * variance }));
    Component { label, ln_weight: number(-0.05), mean, covariance }
}

/// Transforms a point of the map to the frame at this pose.
fn seen_from([x, y, turn]: [f64; 3], [px, py]: [f64; 2]) -> [f64; 2] {
    let (sine, cosine) = turn.sin_cos();
    let (dx, dy) = (px - x, py - y);
    [cosine * dx + sine * dy, cosine * dy - sine * dx]
}

impl<T: Real> Session<T> {
    fn begin(&mut self, draw: &mut Draw) {
        self.offset = [draw.even(-30.0, 30.0), draw.even(-30.0, 30.0), draw.even(-3.0, 3.0)];
        self.here = [0.0; 3];
    }

    fn load(&mut self, locator: &mut Locator<'_, T>, draw: &mut Draw) -> Result<(), String> {
        let count_of = draw.below(self.features + 2);
        let extent = draw.magnitude(1.0, 1e3);
        let regular = draw.chance(0.1);
        let map: Vec<Landmark<T>> = (0..count_of)
            .map(|index| {
                let drawn = [draw.even(-extent, extent), draw.even(-extent, extent)];
                // Sometimes in rows.
                let grid = [(index % 4) as f64 * 3.0, (index / 4) as f64 * 3.0];
                let sigma = draw.magnitude(1e-3, 0.3);
                component(draw, index as u32, if regular { grid } else { drawn }, sigma)
            })
            .collect();
        let outcome = locator.load_map(&map);
        count("load a map", &outcome);
        let _ = self.told.write_fmt(format_args!("load_map({map:?}): {outcome:?}"));
        if outcome.is_ok() {
            self.map = map;
            self.begin(draw);
        }
        Ok(())
    }

    fn look(
        &mut self,
        locator: &mut Locator<'_, T>,
        tuning: &LocatorConfig<T>,
        eyes: &Eye<T>,
        draw: &mut Draw,
    ) -> Result<(), String> {
        self.here = [
            self.here[0] + draw.even(-1.0, 1.0),
            self.here[1] + draw.even(-1.0, 1.0),
            wrap(self.here[2] + draw.even(-0.5, 0.5)),
        ];
        let sigma = draw.magnitude(1e-3, 0.2);
        let shown = draw.even(0.0, 1.0);
        let mut landmarks: Vec<Landmark<T>> = Vec::new();
        for (label, known) in self.map.clone().iter().enumerate() {
            if draw.chance(shown) {
                let place = seen_from(self.offset, [known.mean.x.to_f64(), known.mean.y.to_f64()]);
                let noisy = place.map(|at| at + sigma * draw.even(-1.7, 1.7));
                landmarks.push(component(draw, label as u32, noisy, sigma));
            }
        }
        for label in 0..draw.below(4) {
            let place = [draw.even(-40.0, 40.0), draw.even(-40.0, 40.0)];
            landmarks.push(component(draw, 1000 + label as u32, place, sigma));
        }
        if draw.chance(0.02) {
            landmarks.extend_from_within(..);
        }
        let [x, y, heading] = self.here.map(|number| T::from_f64(draw.spoilt(number)));
        let covariance =
            Symmetric::from_fn(|row, column| T::from_f64(draw.spoilt(if row == column { sigma * sigma } else { 0.0 })));
        let pose = PoseEstimate { mean: PlanarPose::new(x, y, heading), covariance };
        let usable = landmarks.iter().filter(|landmark| is_usable(landmark)).count();
        let report = locator.update(eyes, &pose, landmarks.iter().copied());
        let _ = self.told.write_fmt(format_args!("look({pose:?}, {landmarks:?}): {report:?}"));
        count::<_, ()>(if report.found.is_some() { "look and find" } else { "look" }, &Ok(()));
        self.check(&report, tuning, &pose, landmarks.len(), usable)
    }

    fn check(
        &self,
        report: &LocatorReport<T>,
        tuning: &LocatorConfig<T>,
        pose: &PoseEstimate<PlanarPose<T>>,
        landmarks: usize,
        usable: usize,
    ) -> Result<(), String> {
        let require = |holds: bool, what: &str| if holds { Ok(()) } else { Err(format!("{what}: {report:?}")) };
        let share = |p: T| p >= T::ZERO && p <= T::from_f64(1.001);
        require(share(report.elsewhere), "elsewhere is no probability")?;
        require(report.hypotheses <= self.hypotheses, "more places than there is room for")?;
        require(report.landmarks <= self.features && report.landmarks + report.left_out <= landmarks, "landmarks")?;
        require(report.landmarks + report.left_out >= usable, "a landmark is lost")?;
        require(report.trials <= tuning.trials, "more trials than are allowed")?;
        require(
            report.likeliest.is_some() == (report.hypotheses > 0),
            "a place without a hypothesis, or none with one",
        )?;
        if let Some(place) = &report.likeliest {
            require(share(place.probability), "no probability")?;
            require(place.probability + report.elsewhere <= T::from_f64(1.001), "probabilities sum to more than one")?;
            require(
                place.matched <= report.landmarks && place.matched <= self.map.len(),
                "more matches than landmarks",
            )?;
            let finite = pose.mean.is_finite_here() && pose.covariance.is_finite();
            let placed = place.pose.mean.is_finite() && place.pose.covariance.is_finite();
            // A pose that is not a number is passed on.
            require(!finite || placed, "a place that is no number")?;
        }
        if let Some(found) = &report.found {
            require(Some(*found) == report.likeliest, "what is found is not the likeliest")?;
            require(found.pose.mean.is_finite_here(), "a place beyond every range")?;
            require(found.probability >= tuning.sure && found.matched >= tuning.least_matched, "found and not sure")?;
            require(report.searched >= tuning.searched, "found before all was searched")?;
        }
        Ok(())
    }
}

/// Whether the numbers of a pose are finite and at most 1e8.
trait Here {
    fn is_finite_here(&self) -> bool;
}

impl<T: Real> Here for PlanarPose<T> {
    fn is_finite_here(&self) -> bool {
        [self.x_m, self.y_m, self.heading_rad].iter().all(|number| number.abs() <= T::from_f64(1e8))
    }
}

/// Whether the library may use this landmark; it may ignore the others.
fn is_usable<T: Real>(landmark: &Landmark<T>) -> bool {
    let plain = |number: T| number.abs() <= T::from_f64(1e4);
    let [a, b] = [landmark.covariance.get(0, 0), landmark.covariance.get(1, 1)];
    let off = landmark.covariance.get(1, 0);
    let spread = |variance: T| variance >= T::from_f64(1e-7) && variance <= T::ONE;
    landmark.mean.iter().all(|&at| plain(at))
        && landmark.ln_weight.abs() <= T::ONE
        && spread(a)
        && spread(b)
        && off * off < a * b * T::from_f64(0.5)
}

/// The kinds of sessions: a scalar, and capacities for landmarks and hypotheses.
macro_rules! sessions {
    ($choice:expr; $($t:ident: $($f:literal $h:literal)*;)*) => {{
        let mut kinds: Vec<(String, fn(Seeded, &Operations<'_>, &Watch) -> Result<(), Failure>)> = Vec::new();
        $($(kinds.push((
            format!("locator, {}: {} landmarks, {} places", stringify!($t), $f, $h),
            run::<$t, $f, $h>,
        ));)*)*
        kinds.swap_remove($choice % kinds.len())
    }};
}

/// The kind of session of a seed.
pub(super) fn kind_of(seed: u64) -> (String, Run) {
    let (seeded, mut draw) = Seeded::of(seed, 0x10ca);
    let (name, run) = sessions!(draw.below(1 << 20); f32: 3 2 4 3 8 2 12 8 24 16; f64: 3 2 8 4 20 6;);
    named(&name, seeded, run)
}

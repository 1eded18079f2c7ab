//! The filter behind a sequencer: takes inputs in any order, gives estimates after every scan and fix. Independent of the
//! middleware.

use crate::maps::{self, Search};
use crate::setup::{Order, Setup};
use nalgebra::{Vector1, Vector2};
use scphd::models::{PlanarMotion, PlanarPose};
use scphd::{Health, PoseEstimate};
use scphd_sequencer::{
    Action, Flags, MapFromOdom, PushError, Sequencer, Settings, SettingsError, SmoothOdometry, Stamp,
};
use scphd_vehicle::{Control, Measurements, Scanned, SensorModel, Services, Start, StartError, VehicleKind};
use std::time::{Duration, Instant};

/// Greatest number of nanoseconds that double precision represents exactly. Later times are relative to the first input, as in an
/// import.
const EXACT_NS: u64 = 1 << 53;
const SECOND_NS: u64 = 1_000_000_000;
/// Least window of the sequencer: inputs that arrive late by less than this are used, ns.
const LATEST_NS: u64 = 2 * SECOND_NS;
/// Capacities of the queue: odometry, events.
const CONTROLS: usize = 4096;
const EVENTS: usize = 1024;
/// Source numbers of fixes and of the first sensor: at equal times fixes come first, as in a log.
const FIXES: u8 = 1;
const SENSORS: u8 = 2;

/// A scan or a fix.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A scan of a sensor: ranges, m, and bearings, rad.
    Scan(usize, Vec<Vector2<f32>>),
    /// A measured position, m.
    Position([f32; 2]),
    /// A measured heading, rad.
    Heading(f32),
}

/// An input that has arrived.
enum Input {
    Control(Control<f32>),
    Event(Event),
}

/// The estimate after a scan or a fix.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The time of the input, ns.
    pub stamp_ns: u64,
    /// Whether the input was a scan.
    pub of_scan: bool,
    pub pose: PoseEstimate<PlanarPose<f32>>,
    /// The pose of odometry alone at that time.
    pub smooth: PlanarPose<f32>,
    /// The transform from the odometry frame to the map.
    pub map_from_odom: MapFromOdom<PlanarPose<f32>>,
    /// The last control.
    pub control: Control<f32>,
    /// Warnings of the scan.
    pub health: Health,
}

/// Numbers of inputs since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Scans that were used.
    pub scans: u64,
    /// Fixes that were used.
    pub fixes: u64,
    /// Fixes that were outliers.
    pub outliers: u64,
    /// Inputs that the filter refused.
    pub refused: u64,
    /// Inputs that came too late, twice, or across a jump of the clock.
    pub dropped: u64,
    /// Intervals without odometry that were too long.
    pub gaps: u64,
}

/// The reason why an engine cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// The description.
    #[error("{0}")]
    Start(StartError),
    /// The waiting times.
    #[error("order: {0}")]
    Order(#[from] SettingsError),
    /// The start pose.
    #[error("the pose at the start: {0}")]
    Reset(#[from] scphd::errors::ResetError),
    /// The vehicle.
    #[error("{0}")]
    Model(#[from] scphd::models::ModelError),
}

impl From<StartError> for EngineError {
    fn from(error: StartError) -> Self {
        Self::Start(error)
    }
}

type Queue = Sequencer<Option<Control<f32>>, Event, CONTROLS, EVENTS>;

/// A filter with a sequencer for its inputs.
pub struct Engine {
    setup: Setup,
    slam: Box<dyn Services<f32>>,
    motion: PlanarMotion<f32>,
    queue: Box<Queue>,
    smooth: SmoothOdometry<PlanarPose<f32>>,
    /// Stamp at which the filter's time is zero; `None` before the first input.
    origin_ns: Option<u64>,
    control: Control<f32>,
    newest_ns: u64,
    /// The newest odometry stamp.
    driven_ns: Option<u64>,
    /// Stamps of waiting events, and when each arrived.
    pending: Vec<(u64, Instant)>,
    arrived: Vec<(u64, Input)>,
    number: u32,
    search: Option<Search>,
    counts: Counts,
    flags: Flags,
    health: Health,
}

impl std::fmt::Debug for Engine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Engine").field("setup", &self.setup).field("counts", &self.counts).finish_non_exhaustive()
    }
}

fn ns(seconds: f64) -> u64 {
    // At most 10⁹ s.
    (seconds * 1e9).round() as u64
}

fn settings(order: &Order) -> Settings {
    let window_ns = ns(order.wait_s).max(LATEST_NS);
    let jump_ns = ns(order.jump_s).max(window_ns + 1);
    Settings { window_ns, gap_ns: ns(order.gap_s), jump_ns, ..Settings::DEFAULT }
}

impl Engine {
    /// An engine at its start.
    pub fn new(setup: Setup) -> Result<Self, EngineError> {
        settings(&setup.wiring.order).check()?;
        let mut slam = crate::memory::start(&setup.description)?;
        slam.reset(&setup.description.start)?;
        Ok(Self {
            motion: setup.description.vehicle.drive()?,
            smooth: SmoothOdometry::new(setup.description.start.pose),
            setup,
            slam,
            queue: Box::new(Queue::new()),
            origin_ns: None,
            control: Control::STILL,
            newest_ns: 0,
            driven_ns: None,
            pending: Vec::new(),
            arrived: Vec::new(),
            number: 0,
            search: None,
            counts: Counts::default(),
            flags: Flags::NONE,
            health: Health::GOOD,
        })
    }

    /// Restarts with an empty map, and removes all waiting inputs.
    pub fn reset(&mut self) -> Result<(), EngineError> {
        self.slam.reset(&self.setup.description.start)?;
        self.smooth = SmoothOdometry::new(self.setup.description.start.pose);
        (self.origin_ns, self.driven_ns, self.newest_ns) = (None, None, 0);
        (self.flags, self.health, self.control) = (Flags::NONE, Health::GOOD, Control::STILL);
        self.pending.clear();
        self.arrived.clear();
        self.search = None;
        Ok(())
    }

    /// The number of features in the map, and the bytes of a map file.
    pub fn map(&mut self) -> Result<(usize, Vec<u8>), maps::Refused> {
        let features = maps::known(&mut *self.slam);
        Ok((features.len(), maps::bytes(&features)?))
    }

    /// Replaces the map by that of a file, and keeps the pose. Returns the number of features.
    pub fn load_map(&mut self, bytes: &[u8]) -> Result<usize, maps::Refused> {
        let features = maps::features(bytes)?;
        self.slam.load_map(&features).map_err(|error| error.to_string())?;
        Ok(features.len())
    }

    /// Starts global localisation in the map of a file. The filter maps in its own frame until the pose is found, and then
    /// continues in the frame of the file.
    pub fn locate(&mut self, bytes: &[u8]) -> Result<(), maps::Refused> {
        let search = Search::new(maps::features(bytes)?)?;
        self.slam.configure(&maps::careful(&self.setup.description)).map_err(|error| error.to_string())?;
        self.slam
            .reset(&Start { pose: PlanarPose::new(0.0, 0.0, 0.0), ..self.setup.description.start })
            .map_err(|error| error.to_string())?;
        self.search = Some(search);
        Ok(())
    }

    /// Whether global localisation is in progress.
    pub fn is_searching(&self) -> bool {
        self.search.is_some()
    }

    /// Time until the next waiting scan or fix is processed without odometry; `None` if none waits.
    pub fn patience(&self) -> Option<Duration> {
        let window = Duration::from_secs_f64(self.setup.wiring.order.window_s);
        let left = self.pending.iter().map(|(_, since)| window.saturating_sub(since.elapsed())).min();
        // An input far ahead of all others waits for a second one that confirms it.
        left.map(|left| left.max(Duration::from_millis(5)))
    }

    /// The present speed, m/s, and turn rate, rad/s. The turn rate of a car is given as 0, because its control is a steering
    /// angle.
    pub fn motion(&self) -> [f32; 2] {
        let is_car = self.setup.description.vehicle.kind == VehicleKind::Ackermann;
        [self.control.speed_mps, if is_car { 0.0 } else { self.control.turn }]
    }

    /// Continues global localisation after a scan of a sensor.
    fn look(&mut self, sensor: usize) {
        let Some(search) = &mut self.search else { return };
        let Some(described) = self.setup.description.sensors.get(sensor).and_then(Option::as_ref) else { return };
        let Some(place) = search.look(described, &mut *self.slam) else { return };
        let Some(search) = self.search.take() else { return };
        let start = Start { pose: place.mean, ..self.setup.description.start };
        let moved = self.slam.reset(&start).and_then(|()| self.slam.relocate(place.mean, &place.covariance));
        let loaded = self.slam.load_map(&search.into_map());
        self.counts.refused += u64::from(moved.is_err()) + u64::from(loaded.is_err());
    }

    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Changes the mounting of a sensor: position ahead and to the left of the pose, m, and rotation to the left, rad.
    pub fn seat(&mut self, sensor: usize, [forward_m, left_m, yaw_rad]: [f32; 3]) -> Result<(), StartError> {
        let mut description = self.setup.description;
        if let Some(sensor) = description.sensors.get_mut(sensor).and_then(Option::as_mut) {
            (sensor.seat_m, sensor.yaw_rad) = ([forward_m, left_m], yaw_rad);
        }
        self.slam.configure(&description)?;
        self.setup.description = description;
        Ok(())
    }

    /// The filter.
    pub fn slam(&mut self) -> &mut dyn Services<f32> {
        &mut *self.slam
    }

    /// Numbers of inputs since the start.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Returns and clears the warnings of stamps and scans since the last call.
    pub fn take_conditions(&mut self) -> (Flags, Health) {
        (std::mem::take(&mut self.flags), std::mem::replace(&mut self.health, Health::GOOD))
    }

    /// Adds odometry: a control that is valid from its stamp on.
    pub fn control(&mut self, stamp_ns: u64, control: Control<f32>) {
        self.arrived.push((stamp_ns, Input::Control(control)));
    }

    /// Adds a scan or a fix.
    pub fn event(&mut self, stamp_ns: u64, event: Event) {
        self.arrived.push((stamp_ns, Input::Event(event)));
    }

    /// Moves new inputs to the queue in the order of their stamps, because topics are read one after the other.
    fn sort(&mut self) {
        let mut arrived = std::mem::take(&mut self.arrived);
        arrived.sort_by_key(|(stamp_ns, _)| *stamp_ns);
        if let Some((first_ns, _)) = arrived.first() {
            self.begin(*first_ns);
        }
        for (stamp_ns, input) in arrived {
            let taken = match input {
                Input::Control(control) => {
                    self.driven_ns = self.driven_ns.max(Some(stamp_ns));
                    self.queue.push_control(Stamp::new(0, stamp_ns), Some(control))
                }
                Input::Event(event) => self.push(stamp_ns, event),
            };
            match taken {
                Ok(()) => self.newest_ns = self.newest_ns.max(stamp_ns),
                Err(_) => self.counts.dropped += 1,
            }
        }
    }

    fn push(&mut self, stamp_ns: u64, event: Event) -> Result<(), PushError> {
        let source = match &event {
            // Sensors are few enough.
            Event::Scan(sensor, _) => SENSORS.saturating_add(*sensor as u8),
            Event::Position(_) | Event::Heading(_) => FIXES,
        };
        self.number = self.number.wrapping_add(1);
        // A second scan with the same stamp is a duplicate; a second fix may be another one.
        let number = if source == FIXES { self.number } else { 0 };
        self.queue.push_event(Stamp::new(source, stamp_ns).numbered(number), event)?;
        self.pending.push((stamp_ns, Instant::now()));
        Ok(())
    }

    fn begin(&mut self, stamp_ns: u64) {
        if self.origin_ns.is_some() {
            return;
        }
        self.origin_ns = Some(if stamp_ns > EXACT_NS { stamp_ns / SECOND_NS * SECOND_NS } else { 0 });
        let settings = settings(&self.setup.wiring.order);
        // Other inputs may be earlier than the first one that arrived.
        let start_ns = stamp_ns.saturating_sub(settings.window_ns);
        // The settings were checked when the engine was created.
        let _started = self.queue.start(settings, start_ns, None);
    }

    /// Converts a stamp to the filter's time, s.
    fn seconds(&self, stamp_ns: u64) -> f64 {
        let origin_ns = self.origin_ns.unwrap_or(0);
        // Double precision represents both numbers exactly.
        if stamp_ns < origin_ns { -((origin_ns - stamp_ns) as f64 / 1e9) } else { (stamp_ns - origin_ns) as f64 / 1e9 }
    }

    /// Processes all inputs that are due, and reports every estimate.
    pub fn work(&mut self, tell: &mut dyn FnMut(&Estimate)) {
        self.sort();
        // Odometry arrives in the order of its stamps, so that an event is complete once odometry is as new.
        let Order { wait_s, window_s, .. } = self.setup.wiring.order;
        let until_ns = self.driven_ns.map(|driven| driven.min(self.newest_ns.saturating_sub(ns(wait_s))));
        let window = Duration::from_secs_f64(window_s);
        let complete = |(at, since): &&(u64, Instant)| until_ns >= Some(*at) || since.elapsed() >= window;
        if let Some((event_ns, _)) = self.pending.iter().filter(complete).max() {
            self.queue.complete_until(*event_ns);
        }
        loop {
            let before_ns = self.queue.time_ns();
            // The action borrows the queue, which is asked for its time afterwards.
            let event = match self.queue.next_action() {
                None => break,
                Some(Action::Predict { control, .. }) => Err((control, false)),
                Some(Action::Gap { control, .. }) => Err((control, true)),
                Some(Action::Event(event)) => Ok(event.clone()),
            };
            match event {
                Err((control, is_gap)) => {
                    self.counts.gaps += u64::from(is_gap);
                    self.drive(control, before_ns);
                }
                Ok(event) => self.take(&event, tell),
            }
        }
        let done_ns = self.queue.time_ns();
        if self.pending.len() > self.queue.waiting().1 {
            self.pending.retain(|(at, _)| *at > done_ns);
        }
        let report = self.queue.take_report();
        self.flags |= report.flags;
        if self.queue.waiting().1 == 0 || report.flags.contains(Flags::CLOCK_SET) {
            self.pending.clear();
        }
        if report.flags.contains(Flags::CLOCK_SET) {
            (self.driven_ns, self.newest_ns) = (None, 0);
        }
    }

    /// Predicts from a time to that of the queue. Before the first odometry the vehicle's motion is unknown.
    fn drive(&mut self, control: Option<Control<f32>>, from_ns: u64) {
        let Some(control) = control else { return };
        self.control = control;
        let dt_s = (self.seconds(self.queue.time_ns()) - self.seconds(from_ns)) as f32;
        if self.slam.predict(control, dt_s).is_err() {
            self.counts.refused += 1;
            return;
        }
        let control = self.setup.description.vehicle.kind.control(&control);
        // Fails for no control that the filter accepts.
        let _moved = self.smooth.predict(&self.motion, &control, dt_s);
    }

    fn take(&mut self, event: &Event, tell: &mut dyn FnMut(&Estimate)) {
        let (of_scan, health) = match event {
            Event::Scan(sensor, detections) => {
                let sensors = &self.setup.description.sensors;
                let model = sensors.get(*sensor).and_then(|sensor| Some(sensor.as_ref()?.model));
                let bearings: Vec<Vector1<f32>>;
                let measurements = if model == Some(SensorModel::Bearing) {
                    bearings = detections.iter().map(|seen| Vector1::new(seen.y)).collect();
                    Measurements::Bearing(&bearings)
                } else {
                    Measurements::RangeBearing(detections)
                };
                match self.slam.scan(*sensor, measurements).as_ref().map(Scanned::health) {
                    Ok(health) => {
                        self.counts.scans += 1;
                        self.health |= health;
                        self.look(*sensor);
                        (true, Ok(health))
                    }
                    Err(_) => (true, Err(())),
                }
            }
            Event::Position([x_m, y_m]) => (false, self.fix(|slam| slam.watch_position(*x_m, *y_m))),
            Event::Heading(heading_rad) => (false, self.fix(|slam| slam.watch_heading(*heading_rad))),
        };
        let (Ok(health), Some(pose)) = (health, self.slam.pose()) else {
            self.counts.refused += 1;
            return;
        };
        if self.smooth.correct(&pose.mean).is_err() {
            return;
        }
        tell(&Estimate {
            stamp_ns: self.queue.time_ns(),
            of_scan,
            pose,
            smooth: self.smooth.pose(),
            map_from_odom: self.smooth.map_from_odom(),
            control: self.control,
            health,
        });
    }

    fn fix<E>(
        &mut self,
        show: impl FnOnce(&mut dyn Services<f32>) -> Result<scphd_vehicle::Watched<f32>, E>,
    ) -> Result<Health, ()> {
        let watched = show(&mut *self.slam).map_err(drop)?;
        self.counts.fixes += 1;
        self.counts.outliers += u64::from(!watched.report.accepted);
        Ok(Health::GOOD)
    }
}

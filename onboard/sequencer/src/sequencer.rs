//! Outputs inputs in the order of their times, with the time between them.

use crate::ahead::{Ahead, Held};
use crate::queue::Queue;
use crate::stamp::Key;
use crate::timeline::Timeline;
use crate::{Flags, Interval, PushError, Report, Settings, SettingsError, Stamp};
use heapless::Vec;

/// The next action of the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub enum Action<'q, C, E> {
    /// Time passes under a control.
    Predict {
        /// The control in force.
        control: C,
        /// Time until the next input, or until the control is too old; above zero.
        dt: Interval,
    },
    /// Time passes, and the control in force is older than [`gap_ns`](Settings::gap_ns): the motion of the vehicle is unknown.
    Gap {
        /// The last control.
        control: C,
        /// Time until the next input; above zero.
        dt: Interval,
    },
    /// An event occurs now.
    Event(&'q E),
}

/// Accepts inputs in any order within a window, and outputs them in the order of their times.
///
/// `C` is the control of the vehicle's motion, `E` the type of all other inputs: an enum of the user with a variant for each
/// sensor and each fix. The capacity is `CONTROLS` controls and `EVENTS` events; all memory is in this type.
///
/// An input is output as soon as the newest time is later than its own by more than the window: no earlier input can then be
/// accepted any more. The newest time is that of the newest time stamp, or of the newest [`tick`](Self::tick). The output
/// therefore depends neither on the order of arrival nor on the times of the calls, as long as no input is later than the window.
///
/// It belongs to the loop of the filter: interrupts pass inputs to that loop through a queue, for example heapless's `spsc`.
///
/// A control holds from its time until the next one, or until it is [too old](Settings::gap_ns); predictions end at every input.
/// Odometry that refers to the time before, such as counted ticks, has the beginning of that time as time stamp.
///
/// ```
/// use scphd_sequencer::{Action, Sequencer, Settings, Stamp};
///
/// const WHEELS: u8 = 0;
/// const LIDAR: u8 = 1;
/// // 1 m/s from the start on; scans are texts here.
/// let mut sequencer = Sequencer::<f32, &str, 8, 4>::new();
/// sequencer.start(Settings { window_ns: 50_000_000, ..Settings::DEFAULT }, 0, 1.0)?;
///
/// let (mut way_m, mut log) = (0.0, Vec::new());
/// // The scan is of 30 ms, and comes after the odometry of 40 ms.
/// sequencer.push_control(Stamp::new(WHEELS, 40_000_000), 2.0)?;
/// sequencer.push_event(Stamp::new(LIDAR, 30_000_000), "scan")?;
/// sequencer.push_control(Stamp::new(WHEELS, 100_000_000), 1.5)?;
/// while let Some(action) = sequencer.next_action() {
///     match action {
///         Action::Predict { control, dt } => way_m += control * dt.seconds::<f32>(),
///         Action::Gap { .. } => log.push("gap"),
///         Action::Event(scan) => log.push(scan),
///     }
/// }
/// assert_eq!(log, ["scan"]);
/// assert!((way_m - 0.04).abs() < 1e-6 && sequencer.report().flags.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Sequencer<C, E, const CONTROLS: usize, const EVENTS: usize> {
    settings: Settings,
    timeline: Timeline,
    controls: Queue<C, CONTROLS>,
    events: Queue<E, EVENTS>,
    /// One element after the start. Not an `Option`, which for some types is not all zero when empty: a static would need flash.
    held: Vec<Held<C>, 1>,
    /// The time up to which predictions were output.
    time: u64,
    /// The event of the last action.
    handed: Option<Key>,
    in_gap: bool,
    report: Report,
}

/// The next action, without a reference.
enum Due<C> {
    Time { control: C, dt: Interval, known: bool },
    Event(Key),
}

impl<C: Copy, E, const CONTROLS: usize, const EVENTS: usize> Sequencer<C, E, CONTROLS, EVENTS> {
    /// A sequencer before its start, for a `static`.
    pub const fn new() -> Self {
        Self {
            settings: Settings::UNSET,
            timeline: Timeline::starting_at(0),
            controls: Queue::new(),
            events: Queue::new(),
            held: Vec::new(),
            time: 0,
            handed: None,
            in_gap: false,
            report: Report::NONE,
        }
    }

    /// Starts or restarts with empty queues, at the time of the filter's initial pose, with the control in force at that time,
    /// for example standing still. Earlier inputs are late.
    ///
    /// # Errors
    /// The settings are out of range; the sequencer is unchanged.
    pub fn start(&mut self, settings: Settings, time_ns: u64, control: C) -> Result<(), SettingsError> {
        settings.check()?;
        self.settings = settings;
        self.timeline = Timeline::starting_at(time_ns);
        self.controls.clear();
        self.events.clear();
        self.hold(control, 0);
        (self.time, self.handed, self.report) = (0, None, Report::NONE);
        Ok(())
    }

    /// Adds a control that holds from this time on.
    ///
    /// # Errors
    /// It is too late, a duplicate or beyond a jump of the clock, the queue is full, or the sequencer was not started. It is
    /// counted, and the sequencer continues without it.
    pub fn push_control(&mut self, stamp: Stamp, control: C) -> Result<(), PushError> {
        let key = self.key(stamp)?;
        let taken = self.controls.insert(key, control);
        self.accounted(taken, Flags::CONTROLS_FULL)
    }

    /// Adds an event with this time: a scan or a fix.
    ///
    /// # Errors
    /// As for [`push_control`](Self::push_control).
    pub fn push_event(&mut self, stamp: Stamp, event: E) -> Result<(), PushError> {
        let key = self.key(stamp)?;
        let taken = self.events.insert(key, event);
        self.accounted(taken, Flags::EVENTS_FULL)
    }

    fn key(&mut self, Stamp { time_ns, source, number }: Stamp) -> Result<Key, PushError> {
        if self.held.is_empty() {
            return Err(PushError::NotStarted);
        }
        self.forget_handed();
        let time = self.timeline.input(time_ns, &self.settings, &mut self.report);
        if let Some(after) = self.timeline.take_contradicted() {
            let dropped = self.controls.forget_after(after) + self.events.forget_after(after);
            (0..dropped).for_each(|_| self.report.raise(Flags::JUMP_FORWARD));
        }
        Ok(Key { time: time?, source, number })
    }

    fn accounted(&mut self, taken: Result<(), PushError>, if_full: Flags) -> Result<(), PushError> {
        match taken {
            Err(PushError::Full) => self.report.raise(if_full),
            Err(PushError::Duplicate) => self.report.raise(Flags::DUPLICATE),
            _ => (),
        }
        self.watch_for_gap();
        taken
    }

    /// Sets the present time of the clock of the time stamps, so that queued inputs are output after the window even without
    /// newer inputs. Without ticks the time advances with the time stamps of the inputs only. May be called at any rate.
    pub fn tick(&mut self, now_ns: u64) {
        if !self.held.is_empty() {
            self.timeline.tick(now_ns, &self.settings, &mut self.report);
            self.watch_for_gap();
        }
    }

    /// Declares that no input before this time stamp will be added: inputs up to it are output before the end of their window,
    /// for example because the newest odometry shows that all earlier data has arrived. Further inputs with exactly this time are
    /// accepted, and follow in the order of their arrival; earlier ones are late.
    pub fn complete_until(&mut self, stamp_ns: u64) {
        if !self.held.is_empty() {
            self.timeline.complete_until(stamp_ns);
            self.watch_for_gap();
        }
    }

    /// Makes all queued inputs due, as at the end of a log. Inputs that are not newer are late from then on.
    pub fn flush(&mut self) {
        self.timeline.close();
    }

    /// The next action of the filter; `None` if it must wait for inputs, or for the end of their window.
    ///
    /// Visits all queued inputs once, and again for every control at the same time as the previous one.
    pub fn next_action(&mut self) -> Option<Action<'_, C, E>> {
        self.forget_handed();
        match self.due()? {
            Due::Time { control, dt, known: true } => Some(Action::Predict { control, dt }),
            Due::Time { control, dt, known: false } => Some(Action::Gap { control, dt }),
            Due::Event(key) => {
                self.handed = Some(key);
                self.events.get(key).map(Action::Event)
            }
        }
    }

    fn due(&mut self) -> Option<Due<C>> {
        for _ in 0..=CONTROLS {
            self.watch_for_gap();
            let control = self.controls.first().filter(|(key, _)| self.timeline.is_due(key.time));
            let event = self.events.first().map(|(key, _)| key).filter(|key| self.timeline.is_due(key.time));
            match (control, event) {
                (None, None) => return None,
                (Some((key, &control)), event) if event.is_none_or(|event| key.time <= event.time) => {
                    if key.time > self.time {
                        return self.pass(key.time);
                    }
                    self.hold(control, key.time);
                    self.controls.remove(key);
                }
                (_, Some(key)) if key.time > self.time => return self.pass(key.time),
                (_, event) => return event.map(Due::Event),
            }
        }
        None
    }

    /// A prediction until this time, or until the control is too old.
    fn pass(&mut self, until: u64) -> Option<Due<C>> {
        let Held { control, since } = *self.held.first()?;
        let known_until = since.saturating_add(self.settings.gap_ns);
        let known = self.time < known_until;
        let end = if known { until.min(known_until) } else { until };
        let dt = Interval::of_ns(end.saturating_sub(self.time));
        self.time = end;
        Some(Due::Time { control, dt, known })
    }

    /// Sets the control in force.
    fn hold(&mut self, control: C, since: u64) {
        self.held.clear();
        // The capacity is one.
        let _always = self.held.push(Held { control, since });
        self.in_gap = false;
    }

    /// Raises [`Flags::GAP`] if there was certainly no newer control for too long.
    fn watch_for_gap(&mut self) {
        let Some(&Held { since, .. }) = self.held.first() else { return };
        let closed = self.timeline.closed();
        let alone_until = self.controls.first().map_or(closed, |(next, _)| next.time.min(closed));
        if alone_until.saturating_sub(since) > self.settings.gap_ns && !self.in_gap {
            self.in_gap = true;
            self.report.raise(Flags::GAP);
        }
    }

    /// Removes the event of the last action. Events stay in the queue until the next call, so that they are never copied.
    fn forget_handed(&mut self) {
        if let Some(key) = self.handed.take() {
            self.events.remove(key);
        }
    }

    /// The motion of the vehicle from the time of the last output until `now_ns`, by the queued controls: gives the current pose
    /// while the filter waits for the window. A control that arrives later may change it.
    ///
    /// Leaves out the time in which a control is [too old](Settings::gap_ns).
    #[must_use]
    pub fn ahead(&self, now_ns: u64) -> Ahead<'_, C, CONTROLS> {
        let until = self.timeline.time_of(now_ns).unwrap_or(0);
        Ahead::new(&self.controls, self.held.first().copied(), self.time, until, self.settings.gap_ns)
    }

    /// The time up to which predictions were output, by the present clock, ns: that of the filter's estimate.
    pub fn time_ns(&self) -> u64 {
        self.timeline.stamp_of(self.time)
    }

    /// Numbers of queued controls and events.
    #[must_use]
    pub fn waiting(&self) -> (usize, usize) {
        (self.controls.len(), self.events.len().saturating_sub(usize::from(self.handed.is_some())))
    }

    /// The warnings and counts.
    pub fn report(&self) -> Report {
        self.report
    }

    /// The warnings and counts; resets the warnings.
    pub fn take_report(&mut self) -> Report {
        let report = self.report;
        self.report.flags = Flags::NONE;
        report
    }
}

impl<C: Copy, E, const CONTROLS: usize, const EVENTS: usize> Default for Sequencer<C, E, CONTROLS, EVENTS> {
    fn default() -> Self {
        Self::new()
    }
}

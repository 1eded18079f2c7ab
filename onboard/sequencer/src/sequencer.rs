//! Inputs in the order of their times, and the time between them.

use crate::ahead::{Ahead, Held};
use crate::queue::Queue;
use crate::stamp::Key;
use crate::timeline::Timeline;
use crate::{Flags, Interval, PushError, Report, Settings, SettingsError, Stamp};
use heapless::Vec;

/// What the filter is to do next.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub enum Action<'q, C, E> {
    /// Time passes under a control.
    Predict {
        /// The control in force.
        control: C,
        /// How long until the next input, or until the control is too old; above zero.
        dt: Interval,
    },
    /// Time passes, and the control in force is older than [`gap_ns`](Settings::gap_ns): what moves the vehicle is not
    /// known.
    Gap {
        /// The last control there was.
        control: C,
        /// How long until the next input; above zero.
        dt: Interval,
    },
    /// An event takes place now.
    Event(&'q E),
}

/// Takes inputs in any order within a window, and hands them out in the order of their times.
///
/// `C` is the control of the vehicle's motion, `E` whatever else happens: an enum of the user's own with a variant for
/// each sensor and each fix. Up to `CONTROLS` controls and `EVENTS` events wait; the size of the type is all the memory
/// there is.
///
/// An input is handed out as soon as the newest time is later than its own by more than the window: then nothing can
/// come any more that is before it. The newest time is that of the newest stamp, or of the newest [`tick`](Self::tick).
/// So neither the order of arrival nor how often anyone asks changes what comes out, as long as no input is later than
/// the window.
///
/// It belongs to the loop of the filter: interrupts hand inputs to that loop, through a queue such as heapless's
/// `spsc`.
///
/// A control holds from its time on, until the next one or until it is [too old](Settings::gap_ns): steps end at every
/// input. Odometry that tells of the time before, such as counted ticks, is stamped with the begin of that time.
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
    /// One from the start on. An `Option` of some types is not all zero where it is none; this is, so that a static
    /// takes no flash.
    held: Vec<Held<C>, 1>,
    /// How far steps have come.
    time: u64,
    /// The event that the last step has handed out.
    handed: Option<Key>,
    in_gap: bool,
    report: Report,
}

/// What is due.
enum Due<C> {
    Time { control: C, dt: Interval, known: bool },
    Event(Key),
}

impl<C: Copy, E, const CONTROLS: usize, const EVENTS: usize> Sequencer<C, E, CONTROLS, EVENTS> {
    /// One that has not been started, for a `static`.
    #[must_use]
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

    /// Starts, or starts again, with empty queues: at the time for which the filter was given its pose, under the
    /// control that is in force then, such as standing still. Inputs from before it are late.
    ///
    /// # Errors
    /// The settings are out of range; nothing has changed.
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

    /// Takes the control that is in force from this time on.
    ///
    /// # Errors
    /// It came too late, twice or from beyond a jump of the clock, there is no room, or the sequencer has not been
    /// started. It is counted, and the rest goes on without it.
    pub fn push_control(&mut self, stamp: Stamp, control: C) -> Result<(), PushError> {
        let key = self.key(stamp)?;
        let taken = self.controls.insert(key, control);
        self.accounted(taken, Flags::CONTROLS_FULL)
    }

    /// Takes an event of this time: a scan, or a fix.
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

    /// Tells what the clock shows, the one that stamps the inputs: what has waited for the window is handed out, though
    /// nothing newer may come. Without it the stamps of the inputs drive the time alone. May be called as often as one
    /// likes.
    pub fn tick(&mut self, now_ns: u64) {
        if !self.held.is_empty() {
            self.timeline.tick(now_ns, &self.settings, &mut self.report);
            self.watch_for_gap();
        }
    }

    /// Tells that no input is to come any more that is earlier than this stamp: what is not later is handed out before its window ends, as
    /// where the newest odometry shows that all before has come. Inputs of just this time may still come, and follow in the order of
    /// their arrival; earlier ones are late.
    pub fn complete_until(&mut self, stamp_ns: u64) {
        if !self.held.is_empty() {
            self.timeline.complete_until(stamp_ns);
            self.watch_for_gap();
        }
    }

    /// Has everything handed out that waits, as at the end of a log. What is not newer than it comes too late from then
    /// on.
    pub fn flush(&mut self) {
        self.timeline.close();
    }

    /// What the filter is to do next; `None` where it must wait for inputs, or for their window to end.
    ///
    /// Looks at all that waits once, and once more for every control that changes nothing because no time passes.
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

    /// Time passes until then, or until the control is too old.
    fn pass(&mut self, until: u64) -> Option<Due<C>> {
        let Held { control, since } = *self.held.first()?;
        let known_until = since.saturating_add(self.settings.gap_ns);
        let known = self.time < known_until;
        let end = if known { until.min(known_until) } else { until };
        let dt = Interval::of_ns(end.saturating_sub(self.time));
        self.time = end;
        Some(Due::Time { control, dt, known })
    }

    /// This control is in force from now on.
    fn hold(&mut self, control: C, since: u64) {
        self.held.clear();
        // There is room for one.
        let _always = self.held.push(Held { control, since });
        self.in_gap = false;
    }

    /// Whether the control in force is known to be the only one for too long.
    fn watch_for_gap(&mut self) {
        let Some(&Held { since, .. }) = self.held.first() else { return };
        let closed = self.timeline.closed();
        let alone_until = self.controls.first().map_or(closed, |(next, _)| next.time.min(closed));
        if alone_until.saturating_sub(since) > self.settings.gap_ns && !self.in_gap {
            self.in_gap = true;
            self.report.raise(Flags::GAP);
        }
    }

    /// An event stays in its place until the next call: so it is never copied.
    fn forget_handed(&mut self) {
        if let Some(key) = self.handed.take() {
            self.events.remove(key);
        }
    }

    /// How the vehicle moves from where the steps have come on, until `now_ns`, as far as controls that wait already
    /// tell: to know at once where the vehicle is, while the filter waits for the window. It is what is known; a
    /// control that comes late may change it.
    ///
    /// Ends where a control is [too old](Settings::gap_ns), and goes on with the next.
    #[must_use]
    pub fn ahead(&self, now_ns: u64) -> Ahead<'_, C, CONTROLS> {
        let until = self.timeline.time_of(now_ns).unwrap_or(0);
        Ahead::new(&self.controls, self.held.first().copied(), self.time, until, self.settings.gap_ns)
    }

    /// The time that the steps have come to, by the clock as it is now, ns: that of the filter's estimate.
    #[must_use]
    pub fn time_ns(&self) -> u64 {
        self.timeline.stamp_of(self.time)
    }

    /// How many controls and events wait.
    #[must_use]
    pub fn waiting(&self) -> (usize, usize) {
        (self.controls.len(), self.events.len().saturating_sub(usize::from(self.handed.is_some())))
    }

    /// What has happened.
    #[must_use]
    pub fn report(&self) -> Report {
        self.report
    }

    /// What has happened; the next report has the conditions from here on.
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

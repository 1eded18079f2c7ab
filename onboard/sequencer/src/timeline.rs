//! The time of the vehicle, made of the stamps of a clock that may be set, stand still, or begin anywhere.

use crate::{Flags, PushError, Report, Settings};

/// Time as the sequencer counts it, ns since its start: it never goes back, whatever the clock does.
#[derive(Debug)]
pub(crate) struct Timeline {
    /// The newest time that a stamp or a tick has told of.
    newest: u64,
    /// What the clock showed then.
    newest_stamp: u64,
    /// The time of the newest input.
    newest_input: u64,
    /// How long after the one before that came.
    spacing: u64,
    /// Whatever is before this time has come, or comes too late.
    closed: u64,
    /// Inputs up to this time, it included, are due before their window ends; more of just this time may come.
    due: Option<u64>,
    /// Inputs since the newest, none of them newer.
    unmoved: u32,
    jumped: Jumped,
    /// The latest time of inputs that are ahead of the newest time by more than is [believed](Self::believed). They move the time on once a second input or
    /// a tick agrees; where an input contradicts them, their stamps were wrong.
    lead: Option<Lead>,
    /// Inputs after this time were contradicted, and must not be handed out.
    contradicted: Option<u64>,
    tick_behind: bool,
}

/// A time that is ahead of the newest by more than is believed of one input, and its stamp.
#[derive(Debug, Clone, Copy)]
struct Lead {
    time: u64,
    stamp: u64,
}

/// Inputs in a row from beyond a jump of the clock.
#[derive(Debug)]
struct Jumped {
    inputs: u32,
    first_stamp: u64,
    last_stamp: u64,
}

impl Jumped {
    const NONE: Self = Self { inputs: 0, first_stamp: 0, last_stamp: 0 };
}

/// By how much a stamp is ahead of another. A clock that passes from its greatest number on to 0 goes on.
fn ahead(stamp: u64, of: u64) -> i64 {
    stamp.wrapping_sub(of).cast_signed()
}

impl Timeline {
    pub(crate) const fn starting_at(stamp: u64) -> Self {
        Self {
            newest: 0,
            newest_stamp: stamp,
            newest_input: 0,
            spacing: 0,
            closed: 0,
            due: None,
            unmoved: 0,
            jumped: Jumped::NONE,
            lead: None,
            contradicted: None,
            tick_behind: false,
        }
    }

    /// The time of an input with this stamp, which is the newest now if no other is newer.
    pub(crate) fn input(&mut self, stamp: u64, settings: &Settings, report: &mut Report) -> Result<u64, PushError> {
        let by = ahead(stamp, self.newest_stamp);
        if by.unsigned_abs() > settings.jump_ns {
            report.raise(if by > 0 { Flags::JUMP_FORWARD } else { Flags::JUMP_BACK });
            if !self.believes(stamp, settings) {
                return Err(PushError::Jump);
            }
            // The first input from beyond the jump came when the newest time had just been.
            self.newest_stamp = self.jumped.first_stamp;
            report.raise(Flags::CLOCK_SET);
        }
        self.jumped = Jumped::NONE;
        let time = self.time_of(stamp);
        if let Some(time) = time
            && !self.is_agreed(time, stamp, settings)
        {
            return Ok(time);
        }
        if time.is_none_or(|time| time <= self.newest_input) {
            self.unmoved = self.unmoved.saturating_add(1);
            if self.unmoved == settings.frozen_inputs {
                report.raise(Flags::FROZEN);
            }
        }
        let Some(time) = time.filter(|&time| time >= self.closed && self.due.is_none_or(|due| time >= due)) else {
            report.raise(Flags::LATE);
            return Err(PushError::Late);
        };
        if time > self.newest_input {
            self.unmoved = 0;
            self.came(time);
        }
        self.reach(time, stamp, settings);
        Ok(time)
    }

    /// Whether this time moves the newest time on: not the first that is ahead of it by more than is believed of one, which would make all
    /// others late if its stamp is wrong.
    fn is_agreed(&mut self, time: u64, stamp: u64, settings: &Settings) -> bool {
        let reach = self.believed(settings);
        match self.lead.take() {
            // Later than the window behind the one ahead: either is wrong, and this one is where all others were.
            Some(lead) if time.saturating_add(settings.window_ns) < lead.time => {
                self.contradicted = Some(reach.max(time));
            }
            Some(lead) => {
                self.came(lead.time.min(time));
                self.reach(lead.time, lead.stamp, settings);
                return true;
            }
            None => (),
        }
        if time > reach {
            self.lead = Some(Lead { time, stamp });
        }
        time <= reach
    }

    /// An input of this time has come.
    fn came(&mut self, time: u64) {
        if time > self.newest_input {
            self.spacing = time - self.newest_input;
            self.newest_input = time;
        }
    }

    /// Up to which time a single input moves the newest time on: one may come as late as the window, and another one be missing in between.
    fn believed(&self, settings: &Settings) -> u64 {
        let spacing = self.spacing.min(settings.gap_ns);
        self.newest.saturating_add(settings.window_ns).saturating_add(spacing.saturating_mul(2))
    }

    /// After which time inputs that wait were contradicted, once.
    pub(crate) fn take_contradicted(&mut self) -> Option<u64> {
        self.contradicted.take()
    }

    /// Counts an input from beyond a jump. Whether there are enough to believe in the clock.
    fn believes(&mut self, stamp: u64, settings: &Settings) -> bool {
        let Jumped { inputs, first_stamp, last_stamp } = self.jumped;
        let goes_on = inputs > 0 && ahead(stamp, last_stamp).unsigned_abs() <= settings.jump_ns;
        self.jumped = if goes_on {
            Jumped { inputs: inputs.saturating_add(1), first_stamp, last_stamp: stamp }
        } else {
            Jumped { inputs: 1, first_stamp: stamp, last_stamp: stamp }
        };
        self.jumped.inputs >= settings.jumps_believed
    }

    /// The clock shows this.
    pub(crate) fn tick(&mut self, stamp: u64, settings: &Settings, report: &mut Report) {
        let by = ahead(stamp, self.newest_stamp);
        let is_behind = by < 0 && by.unsigned_abs() > settings.window_ns;
        if is_behind && !self.tick_behind {
            report.raise(Flags::TICK_BEHIND);
        }
        self.tick_behind = is_behind;
        if by > settings.jump_ns.cast_signed() {
            report.raise(Flags::JUMP_FORWARD);
        } else if let Some(time) = self.time_of(stamp) {
            self.reach(time, stamp, settings);
        }
    }

    fn reach(&mut self, time: u64, stamp: u64, settings: &Settings) {
        if time > self.newest {
            (self.newest, self.newest_stamp) = (time, stamp);
            self.closed = self.closed.max(time.saturating_sub(settings.window_ns));
        }
        // The clock is there, or nearly.
        let reach = self.believed(settings);
        if let Some(lead) = self.lead.filter(|lead| lead.time <= reach) {
            self.lead = None;
            self.came(lead.time);
            self.reach(lead.time, lead.stamp, settings);
        }
    }

    /// Nothing up to this stamp needs to wait any longer, and nothing before it is to come any more.
    pub(crate) fn complete_until(&mut self, stamp: u64) {
        let time = self.time_of(stamp).map(|time| time.min(self.newest));
        self.due = self.due.max(time);
    }

    /// Whether an input of this time is due.
    pub(crate) fn is_due(&self, time: u64) -> bool {
        time < self.closed || self.due.is_some_and(|due| time <= due)
    }

    /// Nothing that has come needs to wait any longer.
    pub(crate) fn close(&mut self) {
        if let Some(Lead { time, stamp }) = self.lead.take() {
            (self.newest, self.newest_stamp) = (time, stamp);
        }
        self.closed = self.newest.saturating_add(1);
    }

    pub(crate) fn closed(&self) -> u64 {
        self.closed
    }

    /// The time of a stamp; `None` before the start.
    pub(crate) fn time_of(&self, stamp: u64) -> Option<u64> {
        self.newest.checked_add_signed(ahead(stamp, self.newest_stamp))
    }

    /// The stamp of a time, by the clock as it is now.
    pub(crate) fn stamp_of(&self, time: u64) -> u64 {
        self.newest_stamp.wrapping_sub(self.newest.wrapping_sub(time))
    }
}

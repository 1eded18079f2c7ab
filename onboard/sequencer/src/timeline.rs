//! The time of the vehicle, from the time stamps of a clock that may be set, stand still, or start anywhere.

use crate::{Flags, PushError, Report, Settings};

/// The time of the sequencer, ns since its start, which never goes back.
#[derive(Debug)]
pub(crate) struct Timeline {
    /// The newest time of a time stamp or a tick.
    newest: u64,
    /// Its time stamp.
    newest_stamp: u64,
    /// The time of the newest input.
    newest_input: u64,
    /// The time between the newest input and the one before it.
    spacing: u64,
    /// Inputs before this time are late.
    closed: u64,
    /// Inputs up to and including this time are due before the end of their window; further inputs with exactly this time are
    /// accepted.
    due: Option<u64>,
    /// Number of inputs since the newest one.
    unmoved: u32,
    jumped: Jumped,
    /// The latest time of inputs that are ahead of the newest time by more than a [plausible step](Self::believed). It becomes
    /// the newest time when a second input or a tick confirms it; if an input contradicts it, its time stamp was wrong.
    lead: Option<Lead>,
    /// Inputs after this time were contradicted, and must not be output.
    contradicted: Option<u64>,
    tick_behind: bool,
}

/// A time that is ahead of the newest by more than a plausible step, and its time stamp.
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

/// Difference of two time stamps, positive if the first is later. The clock may wrap around.
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

    /// The time of an input with this time stamp, which becomes the newest time if it is newer.
    pub(crate) fn input(&mut self, stamp: u64, settings: &Settings, report: &mut Report) -> Result<u64, PushError> {
        let by = ahead(stamp, self.newest_stamp);
        if by.unsigned_abs() > settings.jump_ns {
            report.raise(if by > 0 { Flags::JUMP_FORWARD } else { Flags::JUMP_BACK });
            if !self.believes(stamp, settings) {
                return Err(PushError::Jump);
            }
            // The first input from beyond the jump is assumed to be at the newest time before it.
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

    /// Whether the newest time may advance to this time. It may not if this is the first input that is ahead by more than a
    /// plausible step: if its time stamp was wrong, all other inputs would be late.
    fn is_agreed(&mut self, time: u64, stamp: u64, settings: &Settings) -> bool {
        let reach = self.believed(settings);
        match self.lead.take() {
            // More than the window earlier than the input ahead: one of them is wrong, and this one agrees with all others.
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

    /// Updates the newest input and the spacing.
    fn came(&mut self, time: u64) {
        if time > self.newest_input {
            self.spacing = time - self.newest_input;
            self.newest_input = time;
        }
    }

    /// The time up to which a single input advances the newest time: it may be as late as the window, and another one may be
    /// missing before it.
    fn believed(&self, settings: &Settings) -> u64 {
        let spacing = self.spacing.min(settings.gap_ns);
        self.newest.saturating_add(settings.window_ns).saturating_add(spacing.saturating_mul(2))
    }

    /// Returns and clears the time after which queued inputs were contradicted.
    pub(crate) fn take_contradicted(&mut self) -> Option<u64> {
        self.contradicted.take()
    }

    /// Counts an input from beyond a jump. Returns whether there are enough to set the clock.
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

    /// Sets the present time of the clock.
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
        // The clock has nearly reached the time of the input ahead.
        let reach = self.believed(settings);
        if let Some(lead) = self.lead.filter(|lead| lead.time <= reach) {
            self.lead = None;
            self.came(lead.time);
            self.reach(lead.time, lead.stamp, settings);
        }
    }

    /// Inputs up to this time stamp need not wait any longer; no earlier ones will be added.
    pub(crate) fn complete_until(&mut self, stamp: u64) {
        let time = self.time_of(stamp).map(|time| time.min(self.newest));
        self.due = self.due.max(time);
    }

    /// Whether an input of this time is due.
    pub(crate) fn is_due(&self, time: u64) -> bool {
        time < self.closed || self.due.is_some_and(|due| time <= due)
    }

    /// Makes all queued inputs due.
    pub(crate) fn close(&mut self) {
        if let Some(Lead { time, stamp }) = self.lead.take() {
            (self.newest, self.newest_stamp) = (time, stamp);
        }
        self.closed = self.newest.saturating_add(1);
    }

    pub(crate) fn closed(&self) -> u64 {
        self.closed
    }

    /// The time of a time stamp; `None` before the start.
    pub(crate) fn time_of(&self, stamp: u64) -> Option<u64> {
        self.newest.checked_add_signed(ahead(stamp, self.newest_stamp))
    }

    /// The time stamp of a time, by the present clock.
    pub(crate) fn stamp_of(&self, time: u64) -> u64 {
        self.newest_stamp.wrapping_sub(self.newest.wrapping_sub(time))
    }
}

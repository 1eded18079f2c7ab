//! Calendar times.

const DAY_S: u64 = 86_400;
/// Least time in seconds since 1970 that is a calendar time, s: 1 January 2000.
const FIRST_S: f64 = 946_684_800.0;
/// End of the calendar times, s: the year 2100.
const LAST_S: f64 = 4_102_444_800.0;

/// Date and time (UTC) of seconds since 1970; `None` if it is not a calendar time.
pub fn utc(t_s: f64) -> Option<String> {
    if !(FIRST_S..LAST_S).contains(&t_s) {
        return None;
    }
    // Whole milliseconds, exact within the bounds above.
    let ms = (t_s * 1e3).round() as u64;
    let (seconds, ms) = (ms / 1000, ms % 1000);
    let (day, second) = (seconds / DAY_S, seconds % DAY_S);
    let [year, month, day] = date(day);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    let rest = if ms > 0 { format!(".{ms:03}") } else { String::new() };
    Some(format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}{rest} UTC"))
}

/// A time, s, as a date if it is a calendar time.
pub fn shown(t_s: f64) -> String {
    utc(t_s).unwrap_or_else(|| format!("{t_s:.3} s"))
}

fn date(day: u64) -> [u64; 3] {
    // Years begin in March, so that a leap day is the last day; 719 468 days lie between 1 March of year 0 and 1970.
    let day = day + 719_468;
    let (era, day) = (day / 146_097, day % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (year, month) = if month < 10 { (year, month + 3) } else { (year + 1, month - 9) };
    [year + 400 * era, month, day]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consecutive_days_have_consecutive_dates() {
        let mut now = [1970, 1, 1];
        for day in 0..50_000 {
            assert_eq!(date(day), now);
            let [year, month, of_month] = now;
            let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
            let days = [31, if leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31][month as usize - 1];
            now = match (of_month < days, month < 12) {
                (true, _) => [year, month, of_month + 1],
                (false, true) => [year, month + 1, 1],
                (false, false) => [year + 1, 1, 1],
            };
        }
    }

    #[test]
    fn calendar_times_are_shown_as_dates() {
        assert_eq!(utc(1_700_000_000.0).unwrap(), "2023-11-14 22:13:20 UTC");
        assert_eq!(shown(1_709_164_799.999_6), "2024-02-29 00:00:00 UTC");
        assert_eq!(shown(1_700_000_000.25), "2023-11-14 22:13:20.250 UTC");
        assert_eq!(shown(12.5), "12.500 s");
        assert_eq!(utc(f64::NAN), None);
    }
}

//! Calendar times.

use chrono::{DateTime, Datelike};

/// Date and time (UTC) of seconds since 1970; `None` if it is not a time from 2000 to 2099.
pub fn utc(t_s: f64) -> Option<String> {
    let time = DateTime::from_timestamp_millis((t_s * 1e3).round() as i64)?;
    (2000..2100).contains(&time.year()).then(|| time.format("%Y-%m-%d %H:%M:%S%.f UTC").to_string())
}

/// A time, s, as a date if it is a calendar time.
pub fn shown(t_s: f64) -> String {
    utc(t_s).unwrap_or_else(|| format!("{t_s:.3} s"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calendar_times_are_shown_as_dates() {
        assert_eq!(utc(1_700_000_000.0).unwrap(), "2023-11-14 22:13:20 UTC");
        assert_eq!(shown(1_709_164_799.999_6), "2024-02-29 00:00:00 UTC");
        assert_eq!(shown(1_700_000_000.25), "2023-11-14 22:13:20.250 UTC");
        assert_eq!(shown(12.5), "12.500 s");
        assert_eq!(utc(f64::NAN), None);
    }
}

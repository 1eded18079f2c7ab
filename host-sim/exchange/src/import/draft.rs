//! The data read from a recording, and the log that is made of it.

use super::{ImportError, Imported};
use crate::calendar;
use scphd_log::log::{
    Fix, FixNoise, Log, Mounting, MovingLandmark, NamedSensor, Nominal, Odometry, Scan, Sensor, TruePose, Vehicle,
};
use std::f64::consts::PI;

/// Range of a sensor in the log divided by the greatest measured range.
const MARGIN: f64 = 1.05;

/// The data read, each list in any order of time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Draft {
    pub name: String,
    /// The `log.toml` with vehicle and sensors, if given.
    pub head: Option<Log>,
    /// Names of the sensors in the order of their indices in scans, and their mountings if known; the name of an only sensor may
    /// be empty.
    pub sensors: Vec<(String, Option<Mounting>)>,
    /// Whether the vehicle moves sideways, if there is no head.
    pub aside: bool,
    /// Initial pose if known: x m, y m, heading rad.
    pub initial_pose: Option<[f64; 3]>,
    pub odometry: Vec<Odometry>,
    /// Scans, with indices of the sensors above.
    pub scans: Vec<Scan>,
    pub fixes: Vec<Fix>,
    /// Noise of the fixes, if there is no head.
    pub fix_noise: FixNoise,
    pub truth: Vec<TruePose>,
    pub landmarks: Vec<[f64; 2]>,
    /// True tracks of moving objects.
    pub moving: Vec<MovingLandmark>,
    /// Detections with this range, m, or more are left out.
    pub range_below_m: Option<f64>,
    /// Messages to the user.
    pub told: Vec<String>,
}

impl Draft {
    /// Makes the log.
    pub fn finish(mut self) -> Result<Imported, ImportError> {
        let Self { odometry, scans, truth, fixes, told, .. } = &mut self;
        told.extend(sort("odometry", odometry, |row| row.t_s));
        told.extend(sort("scans", scans, |scan| scan.t_s));
        told.extend(sort("true poses", truth, |row| row.t_s));
        told.extend(sort("fixes", fixes, |fix| fix.t_s));
        self.clean(self.head.as_ref().is_some_and(|head| head.simulated));
        if let Some(first) = self.odometry.first() {
            let before = self.fixes.len();
            self.fixes.retain(|fix| fix.t_s >= first.t_s);
            let lost = before - self.fixes.len();
            if lost > 0 {
                self.told.push(format!("{lost} fixes before the first row of odometry are left out"));
            }
        }
        let mut log = match self.head.take() {
            Some(head) => self.by_head(head)?,
            None => self.by_guess(),
        };
        let Self { odometry, scans, fixes, truth, landmarks, moving, told, .. } = self;
        if log.fix_noise == FixNoise::default() && !fixes.is_empty() {
            log.fix_noise = self.fix_noise;
        }
        log = Log { odometry, scans, fixes, truth, landmarks, moving, ..log };
        Ok(Imported { log, told })
    }

    /// Assigns the sensors of the head to the scans.
    fn by_head(&mut self, head: Log) -> Result<Log, ImportError> {
        let known: Vec<String> = head.sensors().map(|(name, ..)| name.to_owned()).collect();
        let place = |name: &String| match (&known[..], &self.sensors[..]) {
            // An only sensor needs no matching name.
            ([_], [_]) => Ok(0),
            _ => known.iter().position(|other| other == name).ok_or_else(|| {
                let known = known.join(", ");
                let what = format!("no sensor of this name, there are {known}; say --detections NAME=TOPIC for each");
                ImportError::at(format_args!("sensor '{name}'"), what)
            }),
        };
        let places = self.sensors.iter().map(|(name, _)| place(name)).collect::<Result<Vec<_>, _>>()?;
        self.scans.iter_mut().for_each(|scan| scan.sensor = places[scan.sensor]);
        Ok(head)
    }

    /// Without a head, the view of each sensor is the range of its detections.
    fn by_guess(&mut self) -> Log {
        let mut order: Vec<usize> = (0..self.sensors.len()).collect();
        order.sort_by(|a, b| self.sensors[*a].0.cmp(&self.sensors[*b].0));
        let mut sensors: Vec<NamedSensor> = Vec::new();
        for &place in &order {
            let (name, mounting) = &self.sensors[place];
            let seen = || self.scans.iter().filter(|scan| scan.sensor == place).flat_map(|scan| &scan.detections);
            let range = seen().map(|[range, _]| *range).fold(0.0, f64::max);
            let (least, most) = seen().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), [_, bearing]| {
                (least.min(*bearing), most.max(*bearing))
            });
            let (least, most) = if least < most { (least, most) } else { (-PI, PI) };
            let slack = 0.5 * (MARGIN - 1.0) * (most - least);
            let sensor = Sensor {
                range_min_m: 0.0,
                // Two decimals are enough for an estimate.
                range_max_m: (100.0 * MARGIN * range.max(1.0)).ceil() / 100.0,
                bearing_min_rad: (least - slack).max(-PI),
                bearing_max_rad: (most + slack).min(PI),
                mounting: mounting.unwrap_or(Mounting::NONE),
            };
            sensors.push(NamedSensor { name: name.clone(), sensor, nominal: Nominal::default() });
        }
        let place_of = |sensor: usize| order.iter().position(|other| *other == sensor).unwrap_or(0);
        self.scans.iter_mut().for_each(|scan| scan.sensor = place_of(scan.sensor));
        self.told.push(
            "log.toml is a guess: a unicycle, sensors that see as far and as wide as they have seen, no noise; \
                 write down what you know, or say --head"
                .to_owned(),
        );
        let mut sensors = sensors.into_iter();
        let everywhere = Sensor { range_max_m: 1.0, bearing_min_rad: -PI, bearing_max_rad: PI, ..Sensor::default() };
        let first = sensors.next().unwrap_or(NamedSensor {
            name: String::new(),
            sensor: everywhere,
            nominal: Nominal::default(),
        });
        Log {
            name: self.name.clone(),
            initial_pose: self.initial_pose.unwrap_or_default(),
            vehicle: if self.aside { Vehicle::Holonomic } else { Vehicle::UnicycleArc },
            sensor: first.sensor,
            sensor_name: first.name,
            nominal: first.nominal,
            others: sensors.collect(),
            ..Log::default()
        }
    }
}

/// Sorts rows by time. Returns a message if they were not in order.
fn sort<T>(name: &str, rows: &mut [T], t_s: impl Fn(&T) -> f64) -> Option<String> {
    let back = |pair: &[T]| t_s(&pair[1]) < t_s(&pair[0]);
    let count = rows.windows(2).filter(|pair| back(pair)).count();
    let first = rows.windows(2).position(back)?;
    let (from, to) = (t_s(&rows[first]), t_s(&rows[first + 1]));
    rows.sort_by(|a, b| t_s(a).total_cmp(&t_s(b)));
    Some(format!(
        "warning: {name}: time goes back {count} times, first by {:.3} s from {} to {} at row {}: the rows are put in order of time",
        from - to,
        calendar::shown(from),
        calendar::shown(to),
        first + 2
    ))
}

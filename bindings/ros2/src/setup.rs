//! The meaning of the parameters: a description of the vehicle, topics, frames and files.

use crate::parameters::{ParameterError, Parameters, Value};
use scphd_lidar::PostSettings;
use scphd_vehicle::{Description, SENSORS, Setting};

/// The types of messages that are read as odometry.
pub const ODOMETRY: [&str; 3] =
    ["nav_msgs/msg/Odometry", "sensor_msgs/msg/JointState", "ackermann_msgs/msg/AckermannDriveStamped"];
/// The types of messages that are read as detections.
pub const DETECTIONS: [&str; 5] = [
    "sensor_msgs/msg/PointCloud2",
    "vision_msgs/msg/Detection3DArray",
    "geometry_msgs/msg/PoseArray",
    "radar_msgs/msg/RadarScan",
    LASER_SCAN,
];
/// The message type in which posts are found.
pub const LASER_SCAN: &str = "sensor_msgs/msg/LaserScan";
/// The types of messages that are read as fixes.
pub const FIXES: [&str; 2] = ["geometry_msgs/msg/PoseWithCovarianceStamped", "sensor_msgs/msg/NavSatFix"];

/// A topic and the type of its messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topic {
    pub name: String,
    /// The type, as in `nav_msgs/msg/Odometry`.
    pub kind: String,
}

impl Topic {
    pub fn new(name: &str, kind: &str) -> Self {
        Self { name: name.to_owned(), kind: kind.to_owned() }
    }
}

/// The source of a sensor's scans.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Name of the sensor; empty if there is only one.
    pub name: String,
    pub topic: Topic,
    /// Whether parameters give the mounting of the sensor; otherwise `/tf_static` has to.
    pub seated: bool,
    /// Settings for finding posts in laser scans.
    pub posts: PostSettings,
}

/// The map's frame on earth, for latitude and longitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Earth {
    /// The origin of the map, degrees north, degrees east, and m above the ellipsoid; `None`: the first fix.
    pub origin: Option<[f64; 3]>,
    /// The direction of the x axis, to the left of east, rad.
    pub turn_rad: f64,
}

/// Waiting times for inputs, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// Minimum difference of the newest stamp and that of a scan or fix before this is processed; odometry must have reached its
    /// stamp, too. For sensors whose messages take longer than those of others.
    pub wait_s: f64,
    /// Maximum waiting time for odometry, after the arrival of a scan or fix.
    pub window_s: f64,
    /// A longer interval without odometry is a gap.
    pub gap_s: f64,
    /// A greater difference from the newest stamp is a jump of the clock.
    pub jump_s: f64,
}

/// Topics of a node, and names of its frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Wiring {
    pub odometry: Topic,
    /// The sensors, in the order of the description.
    pub sensors: Vec<Source>,
    /// Fixes, if there are any.
    pub fixes: Option<Topic>,
    /// The map's frame on earth.
    pub earth: Earth,
    /// The topic of an inertial measurement unit that gives the turn rate; empty: the odometry gives it.
    pub imu: String,
    /// The frames of the map, of the smooth odometry and of the vehicle's pose.
    pub frames: [String; 3],
    /// Waiting times for inputs.
    pub order: Order,
    /// The map file for the services that save it, load it and localise the vehicle in it.
    pub map: String,
    /// Whether publishers of inputs must repeat lost messages; sensors usually do not (REP 2003).
    pub reliable: bool,
}

impl Default for Wiring {
    fn default() -> Self {
        Self {
            odometry: Topic::new("odom", ODOMETRY[0]),
            sensors: Vec::new(),
            fixes: None,
            earth: Earth { origin: None, turn_rad: 0.0 },
            imu: String::new(),
            frames: ["map", "odom", "base_link"].map(str::to_owned),
            order: Order { wait_s: 0.0, window_s: 0.2, gap_s: 0.5, jump_s: 10.0 },
            map: "map.scphd".to_owned(),
            reliable: false,
        }
    }
}

/// The complete setup.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// The vehicle and its filter.
    pub description: Description<f32>,
    /// Topics, frames and files.
    pub wiring: Wiring,
}

/// The parameter of a setting; for a setting of a sensor, of the sensor with this name.
fn name_of(setting: Setting, sensor: &str) -> String {
    match setting.name().strip_prefix("sensor.") {
        Some(rest) if !sensor.is_empty() => format!("sensor.{sensor}.{rest}"),
        _ => setting.name().to_owned(),
    }
}

/// Parameters that have not been read yet.
struct Rest(Parameters);

impl Rest {
    fn text(&mut self, name: &str, place: &mut String) -> Result<(), ParameterError> {
        match self.0.0.remove(name) {
            Some(Value::Text(text)) => *place = text,
            Some(other) => return Err(invalid(name, &other, "a word")),
            None => {}
        }
        Ok(())
    }

    fn seconds(&mut self, name: &str, place: &mut f64) -> Result<(), ParameterError> {
        match self.0.0.remove(name) {
            Some(Value::Number(number)) if (0.0..=1e9).contains(&number) => *place = number,
            Some(other) => return Err(invalid(name, &other, "between 0 and 1000000000")),
            None => {}
        }
        Ok(())
    }

    fn number(&mut self, name: &str, place: &mut f64) -> Result<(), ParameterError> {
        match self.0.0.remove(name) {
            Some(Value::Number(number)) => *place = number,
            Some(other) => return Err(invalid(name, &other, "a number")),
            None => {}
        }
        Ok(())
    }

    fn posts(&mut self, part: &str, range_m: [f32; 2]) -> Result<PostSettings, ParameterError> {
        let usual = PostSettings::of_radius(0.05);
        let mut numbers = [
            ("radius_m", f64::from(usual.radius_m)),
            ("tolerance_m", f64::from(usual.tolerance_m)),
            ("gap_m", f64::from(usual.gap_m)),
            ("min_points", f64::from(usual.min_points)),
            ("min_intensity", f64::from(usual.min_intensity)),
        ];
        for (name, number) in &mut numbers {
            self.number(&format!("{part}.posts.{name}"), number)?;
        }
        let [radius_m, tolerance_m, gap_m, min_points, min_intensity] = numbers.map(|(_, number)| number as f32);
        let [range_min_m, range_max_m] = range_m;
        // The conversion saturates; 0 is refused below.
        let min_points = min_points as u16;
        let posts = PostSettings { radius_m, tolerance_m, gap_m, min_points, min_intensity, range_min_m, range_max_m };
        let refused = |error: scphd_lidar::SettingsError| ParameterError::Invalid {
            name: format!("{part}.posts.{}", error.field),
            found: "out of range".to_owned(),
            range: error.range.to_owned(),
        };
        posts.check().map_err(refused).map(|()| posts)
    }

    fn yes(&mut self, name: &str, place: &mut bool) -> Result<(), ParameterError> {
        match self.0.0.remove(name) {
            Some(Value::Bool(is)) => *place = is,
            Some(other) => return Err(invalid(name, &other, "true or false")),
            None => {}
        }
        Ok(())
    }

    fn topic(&mut self, part: &str, known: &[&str], place: &mut Topic) -> Result<(), ParameterError> {
        self.text(&format!("{part}.topic"), &mut place.name)?;
        let name = format!("{part}.type");
        self.text(&name, &mut place.kind)?;
        if known.contains(&place.kind.as_str()) {
            return Ok(());
        }
        Err(invalid(&name, &Value::Text(place.kind.clone()), &format!("one of {}", known.join(", "))))
    }
}

fn invalid(name: &str, found: &Value, range: &str) -> ParameterError {
    ParameterError::Invalid { name: name.to_owned(), found: found.to_string(), range: range.to_owned() }
}

/// The number of a setting from the value of its parameter; for a choice, its index.
fn number_of(setting: Setting, name: &str, value: &Value) -> Result<f64, ParameterError> {
    let choices = setting.choices();
    let found = match value {
        Value::Number(number) if choices.is_empty() => Some(*number),
        Value::Text(text) => choices.iter().position(|choice| choice == text).map(|place| place as f64),
        // YAML reads an unquoted "no" as a truth value.
        Value::Bool(is) if choices == ["no", "yes"] => Some(f64::from(*is)),
        _ => None,
    };
    found.ok_or_else(|| invalid(name, value, setting.range()))
}

impl Setup {
    /// Reads all parameters; defaults are those of a robot without sensors.
    pub fn of(parameters: &Parameters) -> Result<Self, ParameterError> {
        let mut rest = Rest(parameters.clone());
        let (mut description, mut wiring) = (Description::robot(), Wiring::default());
        let mut sensors = match rest.0.0.remove("sensors") {
            Some(Value::Texts(names)) => names,
            Some(other) => return Err(invalid("sensors", &other, "a list of names")),
            None => Vec::new(),
        };
        if sensors.is_empty() && rest.0.0.keys().any(|name| name.starts_with("sensor.")) {
            sensors.push(String::new());
        }
        if sensors.len() > SENSORS {
            return Err(invalid("sensors", &Value::Texts(sensors), &format!("at most {SENSORS} names")));
        }
        for (place, sensor) in sensors.iter().enumerate() {
            let model = Setting::of_name("sensor.model");
            // A named sensor exists even without further parameters.
            if let Some(model) = model {
                let _in_range = description.set(model, place, 1.0);
            }
            let part = if sensor.is_empty() { "sensor".to_owned() } else { format!("sensor.{sensor}") };
            let default = if sensor.is_empty() { "detections".to_owned() } else { format!("detections/{sensor}") };
            let mut topic = Topic::new(&default, DETECTIONS[0]);
            rest.topic(&part, &DETECTIONS, &mut topic)?;
            let seated = ["forward_m", "left_m", "yaw_rad"]
                .iter()
                .any(|number| rest.0.0.contains_key(&format!("{part}.{number}")));
            let posts = PostSettings::of_radius(0.05);
            wiring.sensors.push(Source { name: sensor.clone(), topic, seated, posts });
        }
        for setting in Setting::all() {
            let of_sensor = setting.name().starts_with("sensor.");
            let places = if of_sensor { sensors.len() } else { 1 };
            for place in 0..places {
                let name = name_of(setting, sensors.get(place).map_or("", String::as_str));
                let Some(value) = rest.0.0.remove(&name) else { continue };
                let number = number_of(setting, &name, &value)?;
                description.set(setting, place, number as f32).map_err(|_| invalid(&name, &value, setting.range()))?;
            }
        }
        for (source, sensor) in wiring.sensors.iter_mut().zip(&description.sensors) {
            let Some(sensor) = sensor.filter(|_| source.topic.kind == LASER_SCAN) else { continue };
            let part = if source.name.is_empty() { "sensor".to_owned() } else { format!("sensor.{}", source.name) };
            source.posts = rest.posts(&part, [sensor.window.range_min_m, sensor.window.range_max_m])?;
        }
        rest.topic("odometry", &ODOMETRY, &mut wiring.odometry)?;
        rest.text("imu.topic", &mut wiring.imu)?;
        if description.position.is_some() || description.heading.is_some() {
            let mut topic = Topic::new("fix", FIXES[0]);
            rest.topic("fixes", &FIXES, &mut topic)?;
            let names = ["latitude_deg", "longitude_deg", "altitude_m", "turn_rad"].map(|name| format!("fixes.{name}"));
            let is_said = rest.0.0.contains_key(&names[0]) || rest.0.0.contains_key(&names[1]);
            let mut numbers = [0.0; 4];
            for (name, number) in names.iter().zip(&mut numbers) {
                rest.number(name, number)?;
            }
            let [latitude, longitude, altitude, turn_rad] = numbers;
            let origin = is_said.then_some([latitude, longitude, altitude]);
            wiring.earth = Earth { origin, turn_rad };
            wiring.fixes = Some(topic);
        }
        let [map, odom, base] = &mut wiring.frames;
        for (name, place) in [("frames.map", map), ("frames.odom", odom), ("frames.base", base)] {
            rest.text(name, place)?;
        }
        let Order { wait_s, window_s, gap_s, jump_s } = &mut wiring.order;
        let order =
            [("order.wait_s", wait_s), ("order.window_s", window_s), ("order.gap_s", gap_s), ("order.jump_s", jump_s)];
        for (name, place) in order {
            rest.seconds(name, place)?;
        }
        rest.text("map", &mut wiring.map)?;
        rest.yes("reliable", &mut wiring.reliable)?;
        if let Some(name) = rest.0.0.keys().next() {
            let hint = if name.starts_with("sensor.") { ": 'sensors' has the names of sensors" } else { "" };
            return Err(ParameterError::Unknown(name.clone(), hint.to_owned()));
        }
        Ok(Self { description, wiring })
    }

    /// Writes the parameters of a wiring, and of a description in double precision, whose numbers have shorter texts.
    pub fn parameters(description: &Description<f64>, wiring: &Wiring) -> Parameters {
        let mut all = Parameters::default();
        let mut put = |name: String, value: Value| drop(all.0.insert(name, value));
        let names: Vec<String> = wiring.sensors.iter().map(|source| source.name.clone()).collect();
        if names.iter().any(|name| !name.is_empty()) {
            put("sensors".into(), Value::Texts(names.clone()));
        }
        let mut topic = |part: String, topic: &Topic| {
            put(format!("{part}.topic"), Value::Text(topic.name.clone()));
            put(format!("{part}.type"), Value::Text(topic.kind.clone()));
        };
        topic("odometry".into(), &wiring.odometry);
        for Source { name, topic: of, .. } in &wiring.sensors {
            topic(if name.is_empty() { "sensor".into() } else { format!("sensor.{name}") }, of);
        }
        wiring.fixes.iter().for_each(|fixes| topic("fixes".into(), fixes));
        for (name, frame) in ["frames.map", "frames.odom", "frames.base"].into_iter().zip(&wiring.frames) {
            put(name.into(), Value::Text(frame.clone()));
        }
        let Order { wait_s, window_s, gap_s, jump_s } = wiring.order;
        for (name, number) in
            [("order.wait_s", wait_s), ("order.window_s", window_s), ("order.gap_s", gap_s), ("order.jump_s", jump_s)]
        {
            put(name.into(), Value::Number(number));
        }
        put("map".into(), Value::Text(wiring.map.clone()));
        put("reliable".into(), Value::Bool(wiring.reliable));
        for setting in Setting::all() {
            let of_sensor = setting.name().starts_with("sensor.");
            let places = if of_sensor { names.len() } else { 1 };
            for place in 0..places {
                let Some(number) = description.get(setting, place) else { continue };
                let name = name_of(setting, names.get(place).map_or("", String::as_str));
                // There are few choices.
                let choice = setting.choices().get(number as usize);
                put(name, choice.map_or(Value::Number(number), |choice| Value::Text((*choice).to_owned())));
            }
        }
        all
    }
}

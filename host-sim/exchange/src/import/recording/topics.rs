//! Contents of a file, and the choice of topics.

use super::options::Options;
use crate::mcap::topic;
use scphd_ros::{Reader, Record};
use std::collections::BTreeMap;
use std::io::Read;

const ODOMETRY: &[&str] = &["nav_msgs/msg/Odometry"];
const WHEELS: &[&str] = &["sensor_msgs/msg/JointState", "ackermann_msgs/msg/AckermannDriveStamped"];
const CLOUD: &str = "sensor_msgs/msg/PointCloud2";
const DETECTIONS: &[&str] =
    &["radar_msgs/msg/RadarScan", "vision_msgs/msg/Detection3DArray", "geometry_msgs/msg/PoseArray", CLOUD];
const FIXES: &[&str] = &["sensor_msgs/msg/NavSatFix", "geometry_msgs/msg/PoseWithCovarianceStamped"];
const TRUTH: &[&str] =
    &["geometry_msgs/msg/PoseStamped", "nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseWithCovarianceStamped"];
/// Words in the name of a topic of points that are landmarks, not a whole laser scan.
const OF_LANDMARKS: [&str; 5] = ["detection", "landmark", "cluster", "reflector", "feature"];
/// The name that switches a role off.
const NONE: &str = "none";

#[derive(Debug, Default)]
pub(super) struct Content {
    /// For each topic, its type and number of messages.
    topics: BTreeMap<String, (String, usize)>,
    attached: BTreeMap<String, Vec<u8>>,
}

impl Content {
    pub(super) fn take<R: Read>(&mut self, reader: &Reader<R>, record: Record) {
        match record {
            Record::Channel(number) => {
                if let Some(channel) = reader.channel(number) {
                    self.topics.entry(channel.topic.clone()).or_insert_with(|| (channel.kind.clone(), 0));
                }
            }
            Record::Message { channel, .. } => {
                let topic = reader.channel(channel).and_then(|channel| self.topics.get_mut(&channel.topic));
                topic.into_iter().for_each(|(_, count)| *count += 1);
            }
            Record::Attachment { name, data } => {
                self.attached.insert(name, data);
            }
        }
    }

    pub(super) fn attached(&self, name: &str) -> Option<&str> {
        self.attached.get(name).and_then(|data| std::str::from_utf8(data).ok())
    }

    /// Topics of these types, without the results of the filter.
    fn of(&self, kinds: &[&str]) -> Vec<&str> {
        const MADE: [&str; 5] = [topic::ESTIMATE, topic::ODOMETRY, topic::FEATURES, topic::MAP, topic::LANDMARKS];
        let fits = |(name, (kind, _)): &(&String, &(String, usize))| {
            kinds.contains(&kind.as_str()) && !MADE.contains(&name.as_str())
        };
        self.topics.iter().filter(fits).map(|(name, _)| name.as_str()).collect()
    }

    /// Checks that a topic exists and has a supported type.
    fn named(&self, role: &str, name: &str, kinds: &[&str]) -> Result<String, String> {
        match self.topics.get(name) {
            None => Err(format!("no topic '{name}' for {role}; there are {}", self.listed())),
            Some((kind, _)) if !kinds.contains(&kind.as_str()) => Err(format!(
                "topic '{name}' for {role} has messages {}, understood are {}",
                if kind.is_empty() { "without a type" } else { kind },
                kinds.join(", ")
            )),
            Some((_, 0)) => Err(format!("topic '{name}' for {role} has no message")),
            Some(_) => Ok(name.to_owned()),
        }
    }

    fn listed(&self) -> String {
        let of = |(name, (kind, _)): (&String, &(String, usize))| format!("{name} ({kind})");
        let all: Vec<String> = self.topics.iter().map(of).collect();
        if all.is_empty() { "none at all".to_owned() } else { all.join(", ") }
    }
}

/// The topics that are read.
#[derive(Debug)]
pub(super) struct Chosen {
    pub(super) odometry: String,
    /// The name of the sensor, and the topic.
    pub(super) detections: Vec<(String, String)>,
    pub(super) fixes: Option<String>,
    pub(super) truth: Option<String>,
}

/// The only topic, or else the only one with the word in its name.
fn only<'t>(role: &str, option: &str, found: Vec<&'t str>, word: &str) -> Result<Option<&'t str>, String> {
    let with_word: Vec<&str> = found.iter().copied().filter(|name| name.to_lowercase().contains(word)).collect();
    match (&found[..], &with_word[..]) {
        ([], _) => Ok(None),
        ([one], _) | (_, [one]) => Ok(Some(one)),
        _ => Err(format!("several topics may be {role}: {}; say {option}", found.join(", "))),
    }
}

impl Chosen {
    pub(super) fn of(content: &Content, options: &Options, ackermann: bool) -> Result<Self, String> {
        let motion = if ackermann { WHEELS } else { ODOMETRY };
        let odometry = match &options.odometry {
            Some(name) => content.named("the odometry", name, motion)?,
            None => {
                let found = content.of(motion);
                let own = [topic::INPUT_ODOMETRY, topic::INPUT_WHEELS].into_iter().find(|own| found.contains(own));
                let found: Vec<&str> = found.into_iter().filter(|name| !name.contains("truth")).collect();
                let one =
                    own.map_or_else(|| only("the odometry", "--odometry TOPIC", found, "odom"), |own| Ok(Some(own)))?;
                let name = one.ok_or_else(|| {
                    let kinds = motion.join(" or ");
                    let cars = content.of(WHEELS);
                    let hint = if ackermann || cars.is_empty() {
                        String::new()
                    } else {
                        format!("; {} needs --head with a [vehicle] of model ackermann", cars.join(", "))
                    };
                    format!("no odometry: no topic with {kinds}; there are {}{hint}", content.listed())
                })?;
                content.named("the odometry", name, motion)?
            }
        };
        let mut detections = Vec::new();
        for (sensor, name) in &options.detections {
            detections.push((sensor.clone(), content.named("detections", name, DETECTIONS)?));
        }
        if detections.is_empty() {
            detections = Self::guessed(content)?;
        }
        let fixes = match options.fixes.as_deref() {
            Some(NONE) => None,
            Some(name) => Some(content.named("fixes", name, FIXES)?),
            None => {
                let own = content.of(FIXES).into_iter().find(|name| *name == topic::INPUT_FIX);
                let found = own.map_or_else(
                    || only("fixes", "--fixes TOPIC or none", content.of(&FIXES[..1]), "fix"),
                    |own| Ok(Some(own)),
                )?;
                found.map(str::to_owned)
            }
        };
        let truth = match options.truth.as_deref() {
            Some(NONE) => None,
            Some(name) => Some(content.named("the truth", name, TRUTH)?),
            None => {
                let found = content.of(TRUTH).into_iter().filter(|name| name.contains("truth")).collect();
                only("the truth", "--truth TOPIC or none", found, "truth")?.map(str::to_owned)
            }
        };
        Ok(Self { odometry, detections, fixes, truth })
    }

    /// Chooses the topics of an exported run, or the only one.
    fn guessed(content: &Content) -> Result<Vec<(String, String)>, String> {
        let found = content.of(DETECTIONS);
        let own: Vec<(String, String)> = found
            .iter()
            .filter_map(|name| name.strip_prefix(topic::DETECTIONS).map(|rest| (rest, *name)))
            .filter(|(rest, _)| rest.is_empty() || rest.starts_with('/'))
            .map(|(rest, name)| (rest.trim_start_matches('/').to_owned(), name.to_owned()))
            .collect();
        if !own.is_empty() {
            return Ok(own);
        }
        let clouds = content.of(&[CLOUD]);
        let of_landmarks = |name: &str| OF_LANDMARKS.iter().any(|word| name.to_lowercase().contains(word));
        let found = found.into_iter().filter(|name| !clouds.contains(name) || of_landmarks(name)).collect();
        match only(
            "detections",
            "--detections TOPIC, with several sensors --detections NAME=TOPIC for each",
            found,
            "landmark",
        )? {
            Some(name) => Ok(vec![(String::new(), content.named("detections", name, DETECTIONS)?)]),
            None => Err(format!(
                "no detections: no topic with {}, where a cloud has to be of landmarks, not of all that a laser saw; there are {}",
                DETECTIONS.join(", "),
                content.listed()
            )),
        }
    }

    /// The choices, a sentence each.
    pub(super) fn told(&self, content: &Content) -> Vec<String> {
        let of = |role: &str, name: &str| {
            let (kind, count) = content.topics.get(name).cloned().unwrap_or_default();
            format!("{role}: {name}, {count} messages {kind}")
        };
        let named =
            |sensor: &str| if sensor.is_empty() { "detections".to_owned() } else { format!("detections of {sensor}") };
        let detections = self.detections.iter().map(|(sensor, name)| of(&named(sensor), name));
        let mut told = vec![of("odometry", &self.odometry)];
        told.extend(detections);
        told.extend(self.fixes.iter().map(|name| of("fixes", name)));
        told.extend(self.truth.iter().map(|name| of("truth", name)));
        told
    }
}

//! The node: reads topics, runs the filter, publishes estimates.

use crate::engine::{Engine, Estimate};
use crate::inputs::{Inputs, Placed, Role};
use crate::middleware::{Arguments, Failure, IN, latched, node, parted, publisher, reliable, sensor_data, type_name};
use crate::outputs;
use crate::raw::Raw;
use crate::services::Services;
use crate::setup::Setup;
use ros2_client::dds::rustdds::mio1::{Events, Interest, Poll, Token};
use ros2_client::qos::History;
use ros2_client::{Node, NodeOptions, Publisher, Subscription};
use scphd_ros::Time;
use scphd_ros::messages::{DiagnosticArray, MarkerArray, Odometry, PoseWithCovarianceStamped, TFMessage};
use std::collections::VecDeque;
use std::fmt::Debug;
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Interval between messages of diagnostics.
const DIAGNOSTICS: Duration = Duration::from_secs(1);
/// Interval between messages of the map, ns of the stamps.
const FEATURES_NS: u64 = 200_000_000;
/// Number of odometry poses that are kept until a scan with their time arrives.
const PLACED: usize = 256;

/// The publishers.
struct Outputs {
    pose: Publisher<PoseWithCovarianceStamped>,
    odometry: Publisher<Odometry>,
    features: Publisher<MarkerArray>,
    transforms: Publisher<TFMessage>,
    diagnostics: Publisher<DiagnosticArray>,
}

impl Outputs {
    fn new(node: &mut Node, arguments: &Arguments) -> Result<Self, Failure> {
        let name = |name: &str| arguments.resolved(name);
        Ok(Self {
            pose: publisher(node, &name("~/pose"), &reliable())?,
            odometry: publisher(node, &name("~/odometry"), &reliable())?,
            // The messages are large and soon replaced, so that late readers do not get the last one.
            features: publisher(node, &name("~/features"), &reliable().history(History::KeepLast { depth: 4 }))?,
            transforms: publisher(node, &name("/tf"), &reliable())?,
            diagnostics: publisher(node, &name("/diagnostics"), &reliable())?,
        })
    }
}

/// Reports an error of publishing. The message is lost; the next one follows.
fn sent<E: Debug>(name: &str, result: Result<(), E>) {
    if let Err(error) = result {
        eprintln!("{name}: not published: {error:?}");
    }
}

/// Runs a node until the program ends.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(word) = arguments.rest.first() {
        return Err(Failure(format!(
            "'{word}' is not understood; parameters are -p NAME:=VALUE or --params-file FILE"
        )));
    }
    let setup = Setup::of(&arguments.parameters)?;
    let run = || serve(arguments, setup);
    scphd_run::session::with_roomy_stack(run).map_err(|error| Failure(format!("a thread does not start: {error}")))?
}

fn serve(arguments: &Arguments, setup: Setup) -> Result<(), Failure> {
    let mut engine = Engine::new(setup).map_err(|error| Failure(error.to_string()))?;
    let mut inputs = Inputs::new(engine.setup());
    let mut node = node(arguments, NodeOptions::new().enable_rosout(false))?;
    let spinner = node.spinner().map_err(|error| Failure(format!("{error:?}")))?;
    thread::spawn(move || {
        if let Err(error) = futures::executor::block_on(spinner.spin()) {
            eprintln!("the services of parameters end: {error:?}");
        }
    });
    let outputs = Outputs::new(&mut node, arguments)?;
    let mut readers = readers(&mut node, arguments, &inputs, engine.setup().wiring.reliable)?;
    let mut poll = Poll::new().map_err(|error| Failure(error.to_string()))?;
    for (place, reader) in readers.iter_mut().enumerate() {
        let registered = poll.registry().register(reader, Token(place), Interest::READABLE);
        registered.map_err(|error| Failure(error.to_string()))?;
    }
    let services = Services::new(&mut node, arguments, poll.registry(), readers.len())?;
    let map = PathBuf::from(&engine.setup().wiring.map);
    println!("{}: reads {}", node.fully_qualified_name(), {
        let topics = inputs.topics.iter().map(|input| arguments.resolved(&input.channel.topic));
        topics.collect::<Vec<_>>().join(", ")
    });

    let mut events = Events::with_capacity(64);
    let mut state = State::default();
    let mut told = Instant::now();
    loop {
        let mut wait = DIAGNOSTICS.saturating_sub(told.elapsed());
        if let Some(patience) = engine.patience() {
            wait = wait.min(patience);
        }
        if let Err(error) = poll.poll(&mut events, Some(wait))
            && error.kind() != std::io::ErrorKind::Interrupted
        {
            return Err(Failure(error.to_string()));
        }
        // Repeats until no message is left, so that no earlier message of another topic is missed.
        while take_all(&readers, &mut inputs, &mut engine, &mut state) {}
        services.answer(&mut engine, &map);
        let mut estimates = Vec::new();
        engine.work(&mut |estimate| estimates.push(estimate.clone()));
        for estimate in &estimates {
            publish(estimate, &mut engine, &outputs, &mut state);
        }
        if told.elapsed() >= DIAGNOSTICS {
            told = Instant::now();
            let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
            let at = Time::from_nanoseconds(u64::try_from(now.as_nanos()).unwrap_or(0));
            let refused = state.refused.take();
            if let Some(refused) = &refused {
                eprintln!("left out: {refused}");
            }
            let conditions = engine.take_conditions();
            let refused =
                refused.or_else(|| engine.is_searching().then(|| "looks for its place in the map".to_owned()));
            let message = outputs::diagnostics(&arguments.name, at, conditions, &engine.counts(), refused.as_deref());
            sent("diagnostics", outputs.diagnostics.publish(message));
        }
    }
}

/// State between messages.
#[derive(Default)]
struct State {
    placed: VecDeque<Placed>,
    refused: Option<String>,
    shown_ns: Option<u64>,
}

/// A reader for each topic, in their order.
fn readers(
    node: &mut Node,
    arguments: &Arguments,
    inputs: &Inputs,
    must_be_reliable: bool,
) -> Result<Vec<Subscription<Raw>>, Failure> {
    let reader = |input: &crate::inputs::Input| {
        let quality = match input.role {
            Role::Seats => latched().history(History::KeepLast { depth: 64 }),
            _ if must_be_reliable => reliable().history(History::KeepLast { depth: IN }),
            _ => sensor_data(),
        };
        let name = arguments.resolved(&input.channel.topic);
        let refused = |error: &dyn Debug| Failure(format!("{name}: {error:?}"));
        let topic = node
            .create_topic(&parted(&name)?, type_name(&input.channel.kind)?, &quality)
            .map_err(|error| refused(&error))?;
        node.create_subscription(&topic, Some(quality)).map_err(|error| refused(&error))
    };
    inputs.topics.iter().map(reader).collect()
}

/// Reads all waiting messages. Returns whether there were any.
fn take_all(readers: &[Subscription<Raw>], inputs: &mut Inputs, engine: &mut Engine, state: &mut State) -> bool {
    let mut any = false;
    for (place, reader) in readers.iter().enumerate() {
        loop {
            match reader.take() {
                Ok(Some((message, _))) => {
                    any = true;
                    match inputs.take(place, &message.0, engine) {
                        Ok(None) => {}
                        Ok(Some(placed)) => {
                            state.placed.push_back(placed);
                            if state.placed.len() > PLACED {
                                state.placed.pop_front();
                            }
                        }
                        Err(refused) => state.refused = Some(refused),
                    }
                }
                Ok(None) => break,
                Err(error) => {
                    state.refused = Some(format!("{error:?}"));
                    break;
                }
            }
        }
    }
    any
}

fn publish(estimate: &Estimate, engine: &mut Engine, outputs: &Outputs, state: &mut State) {
    let wiring = &engine.setup().wiring;
    if !estimate.of_scan && !wiring.sensors.is_empty() {
        return;
    }
    let (frames, kind) = (wiring.frames.clone(), engine.setup().description.vehicle.kind);
    // The last odometry pose at the time of the estimate.
    while state.placed.get(1).is_some_and(|(next_ns, _)| *next_ns <= estimate.stamp_ns) {
        state.placed.pop_front();
    }
    let placed = state.placed.front().copied();
    sent("pose", outputs.pose.publish(outputs::stamped(estimate, &frames)));
    sent("odometry", outputs.odometry.publish(outputs::odometry(estimate, &frames, kind)));
    sent("tf", outputs.transforms.publish(outputs::transforms(estimate, &frames, placed)));
    let due = state.shown_ns.is_none_or(|shown| estimate.stamp_ns.abs_diff(shown) >= FEATURES_NS);
    if due {
        state.shown_ns = Some(estimate.stamp_ns);
        let markers = outputs::features(engine.slam(), estimate.stamp_ns, &frames[0]);
        sent("features", outputs.features.publish(markers));
    }
}

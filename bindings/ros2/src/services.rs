//! Services of a node, all of the type `std_srvs/srv/Trigger`.

use crate::engine::Engine;
use crate::middleware::{Arguments, Failure, parted};
use ros2_client::dds::rustdds::mio1::{Interest, Registry, Token};
use ros2_client::qos::History;
use ros2_client::{Message, Node, QosProfile, Server, ServiceMapping, ServiceTypeName};
use serde::{Deserialize, Serialize};
use std::env;
use std::fs;
use std::path::Path;

/// `std_srvs/srv/Trigger`: CDR requires at least one byte, also in an empty request.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Request {
    structure_needs_at_least_one_member: u8,
}

impl Message for Request {}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Response {
    success: bool,
    message: String,
}

impl Message for Response {}

type Work = fn(&mut Engine, &Path) -> Result<String, String>;

/// Name and function of each service.
const SERVICES: [(&str, Work); 4] = [
    ("~/reset", |engine, _| engine.reset().map(|()| "started again".into()).map_err(|error| error.to_string())),
    ("~/save_map", |engine, file| {
        let (count, bytes) = engine.map()?;
        fs::write(file, bytes).map_err(|error| format!("{}: {error}", file.display()))?;
        Ok(format!("{count} features saved to {}", file.display()))
    }),
    ("~/load_map", |engine, file| {
        let count = engine.load_map(&read(file)?)?;
        Ok(format!("{count} features loaded; the pose is as it was"))
    }),
    ("~/locate", |engine, file| {
        engine.locate(&read(file)?)?;
        Ok("looks for its place: it is in the map once diagnostics say so".into())
    }),
];

fn read(file: &Path) -> Result<Vec<u8>, String> {
    fs::read(file).map_err(|error| format!("{}: {error}", file.display()))
}

/// The services of a node.
#[expect(missing_debug_implementations, reason = "servers of the middleware have none")]
pub struct Services(Vec<Server<Request, Response>>);

impl Services {
    /// Starts the services, with event tokens from `first` on.
    pub fn new(node: &mut Node, arguments: &Arguments, registry: &Registry, first: usize) -> Result<Self, Failure> {
        // Middlewares of ROS 2 associate responses with requests in different ways.
        let cyclone = env::var("RMW_IMPLEMENTATION").is_ok_and(|name| name == "rmw_cyclonedds_cpp");
        let mapping = if cyclone { ServiceMapping::Cyclone } else { ServiceMapping::Enhanced };
        let quality = QosProfile::publisher_default().history(History::KeepLast { depth: 10 });
        let mut servers = Vec::new();
        for (place, (name, _)) in SERVICES.iter().enumerate() {
            let name = parted(&arguments.resolved(name))?;
            let kind = ServiceTypeName::new("std_srvs", "Trigger");
            let refused = |error: &dyn std::fmt::Debug| Failure(format!("{name}: {error:?}"));
            let server = node.create_server(mapping, &name, &kind, quality.clone(), quality.clone());
            let mut server = server.map_err(|error| refused(&error))?;
            let registered = registry.register(&mut server, Token(first + place), Interest::READABLE);
            registered.map_err(|error| refused(&error))?;
            servers.push(server);
        }
        Ok(Self(servers))
    }

    /// Answers waiting requests.
    pub fn answer(&self, engine: &mut Engine, map: &Path) {
        for (server, (name, work)) in self.0.iter().zip(SERVICES) {
            while let Ok(Some((id, _))) = server.receive_request() {
                let (success, message) = match work(engine, map) {
                    Ok(message) => (true, message),
                    Err(message) => (false, message),
                };
                println!("{name}: {message}");
                if let Err(error) = server.send_response(id, Response { success, message }) {
                    eprintln!("{name}: no answer: {error:?}");
                }
            }
        }
    }
}

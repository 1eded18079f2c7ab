//! Replays a stream of a planar vehicle on the host while bits of the filter's state flip, and prints the result of every round
//! in the same format as the firmware image `flips`: of the mixture or the joint map, as the stream says.

use scphd_stream::planar::{Planar, PlanarJoint};
use scphd_stream::{Aboard, FLIP_SEEDS, Failing, Monitor, Reader, Round, ScanCost, Seen, replay_with_flips};
use std::process::ExitCode;
use std::time::Instant;

/// Stack of the thread that replays, bytes: an unoptimised build constructs the memory on the stack before it moves it to the
/// heap.
const STACK_BYTES: usize = 64 << 20;
/// Capacity for a snapshot, bytes.
const ROOM: usize = 256 << 10;

/// A clock in nanoseconds.
struct Clock(Instant);

impl Monitor for Clock {
    fn start(&mut self) {
        self.0 = Instant::now();
    }

    fn elapsed(&mut self) -> u64 {
        self.0.elapsed().as_nanos() as u64
    }

    fn scanned(&mut self, _: &ScanCost, _: &Seen, _: u64) {}
}

fn run<A>(name: &str, stream: &[u8], seed: u64) -> Result<(), String>
where
    A: Aboard<f32>,
    for<'m> A::Filter<'m>: Failing<A::Kind>,
{
    let (mut memory, mut room) = (Box::new(A::MEMORY), vec![0; ROOM]);
    let print = |told: &Round| {
        let Round { round, flips, mended, isolated, refused, worst, digest } = told;
        println!(
            "round {round} of {name} flips {flips} mended {mended} isolated {isolated} refused {refused} digest {digest:016x}"
        );
        println!("worst {worst}");
    };
    replay_with_flips::<A>(stream, &mut memory, &mut room, seed, &mut Clock(Instant::now()), print)
        .map_err(|error| format!("{name}: {error}"))
}

fn execute() -> Result<(), String> {
    let path = std::env::args().nth(1).ok_or("usage: scphd-flips FILE")?;
    let stream = std::fs::read(&path).map_err(|error| format!("{path}: {error}"))?;
    let [of_mixture, of_joint] = FLIP_SEEDS;
    let is_joint = Reader::<Planar>::open(&stream).is_ok_and(|reader| reader.is_of_joint_map());
    let work = move || match is_joint {
        true => run::<PlanarJoint>("joint", &stream, of_joint),
        false => run::<Planar>("mixture", &stream, of_mixture),
    };
    let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn(work);
    let thread = thread.map_err(|error| format!("cannot start a thread: {error}"))?;
    thread.join().unwrap_or_else(|_| Err("the replay panicked".into()))
}

fn main() -> ExitCode {
    match execute() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

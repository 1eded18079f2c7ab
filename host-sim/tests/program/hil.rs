//! `scphd-sim hil` with a target in a thread, over a local connection.

use scphd_link::{Gaps, Target, Unit};
use scphd_stream::planar::{BlackBox, BlackBoxJoint, Planar};
use scphd_stream::{Aboard, Monitor, ScanCost, Seen};
use std::io::{self, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::process::{Command, Output};
use std::thread;

/// An unoptimised build creates the memory on the stack first.
const STACK_BYTES: usize = 64 << 20;

struct Line(BufReader<TcpStream>);

impl embedded_io::ErrorType for Line {
    type Error = embedded_io::ErrorKind;
}

fn kind(_: io::Error) -> embedded_io::ErrorKind {
    embedded_io::ErrorKind::Other
}

impl embedded_io::Read for Line {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Self::Error> {
        self.0.read(buffer).map_err(kind)
    }
}

impl embedded_io::Write for Line {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        self.0.get_mut().write(bytes).map_err(kind)
    }

    fn flush(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }
}

struct Idle;

impl Monitor for Idle {
    fn start(&mut self) {}

    fn elapsed(&mut self) -> u64 {
        1
    }

    fn scanned(&mut self, _: &ScanCost, _: &Seen, _: u64) {}
}

/// A target for this number of connections, in sequence.
fn target<A: Aboard<f32, Kind = Planar> + 'static>(connections: usize) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let serve = move || {
        let (mut memory, mut target) = (Box::new(A::MEMORY), Target::<8192, 256>::new(Gaps::Refused));
        for _ in 0..connections {
            let mut line = Line(BufReader::new(listener.accept().unwrap().0));
            line.0.get_mut().set_nodelay(true).unwrap();
            // The other end closes the connection.
            let _ = target.serve::<A, f32, _>(&mut line, &mut memory, Unit::Nanoseconds, &mut Idle);
        }
    };
    thread::Builder::new().stack_size(STACK_BYTES).spawn(serve).unwrap();
    address
}

fn hil(port: &str, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scphd-sim"));
    command.args(["hil", "thesis-dynamic", "--port", port]);
    // A joint map has no particles.
    if !more.contains(&"joint") {
        command.args(["--samples", "2"]);
        if !more.contains(&"--particles") {
            command.args(["--particles", "8"]);
        }
    }
    command.args(more).output().unwrap()
}

/// Exit code, standard output, standard error.
fn said(output: Output) -> (Option<i32>, String, String) {
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn digests_are_those_of_the_host_over_a_good_and_a_bad_line() {
    let port = format!("tcp:{}", target::<BlackBox>(2));
    let (code, out, err) = said(hil(&port, &["--scans", "30"]));
    assert_eq!((code, err.as_str()), (Some(0), ""), "{out}");
    assert!(out.contains("30 scans, 30 digests equal, 0 different"), "{out}");
    assert!(out.contains("frames: 90 sent, 0 of them repeats"), "{out}");
    assert!(out.contains("the target has accepted 90, refused none, missed 0"), "{out}");
    assert_eq!(out.lines().filter(|line| line.contains("  yes  ")).count(), 30);

    let bad = ["--lose", "0.03", "--flip", "0.001", "--double", "0.05", "--late", "0.05", "--timeout-ms", "100"];
    let (code, out, err) = said(hil(&port, &[&["--scans", "30"], &bad[..]].concat()));
    assert_eq!((code, err.as_str()), (Some(0), ""), "{out}");
    assert!(out.contains("30 scans, 30 digests equal, 0 different"), "{out}");
    for refused in ["damaged", "doubled", "ahead of a missing one"] {
        assert!(out.contains(refused), "{refused} in {out}");
    }
}

#[test]
fn a_target_with_another_filter_is_refused() {
    let port = format!("tcp:{}", target::<BlackBoxJoint>(2));
    let (code, out, err) = said(hil(&port, &["--scans", "5"]));
    assert_eq!(code, Some(2), "{out}");
    assert!(err.contains("the target cannot"), "{err}");
    let (code, out, _) = said(hil(&port, &["--scans", "5", "--filter", "joint", "--moving", "off"]));
    assert_eq!(code, Some(0), "{out}");
}

#[test]
fn impossible_requests_are_reported() {
    for (port, more, told) in [
        ("tcp:5555", &[][..], "ADDRESS:PORT"),
        ("/dev/no-such-device", &["--scans", "2"], "--port: "),
        ("tcp:127.0.0.1:1", &["--flip", "1"], "less than 1"),
        ("tcp:127.0.0.1:1", &["--scans", "2", "--particles", "33"], "room for 32 particles"),
    ] {
        let (code, _, err) = said(hil(port, more));
        assert!(code == Some(2) && err.contains(told), "{port} {more:?}: {err}");
    }
    // A target without answers is given up.
    let silent = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp:{}", silent.local_addr().unwrap());
    let (code, _, err) = said(hil(&port, &["--scans", "2", "--timeout-ms", "10", "--repeats", "3"]));
    assert!(code == Some(1) && err.contains("no answer from the target to frame 0 after 3 repeats"), "{err}");
}

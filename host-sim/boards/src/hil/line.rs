//! The line to a target: a serial port, or a TCP connection.

use std::collections::VecDeque;
use std::fs::OpenOptions;
use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Greatest time to wait for a listener, for example an emulator that was started at the same time.
const CONNECT_WITHIN: Duration = Duration::from_secs(10);
/// Time between attempts.
const CONNECT_AGAIN: Duration = Duration::from_millis(50);

/// Address of a target.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Port {
    /// `tcp:ADDRESS:PORT`.
    Tcp(SocketAddr),
    /// A serial device, which must already have its baud rate and raw mode.
    Device(PathBuf),
}

impl FromStr for Port {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.strip_prefix("tcp:") {
            Some(address) => {
                let address =
                    address.parse().map_err(|_| format!("`{address}` is no ADDRESS:PORT, as 127.0.0.1:5555"))?;
                Ok(Self::Tcp(address))
            }
            None => Ok(Self::Device(text.into())),
        }
    }
}

/// A line that is read by a thread of its own.
pub struct Line {
    out: Box<dyn Write + Send>,
    pieces: Receiver<Vec<u8>>,
    bytes: VecDeque<u8>,
}

impl Line {
    /// Opens the port; waits for a listener for a limited time.
    pub fn open(port: &Port) -> io::Result<Self> {
        match port {
            Port::Device(path) => {
                let device = OpenOptions::new().read(true).write(true).open(path)?;
                Ok(Self::over(device.try_clone()?, device))
            }
            Port::Tcp(address) => {
                let begun = Instant::now();
                loop {
                    match TcpStream::connect(address) {
                        Ok(stream) => return Self::over_tcp(stream),
                        Err(error) if begun.elapsed() > CONNECT_WITHIN => return Err(error),
                        Err(_) => thread::sleep(CONNECT_AGAIN),
                    }
                }
            }
        }
    }

    pub fn over_tcp(stream: TcpStream) -> io::Result<Self> {
        // Frames are small, and must not be delayed.
        stream.set_nodelay(true)?;
        Ok(Self::over(stream.try_clone()?, stream))
    }

    /// A line over any input and output.
    pub fn over(mut input: impl Read + Send + 'static, output: impl Write + Send + 'static) -> Self {
        let (sender, pieces) = channel();
        // The thread ends with the line, or with the program.
        thread::spawn(move || {
            let mut piece = [0; 4096];
            loop {
                match input.read(&mut piece) {
                    Ok(len) if len > 0 => {
                        if sender.send(piece[..len].to_vec()).is_err() {
                            break;
                        }
                    }
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    _ => break,
                }
            }
        });
        Self { out: Box::new(output), pieces, bytes: VecDeque::new() }
    }

    /// Sends bytes.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.out.flush()
    }

    /// The next byte; `None` if none arrives in time.
    pub fn byte(&mut self, until: Instant) -> io::Result<Option<u8>> {
        if self.bytes.is_empty() {
            match self.pieces.recv_timeout(until.saturating_duration_since(Instant::now())) {
                Ok(piece) => self.bytes.extend(piece),
                Err(RecvTimeoutError::Timeout) => return Ok(None),
                Err(RecvTimeoutError::Disconnected) => return Err(io::ErrorKind::UnexpectedEof.into()),
            }
        }
        Ok(self.bytes.pop_front())
    }
}

impl std::fmt::Debug for Line {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Line").field("bytes", &self.bytes.len()).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_addresses_or_devices() {
        assert_eq!("tcp:127.0.0.1:5555".parse(), Ok(Port::Tcp(([127, 0, 0, 1], 5555).into())));
        assert_eq!("/dev/ttyACM0".parse(), Ok(Port::Device("/dev/ttyACM0".into())));
        assert!("tcp:5555".parse::<Port>().unwrap_err().contains("ADDRESS:PORT"));
    }
}

//! Reads and rewrites messages; `peer.py` compares the bytes with those of rosbags. A line of the input is a type and the bytes
//! of a message in hexadecimal digits; the output is the rewritten bytes. For a line with only a type, the output is its
//! definition, with `|` for line breaks.

use scphd_ros::messages::{
    AckermannDriveStamped, Detection3DArray, DiagnosticArray, Imu, JointState, LaserScan, MarkerArray, NavSatFix,
    Odometry, PointCloud2, PoseArray, PoseStamped, PoseWithCovarianceStamped, RadarScan, TFMessage,
};
use scphd_ros::{CdrError, Message, decode, encode, full_text};
use std::io::{self, BufRead};

fn again<M: Message>(bytes: Option<&[u8]>) -> Result<String, CdrError> {
    let Some(bytes) = bytes else { return Ok(full_text(M::DEFINITION).replace('\n', "|")) };
    let bytes = encode(&decode::<M>(bytes)?)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

fn answer(kind: &str, bytes: Option<&[u8]>) -> Option<Result<String, CdrError>> {
    macro_rules! of {
        ($($type:ty),* $(,)?) => {
            match kind {
                $(_ if kind == <$type>::DEFINITION.name => Some(again::<$type>(bytes)),)*
                _ => None,
            }
        };
    }
    of!(
        AckermannDriveStamped, Detection3DArray, DiagnosticArray, Imu, JointState, LaserScan, MarkerArray, NavSatFix,
        Odometry, PointCloud2, PoseArray, PoseStamped, PoseWithCovarianceStamped, RadarScan, TFMessage,
    )
}

fn main() -> io::Result<()> {
    for line in io::stdin().lock().lines() {
        let line = line?;
        let (kind, digits) = line.split_once(' ').map_or((line.as_str(), None), |(kind, digits)| (kind, Some(digits)));
        let bytes = digits.map(|digits| {
            let pairs = digits.as_bytes().chunks(2).map(|pair| std::str::from_utf8(pair).unwrap_or_default());
            pairs.map(|pair| u8::from_str_radix(pair, 16).unwrap_or(0)).collect::<Vec<u8>>()
        });
        match answer(kind, bytes.as_deref()) {
            Some(Ok(text)) => println!("{text}"),
            Some(Err(error)) => println!("error: {error}"),
            None => println!("error: {kind} is unknown"),
        }
    }
    Ok(())
}

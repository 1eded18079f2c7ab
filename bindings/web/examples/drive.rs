//! Writes the inputs of described filters for `tests/module.mjs`, number by number as the bits of a double, and the digests of the
//! session on the host after them, which `tests/drive.rs` compares with the library.

#[path = "../tests/kinds/mod.rs"]
mod kinds;

use kinds::{HELD, described, inputs};
use scphd_drive::{Event, control, take};
use scphd_vehicle::Control;
use scphd_web::Session;

/// The place of the joint map with tracks, of which the page has room for more features than C.
const TRACKED: usize = 4;

fn write(call: &str, numbers: impl IntoIterator<Item = f64>) {
    let numbers: String = numbers.into_iter().map(|number| format!(" {:016x}", number.to_bits())).collect();
    println!("{call}{numbers}");
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut session = Box::new(Session::NEW);
    for place in HELD.into_iter().chain([TRACKED]) {
        let described = described(place);
        session.describe(&described.numbers()).map_err(|_| "refused")?;
        write("describe", described.numbers());
        for event in inputs() {
            take(session.filter().map_err(|_| "not started")?.services(), &described, &event)?;
            let scan = |sensor: f64, scan: &[[f32; 2]]| {
                write("scan", [sensor].into_iter().chain(scan.as_flattened().iter().copied().map(f64::from)));
            };
            match &event {
                &Event::Predict([speed_mps, rate_radps, dt_s]) => {
                    let Control { speed_mps, left_mps, turn } = control(described.vehicle.kind, speed_mps, rate_radps);
                    write("predict", [speed_mps, left_mps, turn, dt_s].map(f64::from));
                }
                Event::Lidar(of) => scan(0.0, of),
                Event::Radar(of) => scan(1.0, of),
                Event::Position(place_m) => write("position", place_m.map(f64::from)),
                Event::Heading(heading_rad) => write("heading", [f64::from(*heading_rad)]),
                Event::Camera(_) | Event::Dive(_) | Event::Sonar(_) | Event::Height(_) => {}
                Event::Compare => println!("digest {:016x}", session.digest()),
            }
        }
    }
    Ok(())
}

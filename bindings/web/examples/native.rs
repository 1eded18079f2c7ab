//! The drive that `cargo xtask web` compares: digests at regular intervals of scans, as on the page. `native SCANS EVERY`

use scphd_web::{Session, Surroundings, Wish};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers: Vec<u32> = std::env::args().skip(1).map(|word| word.parse()).collect::<Result<_, _>>()?;
    let [scans, every] = numbers[..] else { return Err("usage: native SCANS EVERY".into()) };
    let mut session = Box::new(Session::NEW);
    // A joint map, then a mixture of 64 particles.
    for (particles, scan) in [0, 64].into_iter().flat_map(|particles| (0..scans).map(move |scan| (particles, scan))) {
        if scan == 0 {
            session.start(1, particles).map_err(|_| "not started")?;
        }
        // As `rehearse` in page.js: with some manual driving and changes of the sliders.
        let wish = match scan % 200 {
            150.. => Wish::Manual { speed_mps: 2.0, rate_radps: 0.5 },
            _ => Wish::Automatic,
        };
        let around = if scan % 300 < 200 { (5.0, 0.9) } else { (15.0, 0.75) };
        let around = Surroundings { clutter: around.0, detection: around.1 };
        session.step(wish, around, scan % 500 < 400).map_err(|_| "refused")?;
        if (scan + 1) % every == 0 {
            println!("{} {:016x}", scan + 1, session.digest());
        }
    }
    Ok(())
}

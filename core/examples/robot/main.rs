//! A robot with a lidar, a radar and a satellite receiver: see `drive.rs`, which a board runs as well.

mod drive;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let outcome = drive::drive(&mut Box::new(drive::Memory::NEW))?;
    let drive::Outcome { rmse_m, dead_reckoning_m, digest } = outcome;
    println!(
        "{rmse_m:.3} m RMSE over two minutes; dead reckoning {dead_reckoning_m:.2} m at the end; digest {digest:016x}"
    );
    assert!(rmse_m < 0.3 && rmse_m < dead_reckoning_m);
    Ok(())
}

#[test]
fn it_ends_well() {
    main().unwrap();
}

//! A robot with a lidar, a radar and a satellite receiver, by either filter: see `drive.rs`, which a board runs as well.

mod drive;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let outcome = drive::drive(&mut Box::new(drive::Memory::NEW))?;
    let drive::Outcome { rmse_m: [mixture, joint], dead_reckoning_m, digests: [of_mixture, of_joint] } = outcome;
    println!(
        "{mixture:.3} m RMSE over two minutes by the mixture, {joint:.3} m by the joint map; dead reckoning {dead_reckoning_m:.2} m \
         at the end; digests {of_mixture:016x} {of_joint:016x}"
    );
    assert!(mixture < 0.1 && joint < 0.1 && dead_reckoning_m > 1.0);
    Ok(())
}

#[test]
fn it_ends_well() {
    main().unwrap();
}

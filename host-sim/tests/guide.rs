//! The commands and files of the guide work as printed.

use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

const YOUR_LOG: &str = include_str!("../../docs/guide/your-log.md");

/// The code blocks of a language.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    page.split(fence.as_str()).skip(1).filter_map(|rest| rest.split_once("\n```").map(|(block, _)| block)).collect()
}

fn succeeds(words: &[&str], folder: &Path) {
    let output = Command::new(env!("CARGO_BIN_EXE_scphd-sim")).args(words).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// A vehicle that drives straight for five seconds past two poles, with the smallest possible log.
fn write_log(folder: &Path) {
    fs::create_dir(folder).unwrap();
    let [head] = blocks(YOUR_LOG, "toml")[..] else { panic!("one log.toml") };
    let (mut odometry, mut scans) = (String::from("t_s,v_mps,omega_radps\n"), String::from("scan,t_s\n"));
    let mut detections = String::from("scan,range_m,bearing_rad\n");
    for k in 0..50_u32 {
        let t_s = 0.1 * f64::from(k);
        odometry += &format!("{t_s:.2},1.0,0.0\n");
        scans += &format!("{k},{t_s:.2}\n");
        for [x_m, y_m] in [[12.0, 3.0], [9.0, -4.0]] {
            let (dx, dy): (f64, f64) = (x_m - t_s, y_m);
            // An error of a few millimetres, because no sensor is exact.
            detections += &format!("{k},{:.4},{:.5}\n", dx.hypot(dy) + 0.002 * (7.0 * t_s).sin(), dy.atan2(dx));
        }
    }
    let files =
        [("log.toml", head), ("odometry.csv", &odometry), ("scans.csv", &scans), ("detections.csv", &detections)];
    for (name, text) in files {
        fs::write(folder.join(name), text).unwrap();
    }
}

#[test]
fn the_commands_of_your_log_work_as_printed() {
    let place = TempDir::new().unwrap();
    write_log(&place.path().join("LOG"));
    let mut ran = 0;
    for command in blocks(YOUR_LOG, "sh").into_iter().flat_map(str::lines) {
        let words: Vec<_> = command.split_whitespace().collect();
        let ["scphd-sim", words @ ..] = &words[..] else { panic!("{command}") };
        succeeds(words, place.path());
        ran += 1;
    }
    assert_eq!(ran, 7);
    assert!(["run.html", "ekf.html", "both.html"].iter().all(|page| place.path().join(page).exists()));
}

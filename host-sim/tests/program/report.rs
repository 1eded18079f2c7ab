//! The page of a run: its numbers are those of the JSON output and of the tables of the same run.

use crate::place::Place;
use serde_json::Value;
use std::collections::HashMap;
use std::fs;
use std::path::Path;

/// A page and the other outputs of the same run.
struct Written {
    page: String,
    data: Value,
    /// The JSON output.
    summary: Value,
    /// The columns of `scans.csv`.
    scans: HashMap<String, Vec<String>>,
}

fn written(args: &[&str]) -> Written {
    let place = Place::new();
    place.succeeds(&[args, &["--html", "page.html", "--json", "run.json", "--out", "out"]].concat());
    let text = |name: &str| fs::read_to_string(place.path(name)).unwrap();
    let page = text("page.html");
    let begin = "<script type=\"application/json\" id=\"data\">";
    let data = page.split_once(begin).unwrap().1.split_once("</script>").unwrap().0;
    let table = text("out/scans.csv");
    let mut lines = table.lines();
    let titles: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let column = |k: usize| rows.iter().map(|row| row[k].to_owned()).collect();
    let scans = titles.iter().enumerate().map(|(k, title)| ((*title).to_owned(), column(k))).collect();
    Written { data: serde_json::from_str(data).unwrap(), summary: place.json("run.json"), page, scans }
}

/// Checks every number of the page that another output has too.
fn holds_what_the_run_wrote(run: &Written) {
    let Written { page, data, summary, scans } = run;
    assert_eq!(&data["summary"], summary);
    for (key, _) in summary.as_object().unwrap() {
        let known = data["meanings"].as_array().unwrap().iter().any(|row| row[0] == **key);
        assert!(known, "{key} has no meaning");
    }
    // The points of the curves are rows of the table, to the last bit.
    let series = &data["series"];
    let places: Vec<usize> = series["scan"].as_array().unwrap().iter().map(|k| k.as_u64().unwrap() as usize).collect();
    let all = summary["scans"].as_u64().unwrap() as usize;
    assert_eq!((places[0], places[places.len() - 1]), (0, all - 1));
    assert!(places.windows(2).all(|pair| pair[0] < pair[1]));
    let of = |title: &str, k: usize| scans[title][places[k]].parse::<f64>().ok();
    let coordinates = data["axes"].as_array().unwrap();
    for k in 0..places.len() {
        let columns = ["t_s", "position_error_m", "n_eff", "features_estimated", "measurements", "scan_us"];
        for title in columns.into_iter().filter(|title| scans.contains_key(*title)) {
            assert_eq!(series[title][k].as_f64(), of(title, k), "{title}, scan {}", places[k]);
        }
        for (axis, name) in coordinates.iter().enumerate() {
            let title = format!("{}_m", name.as_str().unwrap());
            assert_eq!(series["position"][k][axis].as_f64(), of(&title, k), "{title}");
            for path in ["dead_reckoning", "true"] {
                let (key, title) = (if path == "true" { "truth" } else { path }, format!("{path}_{title}"));
                assert_eq!(series[key][k][axis].as_f64(), of(&title, k), "{title}");
            }
        }
    }
    // The figures follow from them if no row was left out.
    if places.len() == all {
        let squares: Vec<f64> =
            series["position_error_m"].as_array().unwrap().iter().filter_map(|e| e.as_f64()).map(|e| e * e).collect();
        let rmse = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        assert!((rmse - summary["position_rmse_m"].as_f64().unwrap()).abs() < 1e-9, "{rmse}");
    }
    // Every frame has all detections of its scan with a position in the map.
    let frames = data["frames"].as_array().unwrap();
    assert_eq!(frames.len(), all.min(400));
    for frame in frames {
        let scan = frame["scan"].as_u64().unwrap() as usize;
        let measured: usize = scans["measurements"][scan].parse().unwrap();
        let drawn = frame["detections"].as_array().unwrap().len();
        assert!(drawn <= measured && (coordinates.len() > 2 || drawn == measured), "scan {scan}");
    }
    let last = &frames[frames.len() - 1];
    for (axis, name) in coordinates.iter().enumerate() {
        let exact = scans[&format!("{}_m", name.as_str().unwrap())][all - 1].parse::<f64>().unwrap();
        assert!((last["pose"][axis].as_f64().unwrap() - exact).abs() <= 5.1e-4);
    }
    // Settings, each with its origin.
    let settings = data["settings_text"].as_str().unwrap();
    let lines: Vec<&str> = settings.lines().filter(|line| line.contains(" = ")).collect();
    assert!(lines.len() > 10 && lines.iter().all(|line| line.contains('#')), "{settings}");
    for reported in data["health"].as_array().unwrap() {
        assert!(reported["cause"].is_string() && reported["action"].is_string(), "{reported}");
        let inside: u64 = reported["spells"]
            .as_array()
            .unwrap()
            .iter()
            .map(|spell| spell[1].as_u64().unwrap() - spell[0].as_u64().unwrap() + 1)
            .sum();
        assert_eq!(inside, reported["scans"].as_u64().unwrap());
    }
    // The page needs no network.
    for word in ["http:", "https:", "src=", "href=", "@import", "url(", "fetch(", "XMLHttpRequest", "{{"] {
        assert!(!page.contains(word), "{word}");
    }
}

#[test]
fn of_thesis_dynamic() {
    let run = written(&["run", "thesis-dynamic"]);
    holds_what_the_run_wrote(&run);
    // The stages are parts of the scan, and nearly all of it.
    let series = &run.data["series"];
    let stages = ["predict", "weigh", "resample", "update", "reduce"].map(|stage| &series[format!("stage_{stage}_us")]);
    let all = series["scan_us"].as_array().unwrap();
    let mut shares = 0.0;
    for (k, scan_us) in all.iter().enumerate() {
        let sum: f64 = stages.iter().map(|times| times[k].as_f64().unwrap()).sum();
        assert!(sum > 0.0 && sum <= scan_us.as_f64().unwrap(), "scan {k}: {sum} of {scan_us}");
        shares += sum / scan_us.as_f64().unwrap();
    }
    assert!(shares > 0.5 * all.len() as f64, "{shares} of {}", all.len());
    let frames = run.data["frames"].as_array().unwrap();
    let count = |key: &str| frames.iter().map(|frame| frame[key].as_array().unwrap().len()).sum::<usize>();
    assert!(count("particles") > frames.len() && count("moving") > 0 && count("movers") > 0);
    // In the middle of the run most detections of landmarks are near features, and most false ones are not: 20 of about 32 are
    // false.
    let (met, all) = frames[100..]
        .iter()
        .flat_map(|frame| frame["detections"].as_array().unwrap())
        .fold((0, 0), |(met, all), detection| (met + usize::from(detection[1] == true), all + 1));
    let share = f64::from(met as u32) / f64::from(all);
    assert!((0.25..0.6).contains(&share), "{share}");
}

/// Long runs: `cargo test --release -p scphd-sim --test program -- --ignored`.
#[test]
#[ignore = "takes minutes"]
fn of_long_runs() {
    let tank = written(&["run", "girona-tank"]);
    holds_what_the_run_wrote(&tank);
    let Some(park) = scphd_shared_data::find("victoria_park") else { return };
    let park = written(&["replay", Path::new(&park).to_str().unwrap()]);
    holds_what_the_run_wrote(&park);
    println!("girona-tank {} bytes, victoria_park {} bytes", tank.page.len(), park.page.len());
}

#[test]
fn a_page_is_for_a_single_run() {
    Place::new().fails(&["run", "survey", "--repeat", "2", "--html", "page.html"]);
}

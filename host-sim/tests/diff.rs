//! Two runs beside each other: what differs is what the runs themselves wrote.

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn program(place: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scphd-sim")).args(words).current_dir(place).output().unwrap()
}

fn done(place: &Path, words: &[&str]) -> String {
    let output = program(place, words);
    assert!(output.status.success(), "{words:?}: {output:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// What it says when it refuses, in one line.
fn refused(place: &Path, words: &[&str]) -> String {
    let output = program(place, words);
    assert_eq!(output.status.code(), Some(2), "{words:?}: {output:?}");
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    said
}

fn json(place: &Path, name: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(place.join(name)).unwrap()).unwrap()
}

#[test]
fn two_runs_beside_each_other() {
    let folder = TempDir::new().unwrap();
    let place = folder.path();
    let run = |name: &str, words: &[&str]| {
        let files = [format!("{name}.html"), format!("{name}.json")];
        let mut all = vec!["run", "thesis-dynamic", "-q", "--html", &files[0], "--json", &files[1]];
        all.extend(words);
        done(place, &all);
    };
    run("a", &["--particles", "4"]);
    run("b", &["--particles", "2"]);
    run("c", &["--particles", "4", "--scenario-seed", "7"]);

    let table = done(place, &["diff", "a.html", "b.html", "--html", "both.html", "--json", "both.json"]);
    assert!(table.lines().any(|line| line.split_whitespace().eq(["filter.particles", "4", "2"])), "{table}");
    let [a, b, both] = ["a.json", "b.json", "both.json"].map(|name| json(place, name));
    // Pages and JSON of the same runs tell the same, but for the names.
    done(place, &["diff", "a.json", "b.json", "-q", "--json", "plain.json"]);
    let plain = json(place, "plain.json");
    assert_eq!((&plain["figures"], &plain["settings"]), (&both["figures"], &both["settings"]));
    let settings: Vec<&str> =
        both["settings"].as_array().unwrap().iter().map(|row| row["setting"].as_str().unwrap()).collect();
    assert_eq!(settings, ["filter.particles"]);
    let figures = both["figures"].as_array().unwrap();
    assert!(figures.len() > 20, "{figures:?}");
    for row in figures {
        let key = row["key"].as_str().unwrap();
        assert_eq!((&row["a"], &row["b"]), (&a[key], &b[key]), "{key}");
        if let Some(off) = row["difference"].as_f64() {
            assert_eq!(off, b[key].as_f64().unwrap() - a[key].as_f64().unwrap(), "{key}");
        }
    }

    // The page has the curves of both, and asks nothing of a network.
    let page = fs::read_to_string(place.join("both.html")).unwrap();
    let data = page.split_once("id=\"data\">").unwrap().1.split_once("</script>").unwrap().0;
    let data: Value = serde_json::from_str(data).unwrap();
    for (place_in, name) in ["a.html", "b.html"].into_iter().enumerate() {
        let own = fs::read_to_string(place.join(name)).unwrap();
        let own = own.split_once("id=\"data\">").unwrap().1.split_once("</script>").unwrap().0;
        let own: Value = serde_json::from_str(own).unwrap();
        assert_eq!(data["runs"][place_in]["series"], own["series"]);
        assert_eq!(data["runs"][place_in]["last"], *own["frames"].as_array().unwrap().last().unwrap());
    }
    for word in ["http:", "https:", "src=", "href=", "@import", "url(", "fetch(", "XMLHttpRequest", "{{"] {
        assert!(!page.contains(word), "{word}");
    }

    // The same scenario with other noise is another log.
    let said = refused(place, &["diff", "a.html", "c.html"]);
    assert!(said.contains("measurements differ") && said.contains("--anyway"), "{said}");
    done(place, &["diff", "a.html", "c.html", "--anyway", "-q"]);
    assert!(refused(place, &["diff", "a.json", "b.json", "--html", "x.html"]).contains("no curves"));
    assert!(!place.join("x.html").exists());
    fs::write(place.join("not.json"), "[1, 2]").unwrap();
    assert!(refused(place, &["diff", "not.json", "b.json"]).contains("a list of 2"));
    assert!(refused(place, &["diff", "nowhere.html", "b.html"]).contains("nowhere.html"));
}

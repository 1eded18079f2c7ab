//! Comparison of two runs: the differences are those between the outputs of the runs.

use crate::place::Place;
use serde_json::Value;
use std::fs;

#[test]
fn two_runs_are_compared() {
    let place = Place::new();
    let run = |name: &str, words: &[&str]| {
        let files = [format!("{name}.html"), format!("{name}.json")];
        let mut all = vec!["run", "thesis-dynamic", "-q", "--html", &files[0], "--json", &files[1]];
        all.extend(words);
        place.prints(&all);
    };
    run("a", &["--particles", "4"]);
    run("b", &["--particles", "2"]);
    run("c", &["--particles", "4", "--scenario-seed", "7"]);

    let table = place.prints(&["diff", "a.html", "b.html", "--html", "both.html", "--json", "both.json"]);
    assert!(table.lines().any(|line| line.split_whitespace().eq(["filter.particles", "4", "2"])), "{table}");
    let [a, b, both] = ["a.json", "b.json", "both.json"].map(|name| place.json(name));
    // The comparison of pages and of JSON files is the same, except for the names.
    place.prints(&["diff", "a.json", "b.json", "-q", "--json", "plain.json"]);
    let plain = place.json("plain.json");
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

    // The page has the curves of both runs, and needs no network.
    let page = fs::read_to_string(place.path("both.html")).unwrap();
    let data = page.split_once("id=\"data\">").unwrap().1.split_once("</script>").unwrap().0;
    let data: Value = serde_json::from_str(data).unwrap();
    for (place_in, name) in ["a.html", "b.html"].into_iter().enumerate() {
        let own = fs::read_to_string(place.path(name)).unwrap();
        let own = own.split_once("id=\"data\">").unwrap().1.split_once("</script>").unwrap().0;
        let own: Value = serde_json::from_str(own).unwrap();
        assert_eq!(data["runs"][place_in]["series"], own["series"]);
        assert_eq!(data["runs"][place_in]["last"], *own["frames"].as_array().unwrap().last().unwrap());
    }
    for word in ["http:", "https:", "src=", "href=", "@import", "url(", "fetch(", "XMLHttpRequest", "{{"] {
        assert!(!page.contains(word), "{word}");
    }

    // The same scenario with other noise is another log.
    let said = place.fails(&["diff", "a.html", "c.html"]);
    assert!(said.contains("measurements differ") && said.contains("--anyway"), "{said}");
    place.prints(&["diff", "a.html", "c.html", "--anyway", "-q"]);
    assert!(place.fails(&["diff", "a.json", "b.json", "--html", "x.html"]).contains("no curves"));
    assert!(!place.path("x.html").exists());
    place.write("not.json", "[1, 2]");
    assert!(place.fails(&["diff", "not.json", "b.json"]).contains("a list of 2"));
    assert!(place.fails(&["diff", "nowhere.html", "b.html"]).contains("nowhere.html"));
}

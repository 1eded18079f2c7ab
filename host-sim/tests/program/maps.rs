//! A map of one drive, and other drives that start in it.

use crate::place::Place;

/// The line of the output with the digest.
fn digest(printed: &str) -> &str {
    printed.lines().find(|line| line.contains("digest")).unwrap()
}

#[test]
fn a_second_drive_finds_itself_in_the_map_of_the_first() {
    let place = Place::new();
    let of = |seed, more: &[&str]| {
        place.prints(&[&["run", "survey", "--filter", "joint", "--scenario-seed", seed], more].concat())
    };
    let first = of("1", &["--save-map", "survey.map"]);
    assert_eq!(digest(&first), digest(&of("1", &[])), "to save a map changes nothing");
    let located = of("2", &["--map", "survey.map", "--locate"]);
    let found = located.lines().find(|line| line.starts_with("found after ")).unwrap();
    assert!(found.contains("landmarks of the map"), "{found}");
    let known = of("2", &["--map", "survey.map"]);
    assert!(!known.contains("found after"));
    assert_ne!(digest(&known), digest(&of("2", &[])), "it starts in the map");
}

#[test]
fn invalid_maps_are_refused() {
    let place = Place::new();
    place.write("no.map", "no map");
    let cases: [(&[&str], &[&str]); 6] = [
        (&["run", "survey", "--filter", "joint", "--map", "nowhere.map"], &["nowhere.map"]),
        (&["run", "survey", "--filter", "joint", "--map", "no.map"], &["the map of another drive"]),
        (&["run", "survey", "--filter", "core", "--map", "no.map"], &["not used by --filter core, but by joint"]),
        (&["run", "survey", "--filter", "core", "--save-map", "a.map"], &["not used by --filter core, but by joint"]),
        (&["run", "survey", "--locate"], &["--map"]),
        (&["run", "survey", "--filter", "joint", "--repeat", "2", "--save-map", "a.map"], &["single run"]),
    ];
    place.refuses(&cases);
}

//! The page agrees with the library.

use scphd::Health;
use scphd_web::INTERVAL_S;

const SCRIPT: &str = include_str!("../page/page.js");

#[test]
fn warnings_are_in_the_order_of_their_bits() {
    let list = SCRIPT.split_once("const HEALTH = [").unwrap().1.split_once("];").unwrap().0;
    let of_page: Vec<&str> = list.split(',').map(|name| name.trim().trim_matches('"')).collect();
    let of_library: Vec<String> =
        Health::all().map(|condition| format!("{condition:?}").trim_matches(['{', '"', '}']).to_owned()).collect();
    assert_eq!(of_page, of_library);
    assert!(Health::all().enumerate().all(|(bit, condition)| condition.bits() == 1 << bit));
}

#[test]
fn the_page_has_the_interval_of_scans() {
    assert!(SCRIPT.contains(&format!("const INTERVAL_S = {INTERVAL_S};")));
}

#[test]
fn the_page_makes_no_network_requests() {
    let page = [SCRIPT, include_str!("../page/index.html"), include_str!("../page/page.css")].concat();
    for word in ["http:", "https:", "src=", "href=", "@import", "url(", "fetch(", "XMLHttpRequest", "import("] {
        assert!(!page.contains(word), "{word}");
    }
}

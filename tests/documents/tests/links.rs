//! Every link to a page of the project, or to a heading of one, is valid.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Folders without pages of the project.
const ASIDE: [&str; 4] = ["target", "out", "node_modules", "shared"];

/// Collects all pages below a folder.
fn pages(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if path.is_dir() {
            // Folders whose name begins with a dot belong to tools, except .github.
            if !ASIDE.contains(&name) && (!name.starts_with('.') || name == ".github") && !path.is_symlink() {
                pages(&path, into);
            }
        } else if path.extension().is_some_and(|extension| extension == "md") {
            into.push(path);
        }
    }
}

/// The text of a page without its code blocks.
fn prose(text: &str) -> String {
    let mut inside = false;
    let mut kept = String::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            inside = !inside;
        } else if !inside && !line.starts_with("    ") {
            kept.push_str(line);
            kept.push('\n');
        }
    }
    kept
}

fn links(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (place, _) in text.match_indices("](") {
        if let Some((target, _)) = text[place + 2..].split_once(')') {
            found.push(target.to_owned());
        }
    }
    found
}

fn anchors(text: &str) -> BTreeSet<String> {
    let heading = |line: &str| {
        let title = line.strip_prefix('#')?.trim_start_matches('#').trim();
        let kept = title.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
        Some(kept.collect::<String>().to_lowercase().replace(' ', "-"))
    };
    prose(text).lines().filter_map(heading).collect()
}

#[test]
fn every_link_is_valid() {
    let root = &Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut all = Vec::new();
    pages(root, &mut all);
    let mut dead = Vec::new();
    let mut followed = 0;
    for page in &all {
        let text = fs::read_to_string(page).unwrap();
        for link in links(&prose(&text)) {
            if link.contains("://") || link.starts_with("mailto:") {
                continue;
            }
            followed += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            let found = target.exists()
                && (anchor.is_empty() || fs::read_to_string(&target).is_ok_and(|text| anchors(&text).contains(anchor)));
            if !found {
                dead.push(format!("{}: {link}", page.strip_prefix(root).unwrap().display()));
            }
        }
    }
    assert!(dead.is_empty(), "{}", dead.join("\n"));
    assert!(all.len() > 20 && followed > 100, "{} pages, {followed} links", all.len());
}

#[test]
fn headings_have_the_anchors_of_links() {
    let names = anchors("# `a_b`: What, now?\n\ntext\n\n## 2. Two - three\n\n```sh\n# not one\n```\n");
    assert_eq!(names, ["a_b-what-now", "2-two---three"].map(str::to_owned).into());
    assert_eq!(links(&prose("see [a](b.md#c) and ![d](e.png)\n    [not](x)\n")), ["b.md#c", "e.png"]);
}

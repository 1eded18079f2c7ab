//! Candidate settings.

use super::change::{BIRTHS, Candidate, Change, Group, Said, scaled, size_of};
use super::learn::Learn;

/// Greatest number of candidates: six groups, two each.
pub(super) const MOST: usize = 12;

/// Candidates from `settings`: the result of the innovations, and half of that change, for each group, for all groups of the
/// sensor, and for all.
///
/// In a log that is not simulated the odometry noise is never lowered: most of its errors are constant, a scale or an offset, and
/// corrections from scan to scan do not show them.
pub fn candidates<K: Learn>(log: &K::Log, settings: &K::Settings, said: &[Said]) -> Vec<Candidate> {
    let mut all = Vec::new();
    let mut add = |group, how: &str, changes: Vec<Change>| {
        if !changes.is_empty() {
            all.push(Candidate { group, how: how.to_owned(), changes });
        }
    };
    let noise: Vec<&'static str> = K::NOISE.iter().flat_map(|noise| noise.fields).copied().collect();
    for (share, how) in [(1.0, "innovations"), (0.5, "half way")] {
        let of = |fields: &[&'static str]| learnt::<K>(settings, said, fields, share);
        let mut odometry = of(&K::ODOMETRY.concat());
        let more = |change: &Change| size_of(settings, change.field) < change.size();
        odometry.retain(|change| K::is_simulated(log) || more(change));
        let groups =
            [(Group::Noise, of(&noise)), (Group::Detection, of(K::DETECTION)), (Group::Clutter, of(&[K::CLUTTER]))];
        let sensor: Vec<Change> = groups.iter().flat_map(|(_, changes)| changes.clone()).collect();
        groups.into_iter().for_each(|(group, changes)| add(group, how, changes));
        add(Group::Sensor, how, sensor.clone());
        if !odometry.is_empty() {
            add(Group::Odometry, how, odometry.clone());
            add(Group::Together, how, [sensor, odometry].concat());
        }
    }
    all
}

/// Changes of these fields by a share of the result, on a logarithmic scale. Births change in proportion to clutter: their ratio
/// is the user's judgement.
fn learnt<K: Learn>(settings: &K::Settings, said: &[Said], fields: &[&'static str], share: f64) -> Vec<Change> {
    let mut changes = Vec::new();
    for said in said.iter().filter(|said| fields.contains(&said.field)) {
        let Some(to) = said.to.filter(|&to| said.now > 0.0 && to > 0.0) else { continue };
        let factor = (to / said.now).powf(share);
        if factor == 1.0 {
            continue;
        }
        changes.extend(scaled(settings, &[said.field], factor));
        if said.field == K::CLUTTER {
            changes.extend(scaled(settings, BIRTHS, factor));
        }
    }
    changes
}

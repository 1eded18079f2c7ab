//! Posts and reflectors in a scan.

use crate::post::{Post, wrap};
use crate::scan::{Beam, MISSING_STEPS, Scan};
use crate::settings::{PostSettings, SettingsError};
use heapless::Vec;

/// The posts in a scan, and counts of the clusters that are no posts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Found<const POSTS: usize> {
    /// The posts; the nearest ones if there are more than the capacity.
    pub posts: Vec<Post, POSTS>,
    /// Number of posts left out for lack of room.
    pub beyond: u32,
    /// Number of clusters with too few beams.
    pub small: u32,
    /// Number of clusters that are too wide or too narrow.
    pub misshapen: u32,
    /// Number of clusters next to a nearer object, which may occlude a part of them.
    pub hidden: u32,
    /// Number of clusters at the ends of the view, or next to a part of it that was not received.
    pub cut: u32,
}

/// Finds posts in a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PostFinder {
    settings: PostSettings,
}

/// Greatest number of adjacent beams without a return inside an object.
const HOLES: usize = 3;

/// A side of a beam, in the order of the scan.
#[derive(Clone, Copy)]
enum Side {
    Before,
    After,
}

/// Adjacent beams on one object, with a few beams without a return between them.
struct Cluster {
    first: usize,
    last: usize,
    beams: usize,
    /// Number of beams with a return.
    readings: usize,
    /// Sum of their ranges, m.
    sum_m: f32,
    /// Greatest intensity.
    intensity: f32,
}

/// The object adjacent to a cluster.
#[derive(PartialEq)]
enum Adjacent {
    /// A farther object, or none.
    Free,
    /// A nearer object.
    Nearer,
}

/// Classification of a cluster.
enum Verdict {
    Post(Post),
    Small,
    Misshapen,
    Hidden,
    Cut,
    /// Outside the limits of the range.
    Outside,
}

impl PostFinder {
    /// A finder of posts with these settings.
    ///
    /// # Errors
    /// A setting is out of range.
    pub fn new(settings: PostSettings) -> Result<Self, SettingsError> {
        settings.check()?;
        Ok(Self { settings })
    }

    /// The settings.
    pub fn settings(&self) -> &PostSettings {
        &self.settings
    }

    /// Finds the posts in a scan. Visits every beam a bounded number of times, and all posts once for each post beyond the
    /// capacity.
    #[must_use]
    pub fn find<const POSTS: usize, S: Scan>(&self, scan: &S) -> Found<POSTS> {
        let mut found = Found::default();
        let beams = scan.beams();
        // A closed scan is processed from the beginning of a cluster, so that no cluster is split.
        let begins = |&number: &usize| {
            scan.beam(number).filter(|beam| self.is_of_post(*beam)).is_some_and(|beam| {
                !matches!(near(scan, number, Side::Before), Near::Reading { beam: before, .. }
                    if self.is_of_post(before) && self.go_together(before, beam))
            })
        };
        let mut first = if scan.is_closed() { (0..beams).find(begins).unwrap_or(0) } else { 0 };
        let mut walked = 0;
        while walked < beams {
            let Some(mut last) = scan.beam(first) else { break };
            let mut cluster =
                Cluster { first, last: first, beams: 1, readings: 1, sum_m: last.range_m, intensity: last.intensity };
            if self.is_of_post(last) {
                while let Near::Reading { number, beam, steps } = near(scan, cluster.last, Side::After)
                    && walked + cluster.beams + steps <= beams
                    && self.go_together(last, beam)
                {
                    last = beam;
                    cluster.last = number;
                    cluster.beams += steps;
                    cluster.readings += 1;
                    cluster.sum_m += beam.range_m;
                    cluster.intensity = cluster.intensity.max(beam.intensity);
                }
                found.add(self.judge(scan, &cluster));
            }
            walked += cluster.beams;
            first = after(scan, cluster.last);
        }
        found
    }

    /// Whether a beam may be on a post.
    fn is_of_post(&self, beam: Beam) -> bool {
        let least = self.settings.min_intensity;
        beam.range_m > 0.0 && (least <= 0.0 || beam.intensity >= least)
    }

    /// Whether two adjacent beams are on the same object, if the first may be on a post.
    fn go_together(&self, last: Beam, next: Beam) -> bool {
        self.adjoin(last, next) && self.is_of_post(next)
    }

    fn adjoin(&self, one: Beam, other: Beam) -> bool {
        (one.range_m - other.range_m).abs() <= self.settings.gap_m
    }

    fn judge<S: Scan>(&self, scan: &S, cluster: &Cluster) -> Verdict {
        let Self { settings } = self;
        let &Cluster { first, last, beams, readings, sum_m, intensity } = cluster;
        let mean_m = sum_m / readings as f32;
        let (span_rad, step_rad) = (scan.between_rad(first, last), scan.step_rad().abs());
        let diameter = 2.0 * settings.radius_m;
        // A cluster that is too wide at its mean range, such as a wall, is also too wide at the range of its axis.
        let is_wide = mean_m * span_rad > diameter + settings.tolerance_m;
        let depth_m =
            if is_wide { 0.0 } else { settings.depth_m(beams, span_rad, mean_m + settings.radius_m, step_rad) };
        let range_m = mean_m + depth_m;
        if !(range_m >= settings.range_min_m && range_m <= settings.range_max_m) {
            return Verdict::Outside;
        }
        let edges = [(first, Side::Before), (last, Side::After)];
        let [before, after] = edges.map(|(edge, side)| self.adjacent(scan, edge, side));
        let (Some(before), Some(after)) = (before, after) else { return Verdict::Cut };
        if before == Adjacent::Nearer || after == Adjacent::Nearer {
            return Verdict::Hidden;
        }
        if readings < usize::from(settings.min_points) {
            return Verdict::Small;
        }
        // Each edge is up to a step beyond the outer beam.
        let (narrowest, widest) = (range_m * span_rad, range_m * (span_rad + 2.0 * step_rad));
        if narrowest > diameter + settings.tolerance_m || widest < diameter - settings.tolerance_m {
            return Verdict::Misshapen;
        }
        let first_rad = scan.beam(first).unwrap_or_default().bearing_rad;
        let bearing_rad = wrap(first_rad + 0.5 * span_rad.copysign(scan.step_rad()));
        // For a post across the ends of a closed scan, the mean of the times of its first and last half.
        let before_end_s = 0.5 * (scan.before_end_s(first) + scan.before_end_s(last));
        let points = u16::try_from(readings).unwrap_or(u16::MAX);
        Verdict::Post(Post { range_m, bearing_rad, before_end_s, points, intensity })
    }

    /// The object adjacent to the edge of a cluster; `None` if the view ends before a beam with a return.
    fn adjacent<S: Scan>(&self, scan: &S, edge: usize, side: Side) -> Option<Adjacent> {
        let last = scan.beam(edge)?;
        match near(scan, edge, side) {
            Near::End => None,
            // A beam with low intensity at the same range as a reflector is on the mount of the reflector.
            Near::Reading { beam, .. } if beam.range_m < last.range_m && !self.adjoin(last, beam) => {
                Some(Adjacent::Nearer)
            }
            Near::Reading { .. } | Near::Nothing => Some(Adjacent::Free),
        }
    }
}

/// The nearest beam with a return next to another one.
enum Near {
    /// The beam, its index, and its distance in beams.
    Reading { number: usize, beam: Beam, steps: usize },
    /// No return within the greatest number of beams inside an object.
    Nothing,
    /// The view ends first.
    End,
}

fn near<S: Scan>(scan: &S, from: usize, side: Side) -> Near {
    let mut at = from;
    for steps in 1..=1 + HOLES {
        let Some(number) = neighbour(scan, at, side) else { return Near::End };
        let Some(beam) = scan.beam(number) else { return Near::End };
        if beam.range_m > 0.0 {
            return Near::Reading { number, beam, steps };
        }
        at = number;
    }
    Near::Nothing
}

/// Index of the next beam; the first after the last one.
fn after<S: Scan>(scan: &S, beam: usize) -> usize {
    if beam + 1 < scan.beams() { beam + 1 } else { 0 }
}

/// Index of the beam next to another one; `None` at the end of the view, or if beams between them were not received.
fn neighbour<S: Scan>(scan: &S, beam: usize, side: Side) -> Option<usize> {
    let (next, last) = match side {
        Side::Before => (beam.checked_sub(1), scan.beams().saturating_sub(1)),
        Side::After => (Some(beam + 1).filter(|next| *next < scan.beams()), 0),
    };
    let next = match next {
        Some(next) => next,
        None if scan.is_closed() => last,
        None => return None,
    };
    let between_rad = match side {
        Side::Before => scan.between_rad(next, beam),
        Side::After => scan.between_rad(beam, next),
    };
    (between_rad <= MISSING_STEPS * scan.step_rad().abs()).then_some(next)
}

impl<const POSTS: usize> Found<POSTS> {
    fn add(&mut self, verdict: Verdict) {
        match verdict {
            Verdict::Post(post) => self.keep(post),
            Verdict::Small => self.small += 1,
            Verdict::Misshapen => self.misshapen += 1,
            Verdict::Hidden => self.hidden += 1,
            Verdict::Cut => self.cut += 1,
            Verdict::Outside => (),
        }
    }

    fn keep(&mut self, post: Post) {
        let Err(post) = self.posts.push(post) else { return };
        self.beyond += 1;
        let farthest = self.posts.iter_mut().max_by(|one, other| one.range_m.total_cmp(&other.range_m));
        if let Some(farthest) = farthest.filter(|farthest| farthest.range_m > post.range_m) {
            *farthest = post;
        }
    }
}

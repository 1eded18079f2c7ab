//! Posts and reflectors in a scan.

use crate::post::{Post, wrap};
use crate::scan::{Beam, MISSING_STEPS, Scan};
use crate::settings::{PostSettings, SettingsError};
use heapless::Vec;

/// What was found, and why the other clusters of beams are no posts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Found<const POSTS: usize> {
    /// The posts; where there are more than there is room for, the nearest.
    pub posts: Vec<Post, POSTS>,
    /// Posts that there was no room for.
    pub beyond: u32,
    /// Clusters of too few beams.
    pub small: u32,
    /// Clusters that are too wide or too narrow, or a part of something with a hole in it.
    pub misshapen: u32,
    /// Clusters beside which something nearer stands, which may hide a part of them.
    pub hidden: u32,
    /// Clusters at the ends of the view, or beside a part of it that was not received.
    pub cut: u32,
}

/// Finds posts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PostFinder {
    settings: PostSettings,
}

/// How many beams beside a cluster may have come back with nothing before that is taken for the end of what is there.
const HOLES: usize = 3;

/// On which side of a beam, in the order of the scan.
#[derive(Clone, Copy)]
enum Side {
    Before,
    After,
}

/// Beams side by side that are of one thing.
struct Cluster {
    first: usize,
    last: usize,
    len: usize,
    /// Of their ranges.
    sum_m: f32,
    /// Of the brightest.
    intensity: f32,
}

/// What is beside a cluster.
#[derive(PartialEq)]
enum Beside {
    /// Something farther away, or nothing.
    Free,
    /// The same thing goes on, with a hole in it.
    Same,
    /// Something nearer.
    Nearer,
}

/// What a cluster is.
enum Verdict {
    Post(Post),
    Small,
    Misshapen,
    Hidden,
    Cut,
    /// Nearer or farther than posts are looked for.
    Outside,
}

impl PostFinder {
    /// A finder of such posts.
    ///
    /// # Errors
    /// A setting is out of range.
    pub fn new(settings: PostSettings) -> Result<Self, SettingsError> {
        settings.check()?;
        Ok(Self { settings })
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &PostSettings {
        &self.settings
    }

    /// Finds the posts in a scan. Looks at every beam a fixed number of times, and at all that were found once for each that there is no
    /// room for.
    #[must_use]
    pub fn find<const POSTS: usize, S: Scan>(&self, scan: &S) -> Found<POSTS> {
        let mut found = Found::default();
        let beams = scan.beams();
        // A circle without ends is walked from the end of a cluster on, so that none is taken for two.
        let begins = |&number: &usize| {
            let [before, beam] = [neighbour(scan, number, Side::Before), Some(number)]
                .map(|number| number.and_then(|number| scan.beam(number)).filter(|beam| self.is_of_post(*beam)));
            before.zip(beam).is_none_or(|(before, beam)| !self.go_together(before, beam))
        };
        let mut first = if scan.is_closed() { (0..beams).find(begins).unwrap_or(0) } else { 0 };
        let mut walked = 0;
        while walked < beams {
            let Some(mut beam) = scan.beam(first) else { break };
            let mut cluster = Cluster { first, last: first, len: 1, sum_m: beam.range_m, intensity: beam.intensity };
            if self.is_of_post(beam) {
                while walked + cluster.len < beams
                    && let Some(number) = neighbour(scan, cluster.last, Side::After)
                    && let Some(next) = scan.beam(number)
                    && self.go_together(beam, next)
                {
                    beam = next;
                    cluster.last = number;
                    cluster.len += 1;
                    cluster.sum_m += next.range_m;
                    cluster.intensity = cluster.intensity.max(next.intensity);
                }
                found.add(self.judge(scan, &cluster));
            }
            walked += cluster.len;
            first = after(scan, cluster.last);
        }
        found
    }

    /// Whether a reading may be of a post.
    fn is_of_post(&self, beam: Beam) -> bool {
        let least = self.settings.min_intensity;
        beam.range_m > 0.0 && (least <= 0.0 || beam.intensity >= least)
    }

    /// Whether two neighbours are of one thing, of which the first may be of a post.
    fn go_together(&self, last: Beam, next: Beam) -> bool {
        (last.range_m - next.range_m).abs() <= self.settings.gap_m && self.is_of_post(next)
    }

    fn judge<S: Scan>(&self, scan: &S, cluster: &Cluster) -> Verdict {
        let Self { settings } = self;
        let &Cluster { first, last, len, sum_m, intensity } = cluster;
        let mean_m = sum_m / len as f32;
        let (span_rad, step_rad) = (scan.between_rad(first, last), scan.step_rad().abs());
        let range_m = mean_m + settings.depth_m(len, span_rad, mean_m + settings.radius_m, step_rad);
        if !(range_m >= settings.range_min_m && range_m <= settings.range_max_m) {
            return Verdict::Outside;
        }
        let sides = [self.beside(scan, first, Side::Before), self.beside(scan, last, Side::After)];
        let [Some(before), Some(after)] = sides else { return Verdict::Cut };
        let sides = [before, after];
        if sides.contains(&Beside::Nearer) {
            return Verdict::Hidden;
        }
        if sides.contains(&Beside::Same) {
            return Verdict::Misshapen;
        }
        if len < usize::from(settings.min_points) {
            return Verdict::Small;
        }
        // The edges lie up to a step farther out on either side.
        let (narrowest, widest) = (range_m * span_rad, range_m * (span_rad + 2.0 * step_rad));
        let diameter = 2.0 * settings.radius_m;
        if narrowest > diameter + settings.tolerance_m || widest < diameter - settings.tolerance_m {
            return Verdict::Misshapen;
        }
        let first_rad = scan.beam(first).unwrap_or_default().bearing_rad;
        let bearing_rad = wrap(first_rad + 0.5 * span_rad.copysign(scan.step_rad()));
        // Where a post lies across the ends of a circle, half of it was seen first and half last.
        let before_end_s = 0.5 * (scan.before_end_s(first) + scan.before_end_s(last));
        let points = u16::try_from(len).unwrap_or(u16::MAX);
        Verdict::Post(Post { range_m, bearing_rad, before_end_s, points, intensity })
    }

    /// What the first beams beside the edge of a cluster met that did come back; `None` where the view ends before one did.
    fn beside<S: Scan>(&self, scan: &S, edge: usize, side: Side) -> Option<Beside> {
        let edge_m = scan.beam(edge)?.range_m;
        let mut at = edge;
        for _ in 0..=HOLES {
            at = neighbour(scan, at, side)?;
            let range_m = scan.beam(at)?.range_m;
            if range_m > 0.0 {
                let farther = range_m - edge_m;
                // A dark reading as far away as a reflector is of what that is fixed to.
                let is_same = farther <= self.settings.gap_m && self.settings.min_intensity <= 0.0;
                return Some(if farther < -self.settings.gap_m {
                    Beside::Nearer
                } else if is_same {
                    Beside::Same
                } else {
                    Beside::Free
                });
            }
        }
        Some(Beside::Free)
    }
}

/// The next beam, after the last the first.
fn after<S: Scan>(scan: &S, beam: usize) -> usize {
    if beam + 1 < scan.beams() { beam + 1 } else { 0 }
}

/// The beam beside one; `None` where the view ends, or what was between them was not received.
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

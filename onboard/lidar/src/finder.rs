//! Posts and reflectors in a revolution.

use crate::assembler::{Revolution, clockwise};
use crate::packet::Point;
use crate::post::{Post, wrap};
use crate::settings::{PostSettings, SettingsError};
use heapless::Vec;

/// What was found, and why the other clusters of points are no posts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Found<const POSTS: usize> {
    /// The posts; where there are more than there is room for, the nearest.
    pub posts: Vec<Post, POSTS>,
    /// Posts that there was no room for.
    pub beyond: u32,
    /// Clusters with too few points.
    pub small: u32,
    /// Clusters that are too wide or too narrow, or a part of something with a hole in it.
    pub misshapen: u32,
    /// Clusters beside which something nearer stands, which may hide a part of them.
    pub hidden: u32,
    /// Clusters at the seam, or beside a part of the circle that was not received.
    pub cut: u32,
}

/// Finds posts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PostFinder {
    settings: PostSettings,
}

/// How many rays beside a cluster may have come back with nothing before that is taken for the end of what is there.
const HOLES: usize = 3;

/// Points one beside the other that are of one thing, and what is on either side.
struct Cluster<'r> {
    before: &'r [Point],
    points: &'r [Point],
    after: &'r [Point],
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

    /// Finds the posts in a revolution. Looks at every point a fixed number of times, and at all that were found once for each that there
    /// is no room for.
    #[must_use]
    pub fn find<const POSTS: usize, const POINTS: usize>(&self, revolution: &Revolution<POINTS>) -> Found<POSTS> {
        let mut found = Found::default();
        let (mut before, mut rest) = revolution.points.split_at(0);
        while let Some((&first, others)) = rest.split_first() {
            let len = if self.is_of_post(first) {
                let pairs = rest.iter().zip(others);
                1 + pairs.take_while(|&(&last, &next)| self.go_together(revolution, last, next)).count()
            } else {
                1
            };
            let Some((points, after)) = rest.split_at_checked(len) else { break };
            if self.is_of_post(first) {
                found.add(self.judge(&Cluster { before, points, after }, revolution));
            }
            before = revolution.points.get(..before.len() + len).unwrap_or(before);
            rest = after;
        }
        found
    }

    /// Whether a reading may be of a post.
    fn is_of_post(&self, point: Point) -> bool {
        point.reading.range_mm > 0 && point.reading.intensity >= self.settings.min_intensity
    }

    /// Whether two readings, one after the other, are of one thing.
    fn go_together<const POINTS: usize>(&self, revolution: &Revolution<POINTS>, last: Point, next: Point) -> bool {
        let apart = (metres(last) - metres(next)).abs() <= self.settings.gap_m;
        apart && self.is_of_post(next) && revolution.adjoin(last, next)
    }

    fn judge<const POINTS: usize>(&self, cluster: &Cluster<'_>, revolution: &Revolution<POINTS>) -> Verdict {
        let Self { settings } = self;
        let [Some(&first), Some(&last)] = [cluster.points.first(), cluster.points.last()] else {
            return Verdict::Small;
        };
        let count = cluster.points.len() as f32;
        let mean_m = cluster.points.iter().map(|&point| metres(point)).sum::<f32>() / count;
        let radians = |cdeg: f32| cdeg * (core::f32::consts::PI / 18_000.0);
        let span_cdeg = clockwise(first.angle_cdeg, last.angle_cdeg) as f32;
        let (span_rad, step_rad) = (radians(span_cdeg), radians(revolution.step_cdeg));
        let range_m = mean_m + settings.depth_m(cluster.points.len(), span_rad, mean_m + settings.radius_m, step_rad);
        if !(range_m >= settings.range_min_m && range_m <= settings.range_max_m) {
            return Verdict::Outside;
        }
        let (Some(&before), Some(&after)) = (cluster.before.last(), cluster.after.first()) else { return Verdict::Cut };
        if !(revolution.adjoin(before, first) && revolution.adjoin(last, after)) {
            return Verdict::Cut;
        }
        let sides = [
            self.beside(first, cluster.before.iter().rev(), revolution),
            self.beside(last, cluster.after.iter(), revolution),
        ];
        if sides.contains(&Beside::Nearer) {
            return Verdict::Hidden;
        }
        if sides.contains(&Beside::Same) {
            return Verdict::Misshapen;
        }
        if count < f32::from(settings.min_points) {
            return Verdict::Small;
        }
        // The edges lie up to a step farther out on either side.
        let (narrowest, widest) = (range_m * span_rad, range_m * (span_rad + 2.0 * step_rad));
        let diameter = 2.0 * settings.radius_m;
        if narrowest > diameter + settings.tolerance_m || widest < diameter - settings.tolerance_m {
            return Verdict::Misshapen;
        }
        // Clockwise from the arrow; bearings are to the left.
        let bearing_rad = wrap(-radians(f32::from(first.angle_cdeg) + 0.5 * span_cdeg));
        let end = revolution.points.last().map_or(0, |end| clockwise(first.angle_cdeg, end.angle_cdeg));
        let speed_cdegps = 100.0 * f32::from(revolution.speed_degps);
        let before_end_s = if speed_cdegps > 0.0 { (end as f32 - 0.5 * span_cdeg) / speed_cdegps } else { 0.0 };
        let intensity = cluster.points.iter().map(|point| point.reading.intensity).max().unwrap_or(0);
        let points = u16::try_from(cluster.points.len()).unwrap_or(u16::MAX);
        Verdict::Post(Post { range_m, bearing_rad, before_end_s, points, intensity })
    }

    /// What the first rays beside the edge of a cluster met that did come back.
    fn beside<'r, const POINTS: usize>(
        &self,
        edge: Point,
        beside: impl Iterator<Item = &'r Point>,
        revolution: &Revolution<POINTS>,
    ) -> Beside {
        let mut last = edge;
        for &point in beside.take(1 + HOLES) {
            // On either side, whichever way round.
            if !(revolution.adjoin(last, point) || revolution.adjoin(point, last)) {
                return Beside::Free;
            }
            last = point;
            if point.reading.range_mm == 0 {
                continue;
            }
            let farther = metres(point) - metres(edge);
            // A dark reading as far away as a reflector is of what that is fixed to.
            let is_same = farther <= self.settings.gap_m && self.settings.min_intensity == 0;
            return if farther < -self.settings.gap_m {
                Beside::Nearer
            } else if is_same {
                Beside::Same
            } else {
                Beside::Free
            };
        }
        Beside::Free
    }
}

fn metres(point: Point) -> f32 {
    f32::from(point.reading.range_mm) * 1e-3
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

//! Posts with known size and noise in a yard: number of detections and their errors, compared with the model.

mod world;

use scphd_lidar::{Assembler, Found, LaserScan, Post, PostFinder, PostSettings, Receiver, Resolution, Sweep};
use std::io::Write;
use world::{Draws, Lidar, World, wrap};

/// Capacity for posts of a revolution.
const POSTS: usize = 32;
/// Sums over the posts within a range band, m: visible, detected, and errors of the detected ones.
#[derive(Debug, Default, Clone, Copy)]
struct Band {
    in_sight: f64,
    expected: f64,
    found: f64,
    range: f64,
    range_square: f64,
    range_variance: f64,
    bearing_square: f64,
    bearing_variance: f64,
}

#[derive(Debug, Default)]
struct Score {
    bands: [Band; 6],
    revolutions: f64,
    none: f64,
}

/// Width of a band, m.
const BAND_M: f64 = 2.0;
/// The resolution of a lidar, and the posts that count.
#[derive(Debug, Clone, Copy)]
struct Seer {
    resolution: Resolution,
    /// Greatest bearing of posts that count, rad.
    half_view_rad: f64,
}

/// Posts near the seam do not count.
const LD06: Seer = Seer { resolution: Resolution::LD06, half_view_rad: std::f64::consts::PI - 0.15 };

impl Score {
    fn add(&mut self, world: &World, pose: [f64; 3], lidar: &Seer, settings: &PostSettings, found: &[Post]) {
        let mut left: Vec<&Post> = found.iter().collect();
        self.revolutions += 1.0;
        for (number, [x, y]) in world.posts.iter().enumerate() {
            let [dx, dy] = [x - pose[0], y - pose[1]];
            let (range, bearing) = (dx.hypot(dy), wrap(dy.atan2(dx) - pose[2]));
            let near = |post: &&Post| {
                (f64::from(post.range_m) - range).abs() < 0.3
                    && range * wrap(f64::from(post.bearing_rad) - bearing).abs() < 0.3
            };
            let post = left.iter().position(near).map(|at| left.swap_remove(at));
            let scored = bearing.abs() < lidar.half_view_rad && world.is_in_sight([pose[0], pose[1]], number);
            let Some(band) = self.bands.get_mut((range / BAND_M) as usize).filter(|_| scored) else { continue };
            band.in_sight += 1.0;
            band.expected += f64::from(lidar.resolution.detection_probability(settings, range as f32));
            let Some(post) = post else { continue };
            band.found += 1.0;
            band.range += f64::from(post.range_m) - range;
            band.range_square += (f64::from(post.range_m) - range).powi(2);
            band.range_variance += f64::from(lidar.resolution.post_range_sigma_m(settings, range as f32)).powi(2);
            band.bearing_square += wrap(f64::from(post.bearing_rad) - bearing).powi(2);
            band.bearing_variance += f64::from(lidar.resolution.bearing_sigma_rad(settings, range as f32)).powi(2);
        }
        self.none += left.len() as f64;
    }

    fn print(&self, name: &str) {
        let mut text = format!("{name}: {:.4} detections of nothing a revolution\n", self.none / self.revolutions);
        for (k, band) in self.bands.iter().enumerate().filter(|(_, band)| band.found > 0.0) {
            let mrad = |square: f64| 1000.0 * (square / band.found).sqrt();
            text += &format!(
                "{:>4} to {} m: {} in sight, found {:.3} (expected {:.3}), \
                 range {:+.1} ± {:.1} mm (said {:.1}), bearing {:.2} mrad (said {:.2})\n",
                k as f64 * BAND_M,
                (k + 1) as f64 * BAND_M,
                band.in_sight,
                band.found / band.in_sight,
                band.expected / band.in_sight,
                1000.0 * band.range / band.found,
                mrad(band.range_square),
                mrad(band.range_variance),
                mrad(band.bearing_square),
                mrad(band.bearing_variance),
            );
        }
        std::io::stdout().write_all(text.as_bytes()).unwrap();
    }
}

/// A yard, and a pose in it.
fn yard(seed: u64, settings: &PostSettings) -> (World, [f64; 3], Draws) {
    let mut draws = Draws::seeded(seed);
    let pose = [8.0 * draws.uniform() - 4.0, 6.0 * draws.uniform() - 3.0, std::f64::consts::TAU * draws.uniform()];
    let off = |place: [f64; 2]| (place[0] - pose[0]).hypot(place[1] - pose[1]) > 0.7;
    (World::random(&mut draws, 15, f64::from(settings.radius_m), off), pose, draws)
}

/// Scans yards from lidars at rest.
fn look(
    seeds: std::ops::Range<u64>,
    settings: PostSettings,
    change: impl Fn(&mut World),
    tell: impl Fn(&Found<POSTS>),
) -> Score {
    let finder = PostFinder::new(settings).unwrap();
    let mut score = Score::default();
    for seed in seeds {
        let (mut world, pose, draws) = yard(seed, &settings);
        change(&mut world);
        let (mut lidar, mut receiver) = (Lidar::started(draws), Receiver::new());
        let mut assembler = Assembler::<1024>::new();
        while lidar.time_s < 2.0 {
            let bytes = lidar.packet(&world, |_| pose).to_bytes();
            for packet in bytes.into_iter().filter_map(|byte| receiver.push(byte)) {
                if let Some(revolution) = assembler.push(&packet) {
                    let found = finder.find(revolution);
                    tell(&found);
                    score.add(&world, pose, &LD06, &settings, &found.posts);
                }
            }
        }
    }
    score
}

/// Checks that the share of detected posts and their errors agree with [`Resolution`].
fn is_as_said(score: &Score) {
    for band in score.bands.iter().filter(|band| band.found > 100.0) {
        let (found, expected) = (band.found / band.in_sight, band.expected / band.in_sight);
        assert!((found - expected).abs() < 0.04, "found {found}, expected {expected}: {band:?}");
        assert!(band.range.abs() / band.found < 0.004, "{band:?}");
        // Neither overconfident nor much too conservative.
        let range = (band.range_square / band.range_variance).sqrt();
        let bearing = (band.bearing_square / band.bearing_variance).sqrt();
        assert!((0.7..1.15).contains(&range) && (0.8..1.2).contains(&bearing), "{range} {bearing}: {band:?}");
    }
}

#[test]
fn detections_agree_with_the_model() {
    for radius_m in [0.05, 0.1] {
        let settings = PostSettings::of_radius(radius_m);
        let score = look(0..60, settings, |_| (), |_| ());
        score.print(&format!("posts of {radius_m} m"));
        is_as_said(&score);
        assert!(score.none == 0.0);
    }
}

/// Other lidars: number of beams, direction of the first one (degrees), angle between them, and the value of a missing return.
const OTHERS: [(&str, usize, f32, f32, f32); 4] = [
    ("0.25° over 270° from the right", 1081, -135.0, 0.25, f32::INFINITY),
    ("0.5° over 180° from the left", 361, 90.0, -0.5, 0.0),
    ("1° round from ahead to the left", 360, 0.0, 1.0, f32::NAN),
    ("0.33° clockwise from behind, both ends", 1093, 180.0, -360.0 / 1092.0, 12.0),
];

#[test]
fn posts_are_found_at_any_resolution_and_direction() {
    let settings = PostSettings::of_radius(0.1);
    let finder = PostFinder::new(settings).unwrap();
    for (name, beams, start, step, empty_m) in OTHERS {
        let [start_rad, increment_rad] = [start, step].map(f32::to_radians);
        let sweep = Sweep { start_rad, increment_rad, range_min_m: 0.05, range_max_m: 12.0, duration_s: 0.1 };
        let is_round = step.abs() * beams as f32 >= 360.0;
        let lidar = Seer {
            resolution: Resolution { step_rad: increment_rad.abs(), ..Resolution::LD06 },
            half_view_rad: if is_round { 4.0 } else { f64::from(start.to_radians().abs()) - 0.15 },
        };
        let mut score = Score::default();
        for seed in 0..60 {
            let (world, pose, mut draws) = yard(seed, &settings);
            for _ in 0..20 {
                let ranges = world::scan(&world, &mut draws, &sweep, beams, empty_m, |_| pose);
                let found = finder.find::<POSTS, _>(&LaserScan::new(sweep, &ranges, &[]).unwrap());
                assert!(is_round || found.cut > 0, "the walls go on at the ends of the view");
                score.add(&world, pose, &lidar, &settings, &found.posts);
            }
        }
        score.print(name);
        is_as_said(&score);
        assert!(score.none == 0.0);
    }
}

#[test]
fn reflectors_are_found_among_other_posts() {
    let settings = PostSettings { min_intensity: 200.0, ..PostSettings::of_radius(0.05) };
    let reflect = |world: &mut World| world.intensity = 230;
    let score = look(100..140, settings, reflect, |_| ());
    score.print("reflectors");
    is_as_said(&score);
    assert!(score.none == 0.0);
    // The same posts without reflectors.
    let score = look(100..110, settings, |_| (), |found| assert!(found.posts.is_empty()));
    assert!(score.revolutions > 100.0);
}

#[test]
fn posts_without_room_are_counted() {
    let settings = PostSettings::of_radius(0.1);
    let finder = PostFinder::new(settings).unwrap();
    let mut draws = Draws::seeded(7);
    let world = World::random(&mut draws, 30, 0.1, |[x, y]| x.hypot(y) > 1.0);
    let (mut lidar, mut assembler) = (Lidar::started(draws), Assembler::<1024>::new());
    let mut revolutions = 0;
    while lidar.time_s < 2.0 {
        if let Some(revolution) = assembler.push(&lidar.packet(&world, |_| [0.0; 3])) {
            let (all, few) = (finder.find::<64, _>(revolution), finder.find::<5, _>(revolution));
            assert!(all.beyond == 0 && all.posts.len() > 8, "{all:?}");
            assert_eq!((few.posts.len(), few.beyond as usize), (5, all.posts.len() - 5));
            let mut nearest: Vec<f32> = all.posts.iter().map(|post| post.range_m).collect();
            nearest.sort_by(f32::total_cmp);
            let farthest = few.posts.iter().map(|post| post.range_m).fold(0.0, f32::max);
            assert_eq!(farthest, nearest[4]);
            revolutions += 1;
        }
    }
    assert!(revolutions > 15);
}

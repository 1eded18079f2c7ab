//! Charts drawn as SVG elements: frame, grid, marks, legend.

use super::axis::{Interval, equalised};
use super::chart::{Chart, Colour, Gaussian, Mark, Shape};
use super::font::{outlines, text_width};
use super::polyline::{Rect, append, polyline, thinned_runs};
use svg::Node;
use svg::node::element::{Circle, ClipPath, Ellipse, Group, Line, Path, Rectangle};

/// Size of the numbers at the ticks, px.
pub const TICK_SIZE_PX: f64 = 15.0;
/// Size of the names of axes and in the legend, px.
pub const LABEL_SIZE_PX: f64 = 17.0;
const LEGEND_ROW_PX: f64 = 26.0;
/// Length of the sample of a mark in the legend, px.
const SAMPLE_PX: f64 = 34.0;
/// Distance between a sample and its name, px.
const SAMPLE_GAP_PX: f64 = 8.0;
/// Distance between the entries of a legend, px.
const ENTRY_GAP_PX: f64 = 26.0;
/// Good distance of ticks along x and along y, px.
const TICK_SPACING_PX: [f64; 2] = [110.0, 48.0];
/// The same for equal scales, so that the grid is square.
const SQUARE_SPACING_PX: f64 = 80.0;
/// Size of an ellipse in standard deviations: √(−2 ln 0.05), for a probability of 95 %.
const SIGMAS: f64 = 2.447_746_830_680_816;
/// Greatest length of an ellipse's axis, px; renderers would lose precision.
const LARGEST_AXIS_PX: f64 = 20_000.0;
/// Half the size of a cross, px.
const CROSS_PX: f64 = 5.5;
/// Diameter of a small dot, px.
const DOT_PX: f64 = 2.6;
/// Colour of the frame, the ticks and the text.
const INK: Colour = Colour(45, 45, 45);
const GRID: Colour = Colour(228, 228, 228);

/// Position of a text relative to its point.
#[derive(Debug, Clone, Copy)]
pub enum Anchor {
    /// To the right of it.
    Start,
    /// On both sides of it.
    Middle,
    /// To the left of it.
    End,
}

/// A line of text with its baseline at (x, y), px. Its content is also a label, for screen readers and searching.
pub fn text(content: &str, [x, y]: [f64; 2], size_px: f64, anchor: Anchor) -> Path {
    let before = match anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => 0.5,
        Anchor::End => 1.0,
    };
    let start = x - before * text_width(content, size_px);
    Path::new().set("d", outlines(content, [start, y], size_px)).set("fill", INK.to_string()).set("aria-label", content)
}

/// A pixel coordinate as text.
fn px(value: f64) -> String {
    format!("{value:.2}")
}

/// A chart in a rectangle, with final limits.
#[derive(Debug)]
pub struct Panel<'a> {
    chart: &'a Chart,
    x: Interval,
    y: Interval,
    frame: Rect,
}

impl<'a> Panel<'a> {
    /// The chart with its axes around `frame` (px).
    pub fn new(chart: &'a Chart, frame: Rect) -> Self {
        let (mut x, mut y) = chart.limits();
        if chart.equal_scale {
            (x, y) = equalised(x, y, frame.width(), frame.height());
        }
        Self { chart, x, y, frame }
    }

    pub fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            self.frame.left + (x - self.x.low()) * self.pixels_per_unit()[0],
            self.frame.bottom - (y - self.y.low()) * self.pixels_per_unit()[1],
        ]
    }

    pub fn pixels_per_unit(&self) -> [f64; 2] {
        [self.frame.width() / self.x.span(), self.frame.height() / self.y.span()]
    }

    /// Width of the widest tick label of the y axis, px.
    pub fn y_numbers_width(&self) -> f64 {
        self.y_ticks().iter().map(|(_, label)| text_width(label, TICK_SIZE_PX)).fold(0.0, f64::max)
    }

    fn y_ticks(&self) -> Vec<(f64, String)> {
        self.ticks(self.y, self.frame.height(), TICK_SPACING_PX[1])
    }

    fn ticks(&self, axis: Interval, length_px: f64, spacing_px: f64) -> Vec<(f64, String)> {
        let spacing_px = if self.chart.equal_scale { SQUARE_SPACING_PX } else { spacing_px };
        axis.ticks(length_px / spacing_px)
    }

    /// Everything inside and at the frame; `id` distinguishes its clip path from those of other panels.
    pub fn draw(&self, id: &str) -> Group {
        let frame = self.frame;
        let rectangle = || {
            Rectangle::new()
                .set("x", px(frame.left))
                .set("y", px(frame.top))
                .set("width", px(frame.width()))
                .set("height", px(frame.height()))
        };
        let mut marks = Group::new().set("clip-path", format!("url(#{id})"));
        for mark in &self.chart.marks {
            marks.append(self.mark(mark));
        }
        let mut group = Group::new()
            .add(ClipPath::new().set("id", id).add(rectangle()))
            .add(self.axes())
            .add(marks)
            .add(rectangle().set("fill", "none").set("stroke", INK.to_string()).set("stroke-width", 1.2));
        if !self.chart.has_data() {
            let centre = [0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom)];
            group.append(text("no data", centre, LABEL_SIZE_PX, Anchor::Middle).set("fill", Colour::GREY.to_string()));
        }
        group
    }

    /// Grid, ticks, numbers and names of the axes.
    fn axes(&self) -> Group {
        let frame = self.frame;
        let mut group = Group::new();
        let stroke = |from: [f64; 2], to: [f64; 2], colour: Colour| {
            Line::new()
                .set("x1", px(from[0]))
                .set("y1", px(from[1]))
                .set("x2", px(to[0]))
                .set("y2", px(to[1]))
                .set("stroke", colour.to_string())
                .set("stroke-width", 1)
        };
        for (value, label) in self.ticks(self.x, frame.width(), TICK_SPACING_PX[0]) {
            let x = self.pixel([value, 0.0])[0];
            group.append(stroke([x, frame.top], [x, frame.bottom], GRID));
            group.append(stroke([x, frame.bottom], [x, frame.bottom + 6.0], INK));
            let below = [x, frame.bottom + 8.0 + TICK_SIZE_PX];
            group.append(text(&label, below, TICK_SIZE_PX, Anchor::Middle));
        }
        for (value, label) in self.y_ticks() {
            let y = self.pixel([0.0, value])[1];
            group.append(stroke([frame.left, y], [frame.right, y], GRID));
            group.append(stroke([frame.left - 6.0, y], [frame.left, y], INK));
            // A third of the font size is about half the height of a digit.
            let beside = [frame.left - 10.0, y + 0.36 * TICK_SIZE_PX];
            group.append(text(&label, beside, TICK_SIZE_PX, Anchor::End));
        }
        if !self.chart.x_label.is_empty() {
            let below = [0.5 * (frame.left + frame.right), frame.bottom + 18.0 + TICK_SIZE_PX + LABEL_SIZE_PX];
            group.append(text(&self.chart.x_label, below, LABEL_SIZE_PX, Anchor::Middle));
        }
        if !self.chart.y_label.is_empty() {
            // All panels of a figure have the same left edge, and therefore this column too.
            let (x, y) = (LABEL_SIZE_PX + 8.0, 0.5 * (frame.top + frame.bottom));
            group.append(
                text(&self.chart.y_label, [x, y], LABEL_SIZE_PX, Anchor::Middle)
                    .set("transform", format!("rotate(-90 {x:.2} {y:.2})")),
            );
        }
        group
    }

    fn mark(&self, mark: &Mark) -> Group {
        match &mark.shape {
            Shape::Line { points, width_px, dashed } => self.line(mark.colour, points, *width_px, *dashed),
            Shape::Band(rows) => self.band(mark.colour, rows),
            Shape::Crosses(points) => self.symbols(points, |at| cross(mark.colour, at)),
            Shape::Dots(points) => self.dots(mark.colour, points),
            Shape::Rings(points) => self.symbols(points, |at| ring(mark.colour, at)),
            Shape::Gaussians(features) => {
                let mut group = Group::new();
                for feature in features {
                    if let Some(drawn) = self.gaussian(mark.colour, feature) {
                        group.append(drawn);
                    }
                }
                group
            }
        }
    }

    fn line(&self, colour: Colour, points: &[[f64; 2]], width_px: f64, dashed: bool) -> Group {
        // A margin hides the ends of lines at the cut.
        let frame = self.frame.grown(10.0);
        let line = polyline(points.iter().map(|&point| self.pixel(point)), frame);
        let mut group = Group::new();
        if !line.path.is_empty() {
            group.append(stroked(line.path, colour, width_px, dashed));
        }
        for [x, y] in line.lone {
            group.append(dot([x, y], 0.5 * width_px.max(4.0), colour));
        }
        group
    }

    fn band(&self, colour: Colour, rows: &[[f64; 3]]) -> Group {
        let limits = self.frame.grown(10.0);
        let pixels = rows.iter().map(|&[x, low, high]| {
            let [x_px, low_px] = self.pixel([x, low]);
            let high_px = self.pixel([x, high])[1];
            // `clamp` keeps NaN, which interrupts the band.
            let inside = |y: f64| y.clamp(limits.top, limits.bottom);
            [x_px, inside(low_px), inside(high_px)]
        });
        let mut path = String::new();
        for run in thinned_runs(pixels) {
            // A single row is drawn as a bar of two pixels.
            let half = if run.len() == 1 { 1.0 } else { 0.0 };
            let mut command = 'M';
            for &[x, _, high] in &run {
                append(&mut path, command, [x - half, high]);
                command = 'L';
            }
            for &[x, low, _] in run.iter().rev() {
                append(&mut path, 'L', [x + half, low]);
            }
            path.push('Z');
        }
        if path.is_empty() {
            return Group::new();
        }
        Group::new().add(filled(path, colour))
    }

    fn symbols(&self, points: &[[f64; 2]], symbol: impl Fn([f64; 2]) -> Group) -> Group {
        let room = self.frame.grown(CROSS_PX);
        let mut group = Group::new();
        for pixel in points.iter().map(|&point| self.pixel(point)) {
            if room.contains(pixel) {
                group.append(symbol(pixel));
            }
        }
        group
    }

    /// One path for all dots: thousands of circles would make a large file.
    fn dots(&self, colour: Colour, points: &[[f64; 2]]) -> Group {
        let mut path = String::new();
        for pixel in points.iter().map(|&point| self.pixel(point)).filter(|&pixel| self.frame.contains(pixel)) {
            append(&mut path, 'M', pixel);
            path.push_str("h0");
        }
        if path.is_empty() { Group::new() } else { Group::new().add(dotted(path, colour)) }
    }

    /// A mean and its ellipse; `None` if a number is not finite or the ellipse is out of view.
    fn gaussian(&self, colour: Colour, feature: &Gaussian) -> Option<Group> {
        let centre = self.pixel(feature.mean);
        let [sx, sy] = self.pixels_per_unit();
        let [[xx, xy], [yx, yy]] = feature.covariance;
        // The covariance in pixels, with y downwards. Its eigenvectors are the axes on the screen, also for different scales.
        let (xx, yy, xy) = (xx * sx * sx, yy * sy * sy, -0.5 * (xy + yx) * sx * sy);
        let mean = 0.5 * (xx + yy);
        let spread = (0.5 * (xx - yy)).hypot(xy);
        let turn_deg = (0.5 * (2.0 * xy).atan2(xx - yy)).to_degrees();
        let axis = |variance: f64| (SIGMAS * variance.max(0.0).sqrt()).min(LARGEST_AXIS_PX);
        let (long, short) = (axis(mean + spread), axis(mean - spread));
        let finite = [centre[0], centre[1], mean, spread, feature.weight];
        if !finite.iter().all(|v| v.is_finite()) || !self.frame.grown(long).contains(centre) {
            return None;
        }
        let opacity = 0.25 + 0.75 * feature.weight.clamp(0.0, 1.0);
        Some(gaussian_symbol(colour, centre, [long, short], turn_deg).set("opacity", format!("{opacity:.2}")))
    }
}

/// Height of the legend of a chart with width `width`, px; 0 without named marks.
pub fn legend_height(chart: &Chart, width: f64) -> f64 {
    let rows = legend_rows(chart, width).len();
    if rows == 0 {
        return 0.0;
    }
    rows as f64 * LEGEND_ROW_PX + 6.0
}

/// The legend in rows, aligned right, above the frame.
pub fn legend(chart: &Chart, [left, top]: [f64; 2], width: f64) -> Group {
    let mut group = Group::new();
    for (index, row) in legend_rows(chart, width).iter().enumerate() {
        let y = top + (index as f64 + 0.5) * LEGEND_ROW_PX;
        let row_width: f64 = row.iter().map(|(_, width)| width + ENTRY_GAP_PX).sum();
        let mut x = left + (width - row_width + ENTRY_GAP_PX).max(0.0);
        for (mark, entry_width) in row {
            group.append(sample(mark, [x, y]));
            let beside = [x + SAMPLE_PX + SAMPLE_GAP_PX, y + 0.36 * LABEL_SIZE_PX];
            group.append(text(&mark.label, beside, LABEL_SIZE_PX, Anchor::Start));
            x += entry_width + ENTRY_GAP_PX;
        }
    }
    group
}

/// The named marks with the widths of their entries, divided into rows.
fn legend_rows(chart: &Chart, width: f64) -> Vec<Vec<(&Mark, f64)>> {
    let mut rows: Vec<Vec<(&Mark, f64)>> = Vec::new();
    let mut used = f64::INFINITY;
    for mark in chart.marks.iter().filter(|mark| !mark.label.is_empty()) {
        let entry = SAMPLE_PX + SAMPLE_GAP_PX + text_width(&mark.label, LABEL_SIZE_PX);
        match rows.last_mut() {
            Some(row) if used + ENTRY_GAP_PX + entry <= width => {
                row.push((mark, entry));
                used += ENTRY_GAP_PX + entry;
            }
            _ => {
                rows.push(vec![(mark, entry)]);
                used = entry;
            }
        }
    }
    rows
}

/// The sample of a mark, at the left end of a legend entry.
fn sample(mark: &Mark, [x, y]: [f64; 2]) -> Group {
    let centre = [x + 0.5 * SAMPLE_PX, y];
    match &mark.shape {
        Shape::Line { width_px, dashed, .. } => {
            let path = format!("M{x:.2} {y:.2}h{SAMPLE_PX}");
            Group::new().add(stroked(path, mark.colour, width_px.max(1.8), *dashed))
        }
        Shape::Band(_) => {
            let path = format!("M{x:.2} {:.2}h{SAMPLE_PX}v14h-{SAMPLE_PX}Z", y - 7.0);
            Group::new().add(filled(path, mark.colour))
        }
        Shape::Crosses(_) => cross(mark.colour, centre),
        Shape::Dots(_) => {
            let at = |dx: f64, dy: f64| format!("M{:.2} {:.2}h0", centre[0] + dx, y + dy);
            let path = [at(-9.0, 2.0), at(-3.0, -3.0), at(4.0, 3.0), at(10.0, -1.0)].concat();
            Group::new().add(dotted(path, mark.colour).set("stroke-opacity", 1))
        }
        Shape::Rings(_) => ring(mark.colour, centre),
        Shape::Gaussians(_) => gaussian_symbol(mark.colour, centre, [14.0, 7.0], -20.0),
    }
}

fn stroked(path: String, colour: Colour, width_px: f64, dashed: bool) -> Path {
    let drawn = Path::new()
        .set("d", path)
        .set("fill", "none")
        .set("stroke", colour.to_string())
        .set("stroke-width", width_px)
        .set("stroke-linejoin", "round");
    if dashed { drawn.set("stroke-dasharray", "8 5") } else { drawn.set("stroke-linecap", "round") }
}

/// Strokes of zero length with round ends: dots.
fn dotted(path: String, colour: Colour) -> Path {
    stroked(path, colour, DOT_PX, false).set("stroke-opacity", 0.5)
}

fn filled(path: String, colour: Colour) -> Path {
    Path::new().set("d", path).set("fill", colour.to_string()).set("fill-opacity", 0.16)
}

fn dot([x, y]: [f64; 2], radius: f64, colour: Colour) -> Circle {
    Circle::new().set("cx", px(x)).set("cy", px(y)).set("r", px(radius)).set("fill", colour.to_string())
}

fn cross(colour: Colour, [x, y]: [f64; 2]) -> Group {
    let length = 2.0 * CROSS_PX;
    let path = format!("M{:.2} {y:.2}h{length}M{x:.2} {:.2}v{length}", x - CROSS_PX, y - CROSS_PX);
    Group::new().add(stroked(path, colour, 1.5, false))
}

fn ring(colour: Colour, at: [f64; 2]) -> Group {
    Group::new().add(dot(at, 5.5, colour).set("fill", "white").set("stroke", colour.to_string()).set("stroke-width", 2))
}

/// An ellipse with the semi-axes `axes` (px), the first rotated clockwise by `turn_deg`, and its centre.
fn gaussian_symbol(colour: Colour, [x, y]: [f64; 2], axes: [f64; 2], turn_deg: f64) -> Group {
    Group::new()
        .add(
            Ellipse::new()
                .set("rx", px(axes[0]))
                .set("ry", px(axes[1]))
                .set("transform", format!("translate({x:.2} {y:.2}) rotate({turn_deg:.2})"))
                .set("fill", colour.to_string())
                .set("fill-opacity", 0.16)
                .set("stroke", colour.to_string())
                .set("stroke-width", 1.3),
        )
        .add(dot([x, y], 2.2, colour))
}

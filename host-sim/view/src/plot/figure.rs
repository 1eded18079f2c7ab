//! A figure with one or several charts in a column, and its files.

use super::chart::Chart;
use super::draw::{Anchor, LABEL_SIZE_PX, Panel, TICK_SIZE_PX, legend, legend_height, text};
use super::error::PlotError;
use super::font::text_width;
use super::polyline::Rect;
use super::raster::png;
use scphd_score::results::sink;
use std::path::{Path, PathBuf};
use svg::Document;
use svg::node::element::Rectangle;

pub const WIDTH_PX: f64 = 1200.0;
const TITLE_SIZE_PX: f64 = 22.0;
/// Space above the first chart, with the title, px.
const HEAD_PX: f64 = 52.0;
/// Space right of the frames, for half a tick label, px.
const RIGHT_PX: f64 = 36.0;
/// Space below the last chart, px.
const FOOT_PX: f64 = 16.0;

#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    pub title: String,
    /// The charts from top to bottom with the heights of their frames, px.
    pub charts: Vec<(Chart, f64)>,
}

impl Figure {
    pub fn svg(&self) -> String {
        let left = self.left();
        let right = WIDTH_PX - RIGHT_PX;
        let mut elements = Vec::new();
        let mut y = HEAD_PX;
        for (index, (chart, height)) in self.charts.iter().enumerate() {
            elements.push(legend(chart, [left, y], right - left));
            y += legend_height(chart, right - left);
            let frame = Rect { left, top: y, right, bottom: y + height };
            elements.push(Panel::new(chart, frame).draw(&format!("frame{index}")));
            y = frame.bottom + below(chart);
        }
        let height = (y + FOOT_PX).ceil();
        let mut document = Document::new()
            .set("width", WIDTH_PX)
            .set("height", height)
            .set("viewBox", (0.0, 0.0, WIDTH_PX, height))
            .add(Rectangle::new().set("width", WIDTH_PX).set("height", height).set("fill", "white"));
        if !self.title.is_empty() {
            // A title that is too long is drawn smaller.
            let room = WIDTH_PX - 2.0 * RIGHT_PX;
            let size = TITLE_SIZE_PX * (room / text_width(&self.title, TITLE_SIZE_PX)).min(1.0);
            let at = [0.5 * WIDTH_PX, 0.5 * HEAD_PX + 0.36 * TITLE_SIZE_PX];
            document = document.add(text(&self.title, at, size, Anchor::Middle));
        }
        for element in elements {
            document = document.add(element);
        }
        document.to_string()
    }

    /// The common left edge of all frames, px: space for the name of the axis and its widest tick label.
    fn left(&self) -> f64 {
        let numbers = self
            .charts
            .iter()
            .map(|(chart, height)| {
                // The final width is not known yet; it has an effect only for equal scales, and little on their labels.
                let frame = Rect { left: 0.0, top: 0.0, right: Self::usual_frame_width(), bottom: *height };
                Panel::new(chart, frame).y_numbers_width()
            })
            .fold(0.0, f64::max);
        LABEL_SIZE_PX + 30.0 + numbers
    }

    /// Usual width of the frames, px, for choosing a height with equal scales.
    pub fn usual_frame_width() -> f64 {
        WIDTH_PX - RIGHT_PX - 95.0
    }

    /// Writes `<stem>.svg` and `<stem>.png` into the existing folder `dir`; each file is complete or not written.
    ///
    /// # Errors
    ///
    /// [`PlotError`] if a file cannot be written or the figure cannot be rendered; then no file is replaced by a part of one.
    pub fn write(&self, dir: &Path, stem: &str) -> Result<[PathBuf; 2], PlotError> {
        let svg = self.svg();
        let png = png(&svg)?;
        let paths = ["svg", "png"].map(|extension| dir.join(format!("{stem}.{extension}")));
        for (path, bytes) in paths.iter().zip([svg.as_bytes(), &png]) {
            sink::write(path, bytes).map_err(|source| PlotError::Io { path: path.clone(), source })?;
        }
        Ok(paths)
    }
}

/// Space for tick labels and the name of the x axis, and to the next chart, px.
fn below(chart: &Chart) -> f64 {
    let name = if chart.x_label.is_empty() { 0.0 } else { LABEL_SIZE_PX + 10.0 };
    TICK_SIZE_PX + 18.0 + name
}

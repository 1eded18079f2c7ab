//! Text as outlines of one included font: a figure is the same in every viewer, and drawing it needs no installed font.

use std::fmt::Write as _;
use std::sync::OnceLock;
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// DejaVu Sans.
fn face() -> Option<&'static Face<'static>> {
    static FACE: OnceLock<Option<Face<'static>>> = OnceLock::new();
    FACE.get_or_init(|| Face::parse(dejavu::sans::regular(), 0).ok()).as_ref()
}

/// The glyphs of a line of text, each with the distance of its origin from the start of the line, and the width of the line, in
/// units of the font. A missing character has the glyph of an empty box.
fn glyphs<'t>(face: &'t Face<'_>, text: &'t str) -> (Vec<(GlyphId, f64)>, f64) {
    let mut width = 0.0;
    let glyphs = text.chars().map(|character| {
        let glyph = face.glyph_index(character).unwrap_or_default();
        let origin = width;
        width += f64::from(face.glyph_hor_advance(glyph).unwrap_or(0));
        (glyph, origin)
    });
    (glyphs.collect(), width)
}

pub fn text_width(text: &str, size_px: f64) -> f64 {
    face().map_or(0.0, |face| glyphs(face, text).1 * scale(face, size_px))
}

/// The outlines of a line of text whose baseline starts at (x, y), px, as data of an SVG path.
pub fn outlines(text: &str, [x, y]: [f64; 2], size_px: f64) -> String {
    let Some(face) = face() else { return String::new() };
    let scale = scale(face, size_px);
    let mut path = PathData { origin: [x, y], scale, data: String::new() };
    for (glyph, origin) in glyphs(face, text).0 {
        path.origin = [x + origin * scale, y];
        // A space has no outline.
        let _bounds = face.outline_glyph(glyph, &mut path);
    }
    path.data
}

/// Pixels of a unit of the font.
fn scale(face: &Face<'_>, size_px: f64) -> f64 {
    size_px / f64::from(face.units_per_em())
}

/// Data of a path under construction. y points up in a font, down in a figure.
struct PathData {
    origin: [f64; 2],
    scale: f64,
    data: String,
}

impl PathData {
    fn append(&mut self, command: char, points: &[[f32; 2]]) {
        self.data.push(command);
        for (index, [x, y]) in points.iter().enumerate() {
            let x = self.origin[0] + f64::from(*x) * self.scale;
            let y = self.origin[1] - f64::from(*y) * self.scale;
            let separator = if index == 0 { "" } else { " " };
            // Writing into a string cannot fail.
            let _written = write!(self.data, "{separator}{x:.2} {y:.2}");
        }
    }
}

impl OutlineBuilder for PathData {
    fn move_to(&mut self, x: f32, y: f32) {
        self.append('M', &[[x, y]]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.append('L', &[[x, y]]);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.append('Q', &[[x1, y1], [x, y]]);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.append('C', &[[x1, y1], [x2, y2], [x, y]]);
    }

    fn close(&mut self) {
        self.data.push('Z');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_those_of_the_font() {
        let digit = text_width("0", 20.0);
        assert!((digit - 20.0 * 1303.0 / 2048.0).abs() < 1e-9, "{digit}");
        assert!((text_width("0000", 20.0) - 4.0 * digit).abs() < 1e-9);
        assert!(text_width("a < b & c", 20.0) > 80.0);
        assert!(text_width("\u{1}", 20.0) > 0.0);
    }

    #[test]
    fn a_letter_is_on_its_baseline() {
        // The minus of DejaVu is a rectangle: its width is that of the font, and it is above the baseline.
        let minus = outlines("−", [100.0, 50.0], 2048.0);
        assert_eq!(minus.matches(['M', 'L']).count(), 5, "{minus}");
        let numbers: Vec<f64> = minus.split(['M', 'L', 'Z', ' ']).filter_map(|number| number.parse().ok()).collect();
        let (xs, ys): (Vec<f64>, Vec<f64>) = numbers.chunks(2).map(|point| (point[0], point[1])).unzip();
        let range = |values: &[f64]| {
            (values.iter().copied().fold(f64::MAX, f64::min), values.iter().copied().fold(f64::MIN, f64::max))
        };
        assert_eq!(range(&xs), (317.0, 1599.0), "{minus}");
        assert!(range(&ys).1 < 50.0, "{minus}");
        assert_eq!(outlines(" ", [0.0, 0.0], 20.0), "");
    }
}

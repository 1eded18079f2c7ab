//! SVG to PNG with one shipped font, so that a picture is the same on every machine.

use super::error::PlotError;
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};
use std::sync::{Arc, OnceLock};
use svg::node::element::Text;

/// The family every text is set in; viewers of the SVG without it fall back on their own sans-serif.
pub const FONT_FAMILY: &str = "DejaVu Sans";

/// Nothing but DejaVu Sans: fonts of the system would change the picture from machine to machine.
fn options() -> Options<'static> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    let fonts = FONTS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_source(fontdb::Source::Binary(Arc::new(dejavu::sans::regular())));
        fonts.set_sans_serif_family(FONT_FAMILY);
        Arc::new(fonts)
    });
    Options { font_family: FONT_FAMILY.into(), fontdb: Arc::clone(fonts), ..Options::default() }
}

/// The SVG as a PNG of its own size, opaque on white.
///
/// # Errors
///
/// [`PlotError::Render`] where the text is not an SVG document or its size is out of reason.
pub fn png(svg: &str) -> Result<Vec<u8>, PlotError> {
    let render = |error: &dyn std::fmt::Display| PlotError::Render(error.to_string());
    let tree = Tree::from_str(svg, &options()).map_err(|error| render(&error))?;
    let size = tree.size().to_int_size();
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or_else(|| render(&"a picture this large"))?;
    pixels.fill(Color::WHITE);
    resvg::render(&tree, Transform::identity(), &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| render(&error))
}

/// Width of a line of text in the shipped font, px.
pub fn text_width(text: &str, size_px: f64) -> f64 {
    let document = svg::Document::new()
        .set("xmlns", "http://www.w3.org/2000/svg")
        .set("width", 10)
        .set("height", 10)
        .add(Text::new(text).set("font-family", FONT_FAMILY).set("font-size", size_px));
    match Tree::from_str(&document.to_string(), &options()) {
        Ok(tree) => f64::from(tree.root().bounding_box().width()),
        // Only control characters make this document invalid; the guess is the mean width of a letter.
        Err(_) => 0.6 * size_px * text.chars().count() as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_follow_the_font() {
        let digit = text_width("0", 20.0);
        assert!((digit - 20.0 * 1303.0 / 2048.0).abs() < 0.1, "{digit}");
        assert!((text_width("0000", 20.0) - 4.0 * digit).abs() < 0.1);
        assert!(text_width("a < b & c", 20.0) > 80.0);
        assert!(text_width("\u{1}", 20.0) > 0.0);
    }

    #[test]
    fn a_broken_document_is_an_error() {
        assert!(matches!(png("<svg"), Err(PlotError::Render(_))));
    }
}

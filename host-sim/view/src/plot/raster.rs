//! SVG to PNG. All text is converted to outlines, so that a figure is the same on every machine.

use super::error::PlotError;
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// The SVG as a PNG of the same size, opaque on white.
///
/// # Errors
///
/// [`PlotError::Render`] if the text is not an SVG document or its size is not plausible.
pub fn png(svg: &str) -> Result<Vec<u8>, PlotError> {
    let render = |error: &dyn std::fmt::Display| PlotError::Render(error.to_string());
    let tree = Tree::from_str(svg, &Options::default()).map_err(|error| render(&error))?;
    let size = tree.size().to_int_size();
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or_else(|| render(&"a picture this large"))?;
    pixels.fill(Color::WHITE);
    resvg::render(&tree, Transform::identity(), &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| render(&error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_broken_document_is_an_error() {
        assert!(matches!(png("<svg"), Err(PlotError::Render(_))));
    }
}

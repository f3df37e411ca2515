//! Pictures of pixels: from the rasteriser, laid over each other, to PNG.

use super::PlotError;
use super::raster::Raster;
use kuva::backend::raster::RasterBackend;
use kuva::render::render::Scene;

/// An RGB picture.
pub(super) struct Image {
    pub(super) width: usize,
    pub(super) height: usize,
    rgb: Vec<u8>,
}

impl Image {
    pub(super) fn of(scene: &Scene, scale: f64) -> Result<Image, PlotError> {
        let bytes =
            RasterBackend { scale: scale as f32 }.render_scene(scene).map_err(PlotError::Raster)?;
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info()?;
        let size = reader.output_buffer_size();
        let mut data = vec![0; size.ok_or_else(|| PlotError::Raster("picture too large".into()))?];
        let info = reader.next_frame(&mut data)?;
        let samples = info.color_type.samples();
        if info.bit_depth != png::BitDepth::Eight || samples < 3 {
            return Err(PlotError::Raster("unexpected pixel format".into()));
        }
        data.truncate(info.buffer_size());
        let rgb = data.chunks_exact(samples).flat_map(|p| [p[0], p[1], p[2]]).collect();
        Ok(Image { width: info.width as usize, height: info.height as usize, rgb })
    }

    /// Multiplies a dark-on-white picture onto this one, turned a quarter to the left, such that
    /// its pixel `pivot` comes to lie on `at`.
    pub(super) fn multiply_turned(&mut self, label: &Image, at: (i64, i64), pivot: (i64, i64)) {
        for v in 0..label.height {
            for u in 0..label.width {
                let (x, y) = (at.0 + v as i64 - pivot.1, at.1 - (u as i64 - pivot.0));
                let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { continue };
                if x >= self.width || y >= self.height {
                    continue;
                }
                let (to, from) = (3 * (y * self.width + x), 3 * (v * label.width + u));
                for k in 0..3 {
                    let product = u16::from(self.rgb[to + k]) * u16::from(label.rgb[from + k]);
                    self.rgb[to + k] = (product / 255) as u8;
                }
            }
        }
    }

    /// Multiplies a picture of the same size onto this one.
    pub(super) fn multiply(&mut self, other: &Image) {
        for row in 0..self.height.min(other.height) {
            for byte in 0..3 * self.width.min(other.width) {
                let to = 3 * row * self.width + byte;
                let from = 3 * row * other.width + byte;
                let product = u16::from(self.rgb[to]) * u16::from(other.rgb[from]);
                self.rgb[to] = (product / 255) as u8;
            }
        }
    }

    pub(super) fn encode(&self, scale: f64) -> Result<Vec<u8>, PlotError> {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        // One unit of the page is 1/120 inch: 800 units are 17 cm, the width of a printed page.
        let per_metre = (120.0 * scale / 0.0254).round() as u32;
        encoder.set_pixel_dims(Some(png::PixelDimensions {
            xppu: per_metre,
            yppu: per_metre,
            unit: png::Unit::Meter,
        }));
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()?;
        Ok(out)
    }
}

impl From<&Raster> for Image {
    fn from(raster: &Raster) -> Image {
        let (width, height, rgb) = raster.pixels();
        Image { width, height, rgb }
    }
}

/// Bytes as text (RFC 4648).
pub(super) fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let b = |k: usize| u32::from(chunk.get(k).copied().unwrap_or(0));
        let word = b(0) << 16 | b(1) << 8 | b(2);
        for k in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * k) & 63) as usize];
            out.push(if k <= chunk.len() { char::from(letter) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_any_length() {
        let pairs =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg==")];
        pairs.iter().for_each(|(a, b)| assert_eq!(base64(a.as_bytes()), *b));
    }
}

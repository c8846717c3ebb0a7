//! PNG and JPEG as greys.

use std::io::Cursor;

use png::{ColorType, Decoder, Limits, Transformations};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::Wrong;

/// Pixels of one picture.
const MOST: u64 = 50_000_000;
/// Memory for decoding, bytes.
const MEMORY: usize = 256 << 20;

/// A picture in greys, 0 black to 255 white, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels of a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row.
    pub greys: Vec<u8>,
}

/// What a file is by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
    /// SVG.
    Svg,
}

/// What a file is; none for anything else.
pub fn kind(bytes: &[u8]) -> Option<Kind> {
    if bytes.starts_with(b"\x89PNG") {
        return Some(Kind::Png);
    }
    if bytes.starts_with(&[0xFF, 0xD8, 0xFF]) {
        return Some(Kind::Jpeg);
    }
    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]).into_owned();
    (start.contains("<svg") || start.contains(":svg")).then_some(Kind::Svg)
}

/// Decodes a PNG or JPEG.
///
/// # Errors
/// The file is damaged, or too large.
pub fn decode(bytes: &[u8]) -> Result<Picture, Wrong> {
    match kind(bytes) {
        Some(Kind::Png) => png(bytes),
        Some(Kind::Jpeg) => jpeg(bytes),
        _ => Err(Wrong::whole(
            "the file is no PNG, JPEG or SVG",
            "save the picture as PNG, or give G-code to `pasapas stream`",
        )),
    }
}

fn damaged(kind: &str, error: &dyn std::fmt::Display) -> Wrong {
    let error: String =
        error.to_string().lines().next().unwrap_or_default().chars().take(200).collect();
    let words = format!("the {kind} cannot be read: {error}");
    Wrong::whole(words, "the file may be cut: save the picture again")
}

fn fits(width: u64, height: u64) -> Result<(), Wrong> {
    if width == 0 || height == 0 {
        return Err(Wrong::whole("a picture without pixels", "save the picture again"));
    }
    if width.saturating_mul(height) > MOST {
        let words =
            format!("{width} x {height} pixels; at most {} millions are read", MOST / 1_000_000);
        let hint = "save the picture smaller: more pixels than lines do not show";
        return Err(Wrong::whole(words, hint));
    }
    Ok(())
}

fn png(bytes: &[u8]) -> Result<Picture, Wrong> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: MEMORY });
    decoder.set_transformations(Transformations::normalize_to_color8());
    let head = decoder.read_header_info().map_err(|error| damaged("PNG", &error))?;
    fits(head.width.into(), head.height.into())?;
    let mut reader = decoder.read_info().map_err(|error| damaged("PNG", &error))?;
    let size = reader.output_buffer_size().ok_or_else(|| damaged("PNG", &"it is too large"))?;
    let mut pixels = vec![0; size];
    let info = reader.next_frame(&mut pixels).map_err(|error| damaged("PNG", &error))?;
    let (width, height) = (info.width as usize, info.height as usize);
    let greys = match info.color_type {
        ColorType::Grayscale => pixels,
        ColorType::GrayscaleAlpha => pixels.chunks_exact(2).map(|p| over(p[0], p[1])).collect(),
        ColorType::Rgba => {
            pixels.chunks_exact(4).map(|p| over(grey(p[0], p[1], p[2]), p[3])).collect()
        }
        ColorType::Rgb | ColorType::Indexed => {
            pixels.chunks_exact(3).map(|p| grey(p[0], p[1], p[2])).collect()
        }
    };
    whole("PNG", width, height, greys)
}

fn jpeg(bytes: &[u8]) -> Result<Picture, Wrong> {
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(65_535)
        .set_max_height(65_535)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|error| damaged("JPEG", &error))?;
    let info = decoder.info().ok_or_else(|| damaged("JPEG", &"it has no size"))?;
    fits(info.width.into(), info.height.into())?;
    let pixels = decoder.decode().map_err(|error| damaged("JPEG", &error))?;
    let greys = pixels.chunks_exact(3).map(|p| grey(p[0], p[1], p[2])).collect();
    whole("JPEG", info.width.into(), info.height.into(), greys)
}

fn whole(kind: &str, width: usize, height: usize, mut greys: Vec<u8>) -> Result<Picture, Wrong> {
    if greys.len() < width * height {
        return Err(damaged(kind, &"pixels are missing"));
    }
    greys.truncate(width * height);
    Ok(Picture { width, height, greys })
}

/// How bright a colour is (ITU-R BT.601).
fn grey(r: u8, g: u8, b: u8) -> u8 {
    let sum = 299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b);
    ((sum + 500) / 1000) as u8
}

/// A grey over white paper.
fn over(grey: u8, alpha: u8) -> u8 {
    let (grey, alpha) = (u32::from(grey), u32::from(alpha));
    ((grey * alpha + 255 * (255 - alpha) + 127) / 255) as u8
}

impl Picture {
    /// The same with other columns and rows: each pixel is the mean of what it covers.
    ///
    /// # Panics
    /// Never: columns and rows are at least 1.
    #[must_use]
    pub fn scaled(&self, columns: usize, rows: usize) -> Picture {
        let cut = |n: usize, of: usize, from: usize| {
            let first = n * from / of;
            first..((n + 1) * from / of).max(first + 1)
        };
        let mut greys = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let (mut sum, mut count) = (0_u64, 0);
                for y in cut(row, rows, self.height) {
                    for x in cut(column, columns, self.width) {
                        sum += u64::from(self.greys[y * self.width + x]);
                        count += 1;
                    }
                }
                greys.push(((sum + count / 2) / count.max(1)) as u8);
            }
        }
        Picture { width: columns, height: rows, greys }
    }
}

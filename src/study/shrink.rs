//! Smaller images: thumbnails, and what a full image looks like at the size of a small one.

use crate::output::Image;

/// The size of an image of `size` within a square of `side` pixels; never larger than it is.
#[must_use]
pub fn fitting(size: [u32; 2], side: u32) -> [u32; 2] {
    let longest = size[0].max(size[1]).max(1);
    let scale = (f64::from(side) / f64::from(longest)).min(1.0);
    size.map(|n| ((f64::from(n) * scale).round() as u32).max(1))
}

/// The image at another, smaller size: every pixel is the mean over its area.
#[must_use]
pub fn shrink(image: &Image, size: [u32; 2]) -> Image {
    let (columns, rows) = (image.width as usize, image.height as usize);
    let [width, height] = size.map(|n| n.max(1) as usize);
    let across = weights(columns, width);
    let down = weights(rows, height);
    // Rows first: each becomes `width` pixels.
    let mut narrow = Vec::with_capacity(rows * width);
    for row in image.pixels.chunks_exact(columns.max(1)) {
        narrow.extend(across.iter().map(|w| mean(w, |i| row[i])));
    }
    let mut pixels = Vec::with_capacity(width * height);
    for weights in &down {
        pixels.extend((0..width).map(|x| mean(weights, |y| narrow[y * width + x])));
    }
    Image {
        width: width as u32,
        height: height as u32,
        pixels,
    }
}

/// For each of `to` pixels: which of `from` pixels it covers, and how much of itself each fills.
fn weights(from: usize, to: usize) -> Vec<Vec<(usize, f32)>> {
    let scale = from as f64 / to as f64;
    let covered = |i: usize| {
        let (start, end) = (i as f64 * scale, (i + 1) as f64 * scale);
        let last = (end.ceil() as usize).min(from);
        let share = |j: usize| (end.min((j + 1) as f64) - start.max(j as f64)) / scale;
        let first = (start.floor() as usize).min(last);
        (first..last).map(|j| (j, share(j) as f32)).collect()
    };
    (0..to).map(covered).collect()
}

fn mean(weights: &[(usize, f32)], pixel: impl Fn(usize) -> [f32; 4]) -> [f32; 4] {
    let mut sum = [0.0; 4];
    for &(i, weight) in weights {
        for (sum, value) in sum.iter_mut().zip(pixel(i)) {
            *sum += weight * value;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(values: &[f32]) -> Image {
        Image {
            width: values.len() as u32,
            height: 1,
            pixels: values.iter().map(|v| [*v; 4]).collect(),
        }
    }

    #[test]
    fn pixels_are_means_over_areas() {
        let small = shrink(&row(&[0.0, 3.0, 6.0]), [2, 1]);
        let values: Vec<f32> = small.pixels.iter().map(|p| p[0]).collect();
        // (0 + 3 / 2) / 1.5 and (3 / 2 + 6) / 1.5
        assert!((values[0] - 1.0).abs() < 1e-6 && (values[1] - 5.0).abs() < 1e-6);
        let square = Image {
            width: 2,
            height: 2,
            pixels: [1.0, 2.0, 3.0, 6.0].map(|v| [v; 4]).to_vec(),
        };
        assert_eq!(shrink(&square, [1, 1]).pixels, [[3.0; 4]]);
        assert_eq!(shrink(&square, [2, 2]), square);
    }

    #[test]
    fn sizes_keep_their_shape_and_a_pixel() {
        assert_eq!(fitting([768, 384], 192), [192, 96]);
        assert_eq!(fitting([100, 50], 192), [100, 50]);
        assert_eq!(fitting([16384, 1], 192), [192, 1]);
    }
}

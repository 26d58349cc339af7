//! Pictures turned upright.

use iridesce_numerics::Watch;

/// Pixels between two looks at the watch.
const PIECE: usize = 1 << 18;

/// A picture whose first row and column lie as an orientation of TIFF and EXIF says (TIFF 6.0, tag 274), with row 0 on top and
/// column 0 at the left: its width, height and pixels of `channels` numbers. Only a stop of the watch is an error.
pub fn upright<T: Copy>(
    orientation: u16,
    width: usize,
    height: usize,
    channels: usize,
    pixels: Vec<T>,
    watch: &Watch,
) -> Result<(usize, usize, Vec<T>), String> {
    if !matches!(orientation, 2..=8) {
        return Ok((width, height, pixels));
    }
    let is_turned = orientation >= 5;
    let (new_width, new_height) = if is_turned { (height, width) } else { (width, height) };
    let mut turned = Vec::with_capacity(pixels.len());
    let rows_a_piece = (PIECE / new_width.max(1)).max(1);
    for row in 0..new_height {
        if row % rows_a_piece == 0 {
            watch.check().map_err(|stopped| stopped.to_string())?;
        }
        for column in 0..new_width {
            let (x, y) = match orientation {
                2 => (width - 1 - column, row),
                3 => (width - 1 - column, height - 1 - row),
                4 => (column, height - 1 - row),
                5 => (row, column),
                6 => (row, height - 1 - column),
                7 => (width - 1 - row, height - 1 - column),
                _ => (width - 1 - row, column),
            };
            let at = channels * (y * width + x);
            turned.extend_from_slice(&pixels[at..at + channels]);
        }
    }
    Ok((new_width, new_height, turned))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_orientation_is_turned_back() {
        // Stored 3 x 2:  a b c / d e f.
        let stored = vec!['a', 'b', 'c', 'd', 'e', 'f'];
        for (orientation, width, expected) in [
            (1, 3, "abcdef"),
            (2, 3, "cbafed"),
            (3, 3, "fedcba"),
            (4, 3, "defabc"),
            (5, 2, "adbecf"),
            (6, 2, "daebfc"),
            (7, 2, "fcebda"),
            (8, 2, "cfbead"),
        ] {
            let (w, h, turned) = upright(orientation, 3, 2, 1, stored.clone(), &Watch::new()).unwrap();
            assert_eq!((w, w * h, turned.iter().collect::<String>().as_str()), (width, 6, expected), "{orientation}");
        }
        assert_eq!(upright(2, 2, 1, 2, vec![1, 2, 3, 4], &Watch::new()).unwrap().2, [3, 4, 1, 2]);
        let stopped = Watch::new();
        stopped.stop();
        assert_eq!(upright(2, 2, 1, 2, vec![1, 2, 3, 4], &stopped), Err("stopped".to_owned()));
    }
}

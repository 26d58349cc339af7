//! Pieces of a picture: what is drawn by one thread at a time, kept in journals, and shared out between machines.

/// Pixels along a tile's side. Small enough that few are lost when a program is killed and that all cores have work to the
/// end; large enough that making a tile's working memory does not count.
pub const SIDE: u32 = 16;

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rect {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Rect {
    /// How many pixels it has.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The smallest rectangle around both.
    pub(crate) fn around(self, other: Rect) -> Rect {
        let (x, y) = (self.x.min(other.x), self.y.min(other.y));
        let (right, bottom) =
            ((self.x + self.width).max(other.x + other.width), (self.y + self.height).max(other.y + other.height));
        Rect { x, y, width: right - x, height: bottom - y }
    }
}

/// One of `of` equal shares of the tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 1.
    pub number: u32,
    /// Of how many.
    pub of: u32,
}

impl Shard {
    /// Most shares of a picture.
    pub const MOST: u32 = 1 << 20;

    /// Whether the tile is one of this share. Neighbours go to different shares: each gets some of what is slow.
    pub fn has(&self, tile: usize) -> bool {
        tile % self.of as usize == self.number as usize - 1
    }
}

/// The tiles of a part of a picture, row after row; those at its right and lower edges may be smaller.
pub fn tiles(part: Rect) -> Vec<Rect> {
    let mut tiles = Vec::new();
    for row in 0..part.height.div_ceil(SIDE) {
        for column in 0..part.width.div_ceil(SIDE) {
            let (left, top) = (column * SIDE, row * SIDE);
            tiles.push(Rect {
                x: part.x + left,
                y: part.y + top,
                width: SIDE.min(part.width - left),
                height: SIDE.min(part.height - top),
            });
        }
    }
    tiles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_one_tile_and_every_tile_in_one_shard() {
        let part = Rect { x: 5, y: 9, width: 70, height: 33 };
        let mut seen = vec![0; part.pixels()];
        let all = tiles(part);
        for tile in &all {
            for y in tile.y..tile.y + tile.height {
                for x in tile.x..tile.x + tile.width {
                    seen[((y - part.y) * part.width + x - part.x) as usize] += 1;
                }
            }
        }
        assert!(seen.iter().all(|&count| count == 1));
        for of in [1, 2, 7, 100] {
            for tile in 0..all.len() {
                assert_eq!((1..=of).filter(|&number| Shard { number, of }.has(tile)).count(), 1);
            }
        }
    }
}

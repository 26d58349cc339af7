//! Building a hierarchy: splits by the surface area heuristic in bins, then eight children a node.
//!
//! I. Wald, "On fast construction of SAH-based bounding volume hierarchies", IEEE Symposium on Interactive Ray Tracing 2007;
//! I. Wald, C. Benthin, S. Boulos, "Getting rid of packets", IEEE Symposium on Interactive Ray Tracing 2008.
//! The tree depends on the boxes only, not on the number of threads. Boxes are in single precision here: half the memory, through which
//! a build goes some forty times.

use rayon::prelude::*;

/// Most bins along an axis, and how many where few things are left.
const BINS: usize = 16;
const FEW_BINS: usize = 8;
/// A split that looks useless is made all the same where more than so many things would share a leaf.
pub const LEAF: usize = 4;
/// Work is shared out between threads above so many things.
pub const PARALLEL: usize = 1 << 13;
/// So many things or fewer are split by looking at each place between two of them.
const FEW: usize = 8;
/// More things than these are put into bins by all threads together: while few halves are under work the others would wait.
const MANY: usize = 1 << 17;
/// More things than these are split along the axis on which they lie farthest apart: which axis it is hardly matters high up in the tree.
const CROWD: usize = 1 << 12;
/// Below this depth halves replace the heuristic: a walk's memory stays bounded whatever the boxes are.
const DEEPEST: usize = 48;
/// Most levels of a tree: below [`DEEPEST`] halves, of fewer than 2^32 things.
pub const MOST_LEVELS: usize = DEEPEST + 32;

/// A box in single precision, as vectors of four; what the fourth numbers are does not matter.
#[derive(Debug, Clone, Copy)]
#[repr(align(16))]
pub struct Box32 {
    pub min: [f32; 4],
    pub max: [f32; 4],
}

impl Box32 {
    const EMPTY: Box32 = Box32 { min: [f32::INFINITY; 4], max: [f32::NEG_INFINITY; 4] };

    /// Not by `f32::min`: that looks for no numbers, of which there are none.
    #[inline(always)]
    fn add(&mut self, min: [f32; 4], max: [f32; 4]) {
        for (own, other) in self.min.iter_mut().zip(min) {
            *own = if other < *own { other } else { *own };
        }
        for (own, other) in self.max.iter_mut().zip(max) {
            *own = if other > *own { other } else { *own };
        }
    }

    #[inline(always)]
    fn union(mut self, other: &Box32) -> Box32 {
        self.add(other.min, other.max);
        self
    }

    /// The axis along which it is longest.
    fn longest(&self) -> usize {
        let extent = |axis: usize| self.max[axis] - self.min[axis];
        (0..3).fold(0, |best, axis| if extent(axis) > extent(best) { axis } else { best })
    }

    /// Half its surface.
    pub fn half_area(&self) -> f64 {
        let along = |axis: usize| (f64::from(self.max[axis]) - f64::from(self.min[axis])).max(0.0);
        let (x, y, z) = (along(0), along(1), along(2));
        x * y + y * z + z * x
    }
}

/// A binary tree over items, which it has put into order.
pub enum Tree {
    Leaf { bounds: Box32, first: usize, count: usize },
    Inner { bounds: Box32, children: Box<[Tree; 2]> },
}

/// Something with a box, by its number.
#[derive(Clone, Copy)]
pub struct Item(Box32);

impl Item {
    pub fn new([x, y, z]: [f32; 3], max: [f32; 3], number: u32) -> Item {
        // The number fills the vector.
        Item(Box32 { min: [x, y, z, f32::from_bits(number)], max: [max[0], max[1], max[2], 0.0] })
    }

    pub fn number(&self) -> u32 {
        self.0.min[3].to_bits()
    }

    /// Twice the middle of its box.
    #[inline(always)]
    fn middle(&self) -> [f32; 4] {
        let (low, high) = (&self.0.min, &self.0.max);
        [low[0] + high[0], low[1] + high[1], low[2] + high[2], 0.0]
    }
}

/// Boxes around things and around their middles.
#[derive(Clone, Copy)]
struct Around {
    bounds: Box32,
    middles: Box32,
}

impl Around {
    fn of(items: &[Item]) -> Around {
        let mut all = Around { bounds: Box32::EMPTY, middles: Box32::EMPTY };
        for item in items {
            all.bounds.add(item.0.min, item.0.max);
            all.middles.add(item.middle(), item.middle());
        }
        all
    }
}

/// Where things are parted.
struct Split {
    cost: f64,
    axis: usize,
    /// The first bin on the right; where things are few, their number on the left, in the order of their middles.
    at: usize,
}

/// Which of so many bins things are in.
#[derive(Clone, Copy)]
struct Binning {
    count: usize,
    from: [f32; 4],
    per_length: [f32; 3],
}

impl Binning {
    fn new(middles: &Box32, items: usize) -> Binning {
        let count = if items < 2 * BINS { FEW_BINS } else { BINS };
        let per_length = std::array::from_fn(|axis| count as f32 / (middles.max[axis] - middles.min[axis]));
        Binning { count, from: middles.min, per_length }
    }

    #[inline(always)]
    fn bin(&self, middle: [f32; 4], axis: usize) -> usize {
        // By way of a number with a sign: one instruction.
        let bin = ((middle[axis] - self.from[axis]) * self.per_length[axis]) as i32;
        bin.clamp(0, self.count as i32 - 1) as usize
    }
}

impl Tree {
    /// The tree over items; `None` where there are none.
    pub fn new(items: &mut [Item]) -> Option<Tree> {
        let around = Around::of(items);
        (!items.is_empty()).then(|| split(items, around, 0, 0))
    }

    pub fn bounds(&self) -> &Box32 {
        match self {
            Tree::Leaf { bounds, .. } | Tree::Inner { bounds, .. } => bounds,
        }
    }
}

fn split(items: &mut [Item], around: Around, first: usize, depth: usize) -> Tree {
    let Around { bounds, middles } = around;
    let count = items.len();
    if count <= 1 {
        return Tree::Leaf { bounds, first, count };
    }
    let binning = Binning::new(&middles, count);
    let best = match count {
        _ if depth >= DEEPEST => None,
        ..=FEW => best_of_few(items),
        _ => best_split(items, &around, &binning),
    };
    let (at, [left_around, right_around]) = match best {
        // A leaf of up to four is met in one go: it costs as much as a box of one.
        Some(Split { cost, .. }) if count <= LEAF && cost >= bounds.half_area() => {
            return Tree::Leaf { bounds, first, count };
        }
        Some(Split { axis, at, .. }) if count <= FEW => {
            sort(items, axis);
            let (left, right) = items.split_at(at);
            (at, [Around::of(left), Around::of(right)])
        }
        Some(Split { axis, at, .. }) => partition(items, |middle| binning.bin(middle, axis) < at),
        None if count <= LEAF => return Tree::Leaf { bounds, first, count },
        None => {
            let axis = middles.longest();
            items.select_nth_unstable_by(count / 2, |a, b| {
                a.middle()[axis].total_cmp(&b.middle()[axis]).then(a.number().cmp(&b.number()))
            });
            let (left, right) = items.split_at(count / 2);
            (count / 2, [Around::of(left), Around::of(right)])
        }
    };
    let (left, right) = items.split_at_mut(at);
    let mut left = || split(left, left_around, first, depth + 1);
    let mut right = || split(right, right_around, first + at, depth + 1);
    let children = if count > PARALLEL { rayon::join(left, right).into() } else { [left(), right()] };
    Tree::Inner { bounds, children: Box::new(children) }
}

/// In the order of their middles along an axis.
fn sort(items: &mut [Item], axis: usize) {
    items.sort_unstable_by(|a, b| a.middle()[axis].total_cmp(&b.middle()[axis]).then(a.number().cmp(&b.number())));
}

/// The cheapest split of few things, each place between two of them looked at: quicker than by bins, of which most would be empty.
/// `None` where all middles are at one place.
fn best_of_few(items: &mut [Item]) -> Option<Split> {
    let count = items.len();
    let mut best: Option<Split> = None;
    for axis in 0..3 {
        sort(items, axis);
        if items[0].middle()[axis] == items[count - 1].middle()[axis] {
            continue;
        }
        let mut right = [0.0; FEW];
        let mut all = Box32::EMPTY;
        for at in (1..count).rev() {
            all.add(items[at].0.min, items[at].0.max);
            right[at] = all.half_area() * blocks((count - at) as u32);
        }
        let mut all = Box32::EMPTY;
        for at in 1..count {
            all.add(items[at - 1].0.min, items[at - 1].0.max);
            let cost = all.half_area() * blocks(at as u32) + right[at];
            if best.as_ref().is_none_or(|best| cost < best.cost) {
                best = Some(Split { cost, axis, at });
            }
        }
    }
    best
}

/// What is in each bin along each axis: a box around it, and how many things.
type Bins = [[(Box32, u32); BINS]; 3];

/// Things put into the bins of the axes along which they differ.
fn binned(items: &[Item], axes: [bool; 3], binning: &Binning) -> Bins {
    let mut bins = [[(Box32::EMPTY, 0_u32); BINS]; 3];
    for item in items {
        let middle = item.middle();
        for (axis, bins) in bins.iter_mut().enumerate() {
            if axes[axis] {
                let (bounds, within) = &mut bins[binning.bin(middle, axis)];
                bounds.add(item.0.min, item.0.max);
                *within += 1;
            }
        }
    }
    bins
}

fn joined(mut all: Bins, other: Bins) -> Bins {
    for (own, other) in all.as_flattened_mut().iter_mut().zip(other.as_flattened()) {
        *own = (own.0.union(&other.0), own.1 + other.1);
    }
    all
}

/// The cheapest split; `None` where all middles are at one place.
fn best_split(items: &[Item], around: &Around, binning: &Binning) -> Option<Split> {
    // Below this, bins are rounding.
    let is_wide = |axis: usize| {
        let extent = around.middles.max[axis] - around.middles.min[axis];
        extent > 1e-6 * (around.bounds.max[axis] - around.bounds.min[axis]) && extent > 0.0 && extent < f32::INFINITY
    };
    let mut axes = [is_wide(0), is_wide(1), is_wide(2)];
    if items.len() > CROWD {
        let longest = around.middles.longest();
        axes = std::array::from_fn(|axis| axis == longest && axes[axis]);
    }
    let count = binning.count;
    let bins = match items.len() {
        ..=MANY => binned(items, axes, binning),
        _ => {
            let parts = items.par_chunks(MANY).map(|part| binned(part, axes, binning));
            parts.reduce(|| binned(&[], axes, binning), joined)
        }
    };
    let mut best: Option<Split> = None;
    for axis in (0..3).filter(|axis| axes[*axis]) {
        let bins = &bins[axis][..count];
        let mut right = [(0.0, 0.0); BINS];
        let mut all = (Box32::EMPTY, 0);
        for at in (1..count).rev() {
            all = (all.0.union(&bins[at].0), all.1 + bins[at].1);
            right[at] = (all.0.half_area(), blocks(all.1));
        }
        let mut left = (Box32::EMPTY, 0);
        for at in 1..count {
            left = (left.0.union(&bins[at - 1].0), left.1 + bins[at - 1].1);
            if left.1 == 0 || left.1 as usize == items.len() {
                continue;
            }
            let cost = left.0.half_area() * blocks(left.1) + right[at].0 * right[at].1;
            if best.as_ref().is_none_or(|best| cost < best.cost) {
                best = Some(Split { cost, axis, at });
            }
        }
    }
    best
}

/// What so many things cost: they are met four at a time.
fn blocks(count: u32) -> f64 {
    f64::from(count.div_ceil(LEAF as u32))
}

/// Puts those that belong to the left first, and tells how many they are and what is around either.
fn partition(items: &mut [Item], is_left: impl Fn([f32; 4]) -> bool) -> (usize, [Around; 2]) {
    let [mut left, mut right] = [Around { bounds: Box32::EMPTY, middles: Box32::EMPTY }; 2];
    let (mut at, mut end) = (0, items.len());
    while at < end {
        let item = items[at];
        let middle = item.middle();
        if is_left(middle) {
            left.bounds.add(item.0.min, item.0.max);
            left.middles.add(middle, middle);
            at += 1;
        } else {
            right.bounds.add(item.0.min, item.0.max);
            right.middles.add(middle, middle);
            end -= 1;
            items[at] = items[end];
            items[end] = item;
        }
    }
    (at, [left, right])
}

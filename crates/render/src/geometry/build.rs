//! Building a hierarchy: splits by the surface area heuristic in bins, then eight children a node.
//!
//! I. Wald, "On fast construction of SAH-based bounding volume hierarchies", IEEE Symposium on Interactive Ray Tracing 2007;
//! I. Wald, C. Benthin, S. Boulos, "Getting rid of packets", IEEE Symposium on Interactive Ray Tracing 2008.
//! The tree depends on the boxes only, not on the number of threads.

use super::bounds::Bounds;

/// Bins along an axis.
const BINS: usize = 16;
/// A split that looks useless is made all the same where more than so many things would share a leaf.
pub const LEAF: usize = 4;
/// Work is shared out between threads above so many things.
const PARALLEL: usize = 1 << 13;
/// Below this depth halves replace the heuristic: a walk's memory stays bounded whatever the boxes are.
const DEEPEST: usize = 48;

/// A binary tree over items, which it has put into order.
pub enum Tree {
    Leaf { bounds: Bounds, first: usize, count: usize },
    Inner { bounds: Bounds, children: Box<[Tree; 2]> },
}

/// Something with a box, by its number.
#[derive(Clone, Copy)]
pub struct Item {
    pub bounds: Bounds,
    pub number: u32,
}

impl Item {
    fn middle(&self, axis: usize) -> f64 {
        0.5 * (self.bounds.min[axis] + self.bounds.max[axis])
    }
}

impl Tree {
    /// The tree over items; `None` where there are none.
    pub fn new(items: &mut [Item]) -> Option<Tree> {
        (!items.is_empty()).then(|| split(items, 0, 0))
    }

    pub fn bounds(&self) -> &Bounds {
        match self {
            Tree::Leaf { bounds, .. } | Tree::Inner { bounds, .. } => bounds,
        }
    }
}

fn split(items: &mut [Item], first: usize, depth: usize) -> Tree {
    let bounds = items.iter().fold(Bounds::EMPTY, |all, item| all.union(&item.bounds));
    let count = items.len();
    if count <= 1 {
        return Tree::Leaf { bounds, first, count };
    }
    let middles = Bounds::of(items.iter().map(|item| std::array::from_fn(|axis| item.middle(axis))));
    let extent: [f64; 3] = std::array::from_fn(|axis| middles.max[axis] - middles.min[axis]);
    let best = if depth < DEEPEST { best_split(items, &middles, &bounds) } else { None };
    let at = match best {
        // A leaf of up to four is met in one go: it costs as much as a box of one.
        Some((cost, _, _)) if count <= LEAF && cost >= bounds.half_area() => {
            return Tree::Leaf { bounds, first, count };
        }
        Some((_, axis, bin)) => partition(items, |item| bin_of(item, axis, &middles) < bin),
        None if count <= LEAF => return Tree::Leaf { bounds, first, count },
        None => {
            let axis = (0..3).fold(0, |best, axis| if extent[axis] > extent[best] { axis } else { best });
            items.select_nth_unstable_by(count / 2, |a, b| {
                a.middle(axis).total_cmp(&b.middle(axis)).then(a.number.cmp(&b.number))
            });
            count / 2
        }
    };
    let (left, right) = items.split_at_mut(at);
    let children = if count > PARALLEL {
        let (left, right) = rayon::join(|| split(left, first, depth + 1), || split(right, first + at, depth + 1));
        [left, right]
    } else {
        [split(left, first, depth + 1), split(right, first + at, depth + 1)]
    };
    Tree::Inner { bounds, children: Box::new(children) }
}

fn bin_of(item: &Item, axis: usize, middles: &Bounds) -> usize {
    let share = (item.middle(axis) - middles.min[axis]) / (middles.max[axis] - middles.min[axis]);
    ((share * BINS as f64) as usize).min(BINS - 1)
}

/// Cost, axis and first bin on the right of the cheapest split; `None` where all middles are at one place.
fn best_split(items: &[Item], middles: &Bounds, bounds: &Bounds) -> Option<(f64, usize, usize)> {
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        let extent = middles.max[axis] - middles.min[axis];
        // Below this, bins are rounding.
        if extent.is_nan() || extent <= 1e-12 * (bounds.max[axis] - bounds.min[axis]) || extent <= 0.0 {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0_usize); BINS];
        for item in items {
            let bin = &mut bins[bin_of(item, axis, middles)];
            *bin = (bin.0.union(&item.bounds), bin.1 + 1);
        }
        let mut right = [(0.0, 0.0); BINS];
        let mut all = (Bounds::EMPTY, 0);
        for at in (1..BINS).rev() {
            all = (all.0.union(&bins[at].0), all.1 + bins[at].1);
            right[at] = (all.0.half_area(), blocks(all.1));
        }
        let mut left = (Bounds::EMPTY, 0);
        for at in 1..BINS {
            left = (left.0.union(&bins[at - 1].0), left.1 + bins[at - 1].1);
            if left.1 == 0 || left.1 == items.len() {
                continue;
            }
            let cost = left.0.half_area() * blocks(left.1) + right[at].0 * right[at].1;
            if best.is_none_or(|(least, _, _)| cost < least) {
                best = Some((cost, axis, at));
            }
        }
    }
    best
}

/// What so many things cost: they are met four at a time.
fn blocks(count: usize) -> f64 {
    count.div_ceil(LEAF) as f64
}

/// Puts those that belong to the left first, in their order, and tells how many they are.
fn partition(items: &mut [Item], is_left: impl Fn(&Item) -> bool) -> usize {
    let right: Vec<Item> = items.iter().copied().filter(|item| !is_left(item)).collect();
    let mut at = 0;
    for read in 0..items.len() {
        if is_left(&items[read]) {
            items[at] = items[read];
            at += 1;
        }
    }
    items[at..].copy_from_slice(&right);
    at
}

//! Which medium a path is in: every surface with something behind it is entered and left.

use crate::spectral::{FROM_NM, TO_NM};
use iridesce_optics::{Complex64, Medium, OpticsError};
use iridesce_scene::OPAQUE_K;

/// The number of the medium that scenes are surrounded by: n = 1.
pub const SURROUNDING: u8 = 0;

/// Deepest nesting of media within one another.
pub const DEEPEST: usize = 7;

/// The media a path is within, the innermost last; the surrounding one is not counted.
///
/// Eight bytes: every path carries one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MediumStack {
    media: [u8; DEEPEST],
    depth: u8,
}

impl MediumStack {
    #[inline(always)]
    pub fn innermost(&self) -> u8 {
        if self.depth == 0 { SURROUNDING } else { self.media[self.depth as usize - 1] }
    }

    /// One medium deeper; `None` beyond the deepest nesting.
    #[inline(always)]
    pub fn entered(mut self, medium: u8) -> Option<MediumStack> {
        *self.media.get_mut(self.depth as usize)? = medium;
        self.depth += 1;
        Some(self)
    }

    /// Behind a surface of a medium that a stronger one hides, on the way in (`enters`) or out; `None` where the surface is
    /// there. The strongest medium is the innermost.
    pub fn behind_hidden(&self, medium: u8, enters: bool, priority: impl Fn(u8) -> i32) -> Option<MediumStack> {
        let depth = usize::from(self.depth);
        let own = priority(medium);
        let stronger = self.media[..depth].iter().rev().take_while(|&&other| priority(other) > own).count();
        if stronger == 0 {
            return None;
        }
        let mut changed = *self;
        let at = depth - stronger;
        if enters {
            if depth == DEEPEST {
                return None;
            }
            changed.media.copy_within(at..depth, at + 1);
            changed.media[at] = medium;
            changed.depth += 1;
            return Some(changed);
        }
        // The last of its own strength is the one to leave.
        if at == 0 || self.media[at - 1] != medium {
            return None;
        }
        changed.media.copy_within(at..depth, at - 1);
        changed.media[depth - 1] = SURROUNDING;
        changed.depth -= 1;
        Some(changed)
    }

    /// Out of the innermost medium.
    #[inline(always)]
    pub fn left(mut self) -> MediumStack {
        self.depth = self.depth.saturating_sub(1);
        if let Some(last) = self.media.get_mut(self.depth as usize) {
            *last = SURROUNDING;
        }
        self
    }
}

/// The media of a scene by their numbers in a render.
pub struct Media {
    list: Vec<Medium>,
    /// Indices every 10 nm, by which equal media are known.
    known: Vec<Vec<Complex64>>,
    /// Who rules where several lie over each other: the highest.
    priorities: Vec<i32>,
}

impl Media {
    pub fn new() -> Media {
        let one = Complex64::new(1.0, 0.0);
        let vacuum = Medium::constant(one).unwrap_or_else(|_| unreachable!("1 is an index"));
        Media { list: vec![vacuum], known: vec![vec![one; visible().count()]], priorities: vec![0] }
    }

    /// The number of a medium of a priority, a new one if it has none yet; `None` inside where there are too many.
    pub fn number(&mut self, medium: &Medium, priority: i32) -> Result<Option<u8>, OpticsError> {
        let indices = indices(medium, visible())?;
        let is_it = |at: &usize| self.known[*at] == indices && self.priorities[*at] == priority;
        let at = (0..self.known.len()).find(is_it).unwrap_or_else(|| {
            self.priorities.push(priority);
            self.list.push(medium.clone());
            self.known.push(indices);
            self.list.len() - 1
        });
        Ok(u8::try_from(at).ok())
    }

    /// Who rules where several lie over each other: the highest.
    #[inline(always)]
    pub fn priority(&self, number: u8) -> i32 {
        self.priorities[usize::from(number)]
    }

    /// Whether two numbers mean one medium, of whatever priorities.
    #[inline(always)]
    pub fn are_one(&self, a: u8, b: u8) -> bool {
        a == b || self.known[usize::from(a)] == self.known[usize::from(b)]
    }

    pub fn list(&self) -> &[Medium] {
        &self.list
    }

    /// Whether light that enters a medium is taken as absorbed.
    pub fn is_opaque(&self, number: u8) -> bool {
        self.known[usize::from(number)].iter().all(|n| n.im >= OPAQUE_K)
    }

    pub fn name(&self, number: u8) -> &str {
        self.list[usize::from(number)].name()
    }
}

/// Complex indices at these wavelengths, by the medium's own extension where its data end.
pub fn indices(medium: &Medium, wavelength_nm: impl Iterator<Item = f64>) -> Result<Vec<Complex64>, OpticsError> {
    wavelength_nm.map(|nm| medium.index_extended(nm).map(|(n, _)| n)).collect()
}

/// Every 10 nm of the visible range.
pub fn visible() -> impl Iterator<Item = f64> {
    (FROM_NM as u32..=TO_NM as u32).step_by(10).map(f64::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn media_are_entered_and_left_in_order() {
        let inside = MediumStack::default().entered(3).unwrap().entered(5).unwrap();
        assert_eq!((inside.innermost(), inside.left().innermost()), (5, 3));
        assert_eq!(inside.left().left(), MediumStack::default());
        assert_eq!(MediumStack::default().left().innermost(), SURROUNDING);
        let deepest = (0..DEEPEST).try_fold(MediumStack::default(), |medium, i| medium.entered(i as u8 + 1)).unwrap();
        assert_eq!(deepest.entered(9), None);
    }

    /// Water (1) within which glass (2) rules: a surface of water inside the glass is hidden, on the way in and out.
    #[test]
    fn the_strongest_medium_rules_wherever_it_was_entered() {
        let priority = |medium: u8| i32::from(medium);
        let glass = MediumStack::default().entered(2).unwrap();
        let both = glass.behind_hidden(1, true, priority).unwrap();
        assert_eq!((both.innermost(), both.left().innermost()), (2, 1));
        assert_eq!(both.behind_hidden(1, false, priority), Some(glass));
        assert_eq!(both.left().behind_hidden(1, false, priority), None, "out in the water its surface is there");
        assert_eq!(MediumStack::default().behind_hidden(1, true, priority), None);
        assert_eq!(glass.behind_hidden(2, true, priority), None, "an equal hides nothing");
    }

    #[test]
    fn equal_media_have_one_number() {
        let mut media = Media::new();
        let glass = media.number(&Medium::named("N-BK7").unwrap(), 0).unwrap().unwrap();
        assert_eq!(media.number(&Medium::named("air").unwrap(), 0).unwrap(), Some(SURROUNDING));
        assert_eq!(media.number(&Medium::named("N-BK7").unwrap(), 0).unwrap(), Some(glass));
        let silicon = media.number(&Medium::named("Si").unwrap(), 0).unwrap().unwrap();
        assert!(media.is_opaque(silicon) && !media.is_opaque(glass));
    }
}

//! Which medium a path is in: every surface with something behind it is entered and left.

use crate::spectral::{FROM_NM, TO_NM};
use iridesce_optics::{Complex64, Medium, OpticsError};

/// The number of the medium that scenes are surrounded by: n = 1.
pub const SURROUNDING: u8 = 0;

/// Deepest nesting of media within one another.
pub const DEEPEST: usize = 7;

/// Least k, over the visible range, of a medium that is taken as opaque wherever it fills space: e^-1 within 50 um.
const OPAQUE_K: f64 = 1e-3;

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
}

impl Media {
    pub fn new() -> Media {
        let one = Complex64::new(1.0, 0.0);
        let vacuum = Medium::constant(one).unwrap_or_else(|_| unreachable!("1 is an index"));
        Media { list: vec![vacuum], known: vec![vec![one; visible().count()]] }
    }

    /// The number of a medium, a new one if it has none yet; `None` inside where there are too many.
    pub fn number(&mut self, medium: &Medium) -> Result<Option<u8>, OpticsError> {
        let indices = indices(medium, visible())?;
        let at = self.known.iter().position(|known| *known == indices).unwrap_or_else(|| {
            self.list.push(medium.clone());
            self.known.push(indices);
            self.list.len() - 1
        });
        Ok(u8::try_from(at).ok())
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

    #[test]
    fn equal_media_have_one_number() {
        let mut media = Media::new();
        let glass = media.number(&Medium::named("N-BK7").unwrap()).unwrap().unwrap();
        assert_eq!(media.number(&Medium::named("air").unwrap()).unwrap(), Some(SURROUNDING));
        assert_eq!(media.number(&Medium::named("N-BK7").unwrap()).unwrap(), Some(glass));
        let silicon = media.number(&Medium::named("Si").unwrap()).unwrap().unwrap();
        assert!(media.is_opaque(silicon) && !media.is_opaque(glass));
    }
}

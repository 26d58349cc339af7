//! What a path does at mirrors, clear surfaces and films, one after the other.

/// What a path has done at the surfaces that it met since it was scattered: mirrored there or passed, first things first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Chain(u32);

impl Chain {
    /// Not told: it was not scattered where caustics are sampled, or has come too far since.
    pub const UNTOLD: Chain = Chain(0);
    /// Just scattered.
    pub const START: Chain = Chain(1);
    /// Events that are told at most.
    pub const MOST: u32 = 30;

    /// One event more.
    #[inline(always)]
    pub fn then(self, mirrors: bool) -> Chain {
        if self.0 == 0 || self.0 >> Chain::MOST != 0 { Chain::UNTOLD } else { Chain(self.0 << 1 | u32::from(mirrors)) }
    }

    /// The chain of a path that goes the other way: `events` in their order, the first one lowest.
    pub fn reversed(events: u32, count: u32) -> Chain {
        Chain(1 << count | events & ((1 << count) - 1))
    }

    /// Whether it mirrors, event by event; none where nothing is told.
    #[inline(always)]
    pub fn events(self) -> impl Iterator<Item = bool> {
        let count = 31_u32.saturating_sub(self.0.leading_zeros());
        (0..count).rev().map(move |at| self.0 >> at & 1 == 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_read_from_its_first_event_and_turned_around() {
        let chain = Chain::START.then(true).then(false).then(false);
        assert_eq!(chain.events().collect::<Vec<_>>(), [true, false, false]);
        // The same surfaces from the lamp: it passes two and is mirrored last.
        assert_eq!(Chain::reversed(0b100, 3), chain);
        assert_eq!(Chain::UNTOLD.then(true), Chain::UNTOLD);
        assert_eq!((0..=Chain::MOST).fold(Chain::START, |chain, _| chain.then(true)), Chain::UNTOLD);
    }
}

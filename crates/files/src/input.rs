//! The bytes of a file as decoders take them: a reader that ends once somebody asks the work to stop.

use std::io::{self, BufRead, Cursor, Read, Seek, SeekFrom};

use iridesce_numerics::Watch;

/// Bytes handed out between two looks at the watch: a decoder spends some milliseconds on them.
const PIECE: usize = 1 << 16;

/// Elements put in place between two looks at the watch: a few milliseconds, fresh memory included.
const ELEMENTS: usize = 1 << 20;

/// The elements of a long sequence, unless the watch says stop in between: fresh memory for a map of 8192 x 8192 takes some
/// tenths of a second, whatever is written to it.
pub fn gathered<T>(mut elements: impl ExactSizeIterator<Item = T>, watch: &Watch) -> Result<Vec<T>, String> {
    let mut all = Vec::with_capacity(elements.len());
    while elements.len() > 0 {
        watch.check().map_err(|stopped| stopped.to_string())?;
        all.extend(elements.by_ref().take(ELEMENTS));
    }
    Ok(all)
}

/// A cursor that fails once the watch says so, however deep in a decoder it is.
pub struct Input<'a> {
    bytes: Cursor<&'a [u8]>,
    watch: &'a Watch,
}

impl<'a> Input<'a> {
    pub fn new(bytes: &'a [u8], watch: &'a Watch) -> Input<'a> {
        Input { bytes: Cursor::new(bytes), watch }
    }

    fn ask(&self) -> io::Result<()> {
        self.watch.check().map_err(|stopped| io::Error::other(stopped.to_string()))
    }
}

impl Read for Input<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.ask()?;
        let most = out.len().min(PIECE);
        self.bytes.read(&mut out[..most])
    }
}

impl BufRead for Input<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.ask()?;
        let rest = self.bytes.fill_buf()?;
        Ok(&rest[..rest.len().min(PIECE)])
    }

    fn consume(&mut self, amount: usize) {
        self.bytes.consume(amount);
    }
}

impl Seek for Input<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.bytes.seek(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_ends_the_gathering_in_between() {
        let watch = Watch::new();
        let mut seen = 0;
        let counted = (0..3 * ELEMENTS + 5).inspect(|&i| {
            seen += 1;
            if i == ELEMENTS + 7 {
                watch.stop();
            }
        });
        assert_eq!(gathered(counted, &watch).unwrap_err(), "stopped");
        assert_eq!(seen, 2 * ELEMENTS);
        let all = gathered(0..2 * ELEMENTS + 5, &Watch::new()).unwrap();
        assert!(all.iter().copied().eq(0..2 * ELEMENTS + 5));
    }
}

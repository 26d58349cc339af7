//! The bytes of a file as decoders take them: a reader that ends once somebody asks the work to stop.

use std::io::{self, BufRead, Cursor, Read, Seek, SeekFrom};

use iridesce_numerics::Watch;

/// Bytes handed out between two looks at the watch: a decoder spends some milliseconds on them.
const PIECE: usize = 1 << 16;

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

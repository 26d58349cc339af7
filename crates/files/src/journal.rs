//! Journals: finished pieces of long work, kept while the work goes on.
//!
//! A file of records that is only ever added to. Each record carries a mark, its key, its length and a checksum, so that a
//! file that was cut or damaged at any byte gives back every record but those that were hit: after a damaged one the next
//! mark is looked for. The first record of a journal says which work it belongs to.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use iridesce_numerics::noise::mix64;

use crate::error::FileError;
use crate::whole::write_bytes;

/// Before each record: unlikely in floats (it would be a signalling NaN beside a denormal).
const MARK: [u8; 8] = *b"\x00IRJ\xff\xf7\n\x01";
/// Key of the record that says which work it is.
const HEAD: u64 = u64::MAX;
/// Bytes around what a record holds: mark, key, length, checksum.
const AROUND: usize = 32;

/// One record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Record {
    /// Which piece of the work it is.
    pub key: u64,
    /// What it holds.
    pub bytes: Vec<u8>,
}

/// What a journal is of, and its whole records in the order they were written.
pub type Contents = (Vec<u8>, Vec<Record>);

/// A journal that is being written.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
}

impl Journal {
    /// A new journal of the work that `head` describes; one that was there is gone.
    pub fn create(path: &Path, head: &[u8]) -> Result<Journal, FileError> {
        let fail = |source| FileError::write(path, source);
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(path).map_err(fail)?;
        lock(&file).map_err(fail)?;
        file.set_len(0).map_err(fail)?;
        let mut journal = Journal { path: path.to_owned(), file };
        journal.append(HEAD, head)?;
        Ok(journal)
    }

    /// Goes on with a journal that is there (see [`Journal::read`]): what a kill left half written at its end is cut off.
    pub fn reopen(path: &Path) -> Result<Journal, FileError> {
        let fail = |source| FileError::write(path, source);
        let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(fail)?;
        lock(&file).map_err(fail)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(fail)?;
        let end = Found::new(&bytes).last().map_or(0, |(end, _)| end);
        file.set_len(end as u64).map_err(fail)?;
        file.seek(SeekFrom::End(0)).map_err(fail)?;
        Ok(Journal { path: path.to_owned(), file })
    }

    /// Adds a record. It is in the hands of the system when this returns: a kill of the program loses nothing of it.
    pub fn append(&mut self, key: u64, bytes: &[u8]) -> Result<(), FileError> {
        self.file.write_all(&framed(key, bytes)).map_err(|source| FileError::write(&self.path, source))
    }

    /// What the work at `path` is and all its whole records, in the order they were written; `None` where there is no file,
    /// or none whose first record is whole (then nothing else was ever written).
    pub fn read(path: &Path) -> Result<Option<Contents>, FileError> {
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(FileError::Argument(format!("cannot read {}: {error}", path.display()))),
        };
        let mut head = None;
        let mut records = Vec::new();
        for (_, record) in Found::new(&bytes) {
            match record.key {
                HEAD => head = head.or(Some(record.bytes)),
                _ => records.push(record),
            }
        }
        if head.is_none() && !(records.is_empty() && is_a_beginning(&bytes)) {
            return Err(FileError::Argument(format!(
                "{} is no journal of a render, or its beginning is damaged",
                path.display()
            )));
        }
        Ok(head.map(|head| (head, records)))
    }

    /// Writes a journal in one piece, or leaves the one that was there.
    pub fn write(path: &Path, head: &[u8], records: &[Record]) -> Result<(), FileError> {
        let mut all = framed(HEAD, head);
        for record in records {
            all.extend(framed(record.key, &record.bytes));
        }
        write_bytes(path, &all)
    }
}

/// One program at a time. The system takes the lock off when the program ends, however it ends.
fn lock(file: &File) -> io::Result<()> {
    match file.try_lock() {
        Err(std::fs::TryLockError::WouldBlock) => {
            Err(io::Error::new(io::ErrorKind::WouldBlock, "another render is writing this journal"))
        }
        // (Some file systems have no locks.)
        _ => Ok(()),
    }
}

/// Whether a file without a whole record is what a kill leaves of the first one.
fn is_a_beginning(bytes: &[u8]) -> bool {
    let marked = bytes.len().min(MARK.len());
    bytes[..marked] == MARK[..marked] && (bytes.len() < 16 || bytes[8..16] == HEAD.to_le_bytes())
}

fn framed(key: u64, bytes: &[u8]) -> Vec<u8> {
    let mut framed = Vec::with_capacity(bytes.len() + AROUND);
    framed.extend(MARK);
    framed.extend(key.to_le_bytes());
    framed.extend((bytes.len() as u64).to_le_bytes());
    framed.extend(checksum(key, bytes).to_le_bytes());
    framed.extend(bytes);
    framed
}

fn checksum(key: u64, bytes: &[u8]) -> u64 {
    let mut sum = mix64(key ^ mix64(bytes.len() as u64));
    for word in bytes.chunks(8) {
        let mut eight = [0; 8];
        eight[..word.len()].copy_from_slice(word);
        sum = mix64(sum ^ u64::from_le_bytes(eight));
    }
    sum
}

/// The whole records of a file, each with where it ends.
struct Found<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Found<'a> {
    fn new(bytes: &'a [u8]) -> Found<'a> {
        Found { bytes, at: 0 }
    }

    fn record(&self) -> Option<(usize, Record)> {
        let number = |from: usize| {
            Some(u64::from_le_bytes(self.bytes.get(self.at + from..self.at + from + 8)?.try_into().ok()?))
        };
        if self.bytes.get(self.at..self.at + 8)? != MARK {
            return None;
        }
        let (key, length, sum) = (number(8)?, number(16)?, number(24)?);
        let start = self.at + AROUND;
        let end = start.checked_add(usize::try_from(length).ok()?)?;
        let bytes = self.bytes.get(start..end)?;
        (checksum(key, bytes) == sum).then(|| (end, Record { key, bytes: bytes.to_vec() }))
    }
}

impl Iterator for Found<'_> {
    type Item = (usize, Record);

    fn next(&mut self) -> Option<(usize, Record)> {
        while self.at + AROUND <= self.bytes.len() {
            if let Some((end, record)) = self.record() {
                self.at = end;
                return Some((end, record));
            }
            let rest = &self.bytes[self.at + 1..];
            self.at += 1 + rest.windows(MARK.len()).position(|window| window == MARK).unwrap_or(rest.len());
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn records() -> Vec<Record> {
        (0..5).map(|key| Record { key, bytes: (0..40 + key as u8).map(|i| i * 3 + key as u8).collect() }).collect()
    }

    fn written(folder: &Path) -> (PathBuf, Vec<u8>) {
        let path = folder.join("x.exr.journal");
        let mut journal = Journal::create(&path, b"the work").unwrap();
        for record in records() {
            journal.append(record.key, &record.bytes).unwrap();
        }
        let bytes = std::fs::read(&path).unwrap();
        (path, bytes)
    }

    /// Cut anywhere, all records before the cut come back, and what is added afterwards follows them.
    #[test]
    fn a_cut_at_any_byte_loses_one_record_at_most() {
        let folder = tempfile::tempdir().unwrap();
        let (path, bytes) = written(folder.path());
        let ends: Vec<usize> = Found::new(&bytes).map(|(end, _)| end).collect();
        assert_eq!(ends.last(), Some(&bytes.len()));
        for cut in 0..=bytes.len() {
            std::fs::write(&path, &bytes[..cut]).unwrap();
            let whole = ends.iter().filter(|&&end| end <= cut).count();
            let Some((head, found)) = Journal::read(&path).unwrap() else {
                assert_eq!(whole, 0);
                continue;
            };
            assert_eq!((&head[..], found.len() + 1), (&b"the work"[..], whole), "{cut}");
            assert_eq!(found[..], records()[..whole - 1]);
            Journal::reopen(&path).unwrap().append(99, b"more").unwrap();
            let (_, found) = Journal::read(&path).unwrap().unwrap();
            assert_eq!((found.len(), found[whole - 1].key), (whole, 99));
        }
    }

    #[test]
    fn a_damaged_byte_loses_one_record() {
        let folder = tempfile::tempdir().unwrap();
        let (path, bytes) = written(folder.path());
        for at in AROUND + 8..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x40;
            std::fs::write(&path, &damaged).unwrap();
            let (head, found) = Journal::read(&path).unwrap().unwrap();
            assert_eq!((&head[..], found.len()), (&b"the work"[..], 4), "{at}");
            assert!(found.iter().all(|record| records().contains(record)));
        }
        std::fs::write(&path, b"a picture perhaps").unwrap();
        assert!(Journal::read(&path).unwrap_err().to_string().contains("no journal"));
        assert_eq!(Journal::read(&folder.path().join("none")).unwrap(), None);
    }

    #[test]
    fn one_writer_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.journal");
        let held = Journal::create(&path, b"a").unwrap();
        assert!(Journal::create(&path, b"b").unwrap_err().to_string().contains("another render"));
        drop(held);
        Journal::write(&path, b"c", &records()).unwrap();
        assert_eq!(Journal::read(&path).unwrap(), Some((b"c".to_vec(), records())));
    }
}

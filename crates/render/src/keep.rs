//! Finished tiles in a journal.

use std::time::Instant;

use iridesce_files::{Journal, Record};

use crate::framebuffer::{KeepOptions, RenderError};
use crate::tile_sums::TileSums;
use crate::tiles::Rect;

/// Writes finished tiles down; what is finished before its time to begin waits in memory.
pub struct Keeper<'a> {
    options: &'a KeepOptions,
    start: Instant,
    journal: Option<Journal>,
    waiting: Vec<Record>,
}

impl<'a> Keeper<'a> {
    /// Takes over what the journal holds: tiles by their numbers, the last of each; the rest is to be drawn.
    pub fn new(
        options: &'a KeepOptions,
        start: Instant,
        tiles: &[Rect],
        extras: usize,
    ) -> Result<(Self, Found), RenderError> {
        let mut keeper = Keeper { options, start, journal: None, waiting: Vec::new() };
        let mut found: Found = tiles.iter().map(|_| None).collect();
        if options.resume
            && let Some((head, records)) = Journal::read(&options.path)?
        {
            if head != options.head {
                let path = options.path.display();
                return Err(RenderError::Argument(format!("{path} is the journal of another render")));
            }
            for record in records {
                let number = usize::try_from(record.key).unwrap_or(usize::MAX);
                if let (Some(tile), Some(slot)) = (tiles.get(number), found.get_mut(number)) {
                    *slot = TileSums::from_bytes(&record.bytes, *tile, extras).or(slot.take());
                }
            }
            keeper.journal = Some(Journal::reopen(&options.path)?);
        }
        Ok((keeper, found))
    }

    /// A tile is finished.
    pub fn add(&mut self, number: usize, sums: &TileSums) -> Result<(), RenderError> {
        let bytes = sums.to_bytes();
        if let Some(journal) = &mut self.journal {
            journal.append(number as u64, &bytes)?;
            return Ok(());
        }
        self.waiting.push(Record { key: number as u64, bytes });
        if self.start.elapsed().as_secs_f64() >= self.options.after_s {
            let mut journal = Journal::create(&self.options.path, &self.options.head)?;
            for record in std::mem::take(&mut self.waiting) {
                journal.append(record.key, &record.bytes)?;
            }
            self.journal = Some(journal);
        }
        Ok(())
    }

    /// All tiles have had a pass: the journal is written anew, whole, once it is time for one.
    pub fn replace(&mut self, tiles: &[(usize, Rect, TileSums)]) -> Result<(), RenderError> {
        if self.start.elapsed().as_secs_f64() >= self.options.after_s {
            let record =
                |(number, _, sums): &(usize, Rect, TileSums)| Record { key: *number as u64, bytes: sums.to_bytes() };
            // (The lock on the file that is replaced goes with it.)
            self.journal = None;
            let records: Vec<Record> = tiles.iter().map(record).collect();
            Journal::write(&self.options.path, &self.options.head, &records)?;
        }
        Ok(())
    }
}

/// What a journal knows of each tile.
pub type Found = Vec<Option<TileSums>>;

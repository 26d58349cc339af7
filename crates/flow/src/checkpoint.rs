//! A run as bytes, to go on from later to the same bytes.
//!
//! Little endian: a mark, the parameters with their names, the state, and a check of all that (FNV-1a, 64 bits).

use crate::events::{Clock, Spot};
use crate::film::{Books, Film, FlowError, State};
use crate::grid::Grid;
use crate::parameters::Parameters;

const MARK: &[u8; 8] = b"irflow2\n";

impl Film {
    /// The run as bytes; [`Film::resume`] reads them.
    pub fn checkpoint(&self) -> Vec<u8> {
        let state = self.state();
        let mut out = MARK.to_vec();
        let listed = self.parameters().listed();
        whole(&mut out, listed.len() as u64);
        for (name, value) in listed {
            whole(&mut out, name.len() as u64);
            out.extend_from_slice(name.as_bytes());
            whole(&mut out, value.to_bits());
        }
        whole(&mut out, state.step);
        let books = state.books;
        let ruptured = state.ruptured_s.unwrap_or(f64::NAN);
        let numbers = [
            state.time_s,
            books.start,
            books.evaporated,
            books.swallowed,
            books.blackened,
            books.drained,
            state.surfactant,
            ruptured,
        ];
        numbers.iter().for_each(|value| whole(&mut out, value.to_bits()));
        for clock in [state.patch_clock, state.spot_clock] {
            whole(&mut out, clock.number);
            whole(&mut out, clock.passed.to_bits());
            whole(&mut out, clock.next.to_bits());
        }
        for spots in [&state.patches, &state.spots] {
            whole(&mut out, spots.len() as u64);
            for spot in spots {
                let [x, y, z] = spot.place;
                [x, y, z, spot.radius, spot.from, spot.ratio].iter().for_each(|value| whole(&mut out, value.to_bits()));
            }
        }
        for field in [&state.h, &state.s, &state.down, &state.across, &state.q] {
            field.iter().for_each(|value| out.extend_from_slice(&value.to_le_bytes()));
        }
        let check = fnv(&out);
        whole(&mut out, check);
        out
    }

    /// Goes on from a checkpoint of the same parameters.
    pub fn resume(parameters: Parameters, bytes: &[u8]) -> Result<Film, FlowError> {
        parameters.check()?;
        let wrong = |why: &str| FlowError::Checkpoint(why.to_string());
        if !bytes.starts_with(MARK) {
            return Err(wrong("is not one of iridesce, or of another version"));
        }
        let short = || wrong("is cut short or damaged");
        let body = bytes.len().checked_sub(8).ok_or_else(short)?;
        let mut reader = Reader { bytes: &bytes[..body], at: MARK.len() };
        let check = Reader { bytes, at: body }.whole().ok_or_else(short)?;
        if fnv(&bytes[..body]) != check {
            return Err(short());
        }
        let film = (|| {
            let mut given = Vec::new();
            for _ in 0..reader.whole()? {
                let length = reader.whole()? as usize;
                let name = String::from_utf8(reader.take(length)?.to_vec()).ok()?;
                given.push((name, reader.number()?));
            }
            Some(given)
        })();
        let given = film.ok_or_else(short)?;
        let asked = parameters.listed();
        for ((name, value), (asked_name, asked_value)) in given.iter().zip(&asked) {
            if name != asked_name || value.to_bits() != asked_value.to_bits() {
                let shown = |name: &str, value: f64| match name {
                    "seed" => format!("seed {}", value.to_bits()),
                    _ => format!("{name} {value:?}"),
                };
                return Err(FlowError::Checkpoint(format!(
                    "is of a run with {}, not {}",
                    shown(name, *value),
                    shown(asked_name, *asked_value)
                )));
            }
        }
        if given.len() != asked.len() {
            return Err(wrong("is of another version"));
        }
        let state = read_state(&mut reader, &parameters).ok_or_else(short)?;
        if reader.at != body {
            return Err(short());
        }
        Ok(Film::from_state(parameters, state))
    }
}

fn read_state(reader: &mut Reader<'_>, parameters: &Parameters) -> Option<State> {
    let grid = Grid::new(parameters.shape, parameters.columns, parameters.rows);
    let cells = grid.cells();
    let step = reader.whole()?;
    let mut next = || reader.number();
    let time_s = next()?;
    let (start, evaporated, swallowed) = (next()?, next()?, next()?);
    let books = Books { start, evaporated, swallowed, blackened: next()?, drained: next()? };
    let (surfactant, ruptured) = (next()?, next()?);
    let patch_clock = Clock { number: reader.whole()?, passed: reader.number()?, next: reader.number()? };
    let spot_clock = Clock { number: reader.whole()?, passed: reader.number()?, next: reader.number()? };
    let (patches, spots) = (reader.spots()?, reader.spots()?);
    let (h, s) = (reader.field(cells)?, reader.field(cells)?);
    let down = reader.field(cells + grid.columns)?;
    let (across, q) = (reader.field(cells)?, reader.field(cells)?);
    let ruptured_s = (!ruptured.is_nan()).then_some(ruptured);
    Some(State {
        h,
        s,
        down,
        across,
        q,
        step,
        time_s,
        books,
        surfactant,
        patch_clock,
        spot_clock,
        patches,
        spots,
        ruptured_s,
    })
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let part = self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(part)
    }

    fn whole(&mut self) -> Option<u64> {
        self.take(8)?.try_into().ok().map(u64::from_le_bytes)
    }

    fn number(&mut self) -> Option<f64> {
        self.whole().map(f64::from_bits)
    }

    fn field(&mut self, count: usize) -> Option<Vec<f64>> {
        let (numbers, _) = self.take(count.checked_mul(8)?)?.as_chunks::<8>();
        Some(numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
    }

    fn spots(&mut self) -> Option<Vec<Spot>> {
        let count = self.whole()?;
        (0..count)
            .map(|_| {
                let place = [self.number()?, self.number()?, self.number()?];
                Some(Spot { place, radius: self.number()?, from: self.number()?, ratio: self.number()? })
            })
            .collect()
    }
}

fn whole(out: &mut Vec<u8>, value: u64) {
    out.extend_from_slice(&value.to_le_bytes());
}

fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

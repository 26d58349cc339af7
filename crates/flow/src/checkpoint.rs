//! A run as bytes, to go on from later to the same bytes.
//!
//! Little endian: a mark, the parameters with their names, the state, and a check of all that (FNV-1a, 64 bits).

use crate::error::FlowError;
use crate::events::{Clock, Spot};
use crate::film::{Books, Film, Memory, State};
use crate::grid::{Grid, Shape};
use crate::parameters::Parameters;

const MARK: &[u8; 8] = b"irflow5\n";
/// Longest run, s: a lifetime.
const MOST_SECONDS: f64 = 1e9;
/// Most events of a kind: more than any run of that length has.
const MOST_EVENTS: u64 = 1 << 53;

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
        for clock in [state.patch_clock, state.spot_clock, state.rupture_clock] {
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
        whole(&mut out, u64::from(!state.black.is_empty()));
        state.black.iter().for_each(|value| out.extend_from_slice(&value.to_le_bytes()));
        whole(&mut out, u64::from(state.memory.is_some()));
        if let Some(memory) = &state.memory {
            whole(&mut out, memory.dt.to_bits());
            for (_, field) in memory.fields() {
                field.iter().for_each(|value| out.extend_from_slice(&value.to_le_bytes()));
            }
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
                    // A torn checkpoint holds any bytes: none of them may reach a terminal raw.
                    _ => format!("{} {value:?}", name.escape_debug()),
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
        // A right sum says that nothing was damaged, not that a run ever was like this.
        if let Some(what) = impossible(&state, &parameters) {
            return Err(FlowError::Checkpoint(format!("cannot be: {what}")));
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
    let rupture_clock = Clock { number: reader.whole()?, passed: reader.number()?, next: reader.number()? };
    let (patches, spots) = (reader.spots()?, reader.spots()?);
    let (h, s) = (reader.field(cells)?, reader.field(cells)?);
    let down = reader.field(cells + grid.columns)?;
    let (across, q) = (reader.field(cells)?, reader.field(cells)?);
    let ruptured_s = (!ruptured.is_nan()).then_some(ruptured);
    let black = match reader.whole()? {
        0 => Vec::new(),
        1 => reader.field(cells)?,
        _ => return None,
    };
    let memory = match reader.whole()? {
        0 => None,
        1 => Some(Memory {
            dt: reader.number()?,
            down: reader.field(cells + grid.columns)?,
            across: reader.field(cells)?,
            push_down: reader.field(cells + grid.columns)?,
            push_across: reader.field(cells)?,
            push_s: reader.field(cells)?,
        }),
        _ => return None,
    };
    Some(State {
        h,
        black,
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
        rupture_clock,
        patches,
        spots,
        ruptured_s,
        memory,
    })
}

/// What no run can have come to, if there is such a thing.
fn impossible(state: &State, parameters: &Parameters) -> Option<String> {
    if !(0.0..=MOST_SECONDS).contains(&state.time_s) {
        return told("its time in s", state.time_s, "from 0 to 1e9 is possible");
    }
    if let Some(ruptured_s) = state.ruptured_s.filter(|s| !(0.0..=MOST_SECONDS).contains(s)) {
        return told("the time of its rupture in s", ruptured_s, "from 0 to 1e9 is possible");
    }
    impossible_books(state).or_else(|| impossible_events(state, parameters)).or_else(|| impossible_fields(state))
}

fn told(what: &str, value: f64, allowed: &str) -> Option<String> {
    Some(format!("{what} is {value:?}; {allowed}"))
}

fn impossible_books(state: &State) -> Option<String> {
    let Books { start, evaporated, swallowed, blackened, drained } = state.books;
    for (what, value) in [("start", start), ("evaporated", evaporated), ("swallowed", swallowed), ("drained", drained)]
    {
        if !(value.is_finite() && value >= 0.0) {
            return told(&format!("the volume {what}, in m3,"), value, "a finite number >= 0 is possible");
        }
    }
    // Liquid that a spot frees may come back: its account may be a rounding below zero.
    if !blackened.is_finite() {
        return told("the volume blackened, in m3,", blackened, "a finite number is possible");
    }
    if !(state.surfactant.is_finite() && state.surfactant > 0.0) {
        return told("its surfactant", state.surfactant, "a finite number > 0 is possible");
    }
    None
}

fn impossible_events(state: &State, parameters: &Parameters) -> Option<String> {
    for (name, clock) in
        [("patches", state.patch_clock), ("black spots", state.spot_clock), ("ruptures", state.rupture_clock)]
    {
        let Clock { passed, next, number } = clock;
        if !(passed.is_finite() && passed >= 0.0) {
            return told(&format!("the clock of its {name}"), passed, "a finite number >= 0 is possible");
        }
        // An exponential draw is less than 40: 53 bits have no smaller share than 2^-53.
        if !(next.is_finite() && next >= passed && next - passed <= 40.0) {
            return told(&format!("the next of its {name}"), next, &format!("{passed:?} to 40 more is possible"));
        }
        if number > MOST_EVENTS {
            return told(&format!("the number of its {name}"), number as f64, "it is more than there can have been");
        }
    }
    for (name, spots) in [("patches", &state.patches), ("black spots", &state.spots)] {
        if let Some(spot) = spots.iter().find(|spot| !is_possible(spot, parameters)) {
            return Some(format!(
                "one of its {name} is at {:?}, {:?} m wide, since {:?} s",
                spot.place, spot.radius, spot.from
            ));
        }
    }
    None
}

fn is_possible(spot: &Spot, parameters: &Parameters) -> bool {
    let [x, y, z] = spot.place;
    let numbers = [x, y, z, spot.radius, spot.from, spot.ratio];
    numbers.iter().all(|value| value.is_finite())
        && spot.radius > 0.0
        && (0.0..=MOST_SECONDS).contains(&spot.from)
        && (0.0..1.0).contains(&spot.ratio)
        && match parameters.shape {
            Shape::Sphere { radius_m, .. } => {
                (x * x + y * y + z * z - 1.0).abs() < 1e-6 && spot.radius <= 4.0 * radius_m
            }
            Shape::Plane { width_m, height_m, .. } => {
                x.abs() <= 2.0 * width_m && z.abs() <= 2.0 * height_m && spot.radius <= width_m + height_m
            }
        }
}

fn impossible_fields(state: &State) -> Option<String> {
    if let Some(memory) = state.memory.as_ref().filter(|memory| !(memory.dt > 0.0 && memory.dt.is_finite())) {
        return told("the length of its last step, in s,", memory.dt, "a finite number > 0 is possible");
    }
    let fields = [
        ("thickness", &state.h),
        ("surfactant", &state.s),
        ("velocity down", &state.down),
        ("velocity across", &state.across),
        ("tension", &state.q),
    ];
    for (name, values) in fields.into_iter().chain(state.memory.iter().flat_map(Memory::fields)) {
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            return told(&format!("the {name} of cell {at}"), values[at], "a finite number is possible");
        }
    }
    if let Some(at) = state.black.iter().position(|share| !(0.0..=1.0).contains(share)) {
        return told(&format!("the black share of cell {at}"), state.black[at], "0 to 1 is possible");
    }
    let at = state.h.iter().position(|h| *h < 0.0)?;
    told(&format!("the thickness of cell {at}, in m,"), state.h[at], "a number >= 0 is possible")
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
        // As many as the bytes that are left can hold, whatever is claimed.
        if count > (self.bytes.len() - self.at) as u64 / 48 {
            return None;
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A checkpoint of a small film whose numbers are changed, with its sum made right again.
    fn changed(change: impl FnOnce(&mut State)) -> Result<Film, FlowError> {
        let mut parameters = Parameters::preset("late").unwrap().with_columns(64);
        (parameters.regeneration, parameters.time_order) = (0.0, 2.0);
        let mut film = Film::new(parameters.clone()).unwrap();
        film.advance_to(0.01).unwrap();
        let mut state = film.state().clone();
        change(&mut state);
        Film::resume(parameters.clone(), &Film::from_state(parameters, state).checkpoint())
    }

    #[test]
    fn numbers_that_no_run_can_have_are_refused_by_name() {
        assert!(changed(|_| {}).is_ok());
        let refused = |change: &dyn Fn(&mut State), part: &str| {
            let error = changed(change).err().unwrap_or_else(|| panic!("{part} was believed"));
            assert!(error.to_string().contains(part), "{part}: {error}");
        };
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            refused(&|state| state.time_s = bad, "its time");
            refused(&|state| state.books.evaporated = bad, "evaporated");
            refused(&|state| state.books.start = bad, "start");
            refused(&|state| state.surfactant = bad, "its surfactant");
            refused(&|state| state.patch_clock.passed = bad, "clock of its patches");
            refused(&|state| state.spot_clock.next = bad, "next of its black spots");
            refused(&|state| state.h[7] = bad, "thickness of cell 7");
            let share = |state: &mut State| {
                state.black = vec![0.5; state.h.len()];
                state.black[9] = bad;
            };
            refused(&share, "black share of cell 9");
        }
        refused(&|state| state.ruptured_s = Some(-3.0), "rupture");
        refused(&|state| state.patch_clock.next = -1e18, "next of its patches is -1e18");
        refused(&|state| state.spot_clock.next += 50.0, "next of its black spots");
        refused(&|state| state.patch_clock.passed = 1e300, "next of its patches");
        refused(&|state| state.rupture_clock.next = -1.0, "next of its ruptures");
        refused(&|state| state.spot_clock.number = u64::MAX, "number of its black spots");
        refused(&|state| state.q[3] = f64::NAN, "tension of cell 3");
        refused(&|state| state.down[0] = f64::INFINITY, "velocity down");
        refused(&|state| state.memory.as_mut().unwrap().dt = 0.0, "length of its last step");
        refused(&|state| state.memory.as_mut().unwrap().push_s[5] = f64::NAN, "strain of the surfactant of cell 5");
        let spot = Spot { place: [0.0, 0.0, 1.0], radius: 1e-3, from: 0.0, ratio: 0.0 };
        assert!(changed(|state| state.spots.push(spot)).is_ok());
        for bad in [
            Spot { place: [0.0; 3], ..spot },
            Spot { place: [f64::NAN, 0.0, 1.0], ..spot },
            Spot { radius: 0.0, ..spot },
            Spot { radius: 1.0, ..spot },
            Spot { from: -1e9, ..spot },
            Spot { ratio: 2.0, ..spot },
        ] {
            refused(&|state| state.spots.push(bad), "one of its black spots");
        }
    }
}

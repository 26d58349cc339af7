//! Many stacks of one build, in full size: row `i` of every array belongs to element `i`.

use iridesce::numerics::Watch;
use iridesce::optics::incidence::Incidence;
use iridesce::optics::stack;
use iridesce::optics::{Complex64, OpticsError};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::interrupt::{Long, beside, released};

/// Layers and numbers written, over all elements of a task: a millisecond. Fewer are not worth another thread.
const SHORT: usize = 1 << 13;

/// Many stacks of the same build.
pub struct Elements<'a> {
    /// (elements, media)
    pub indices: &'a [Complex64],
    /// (elements, layers)
    pub thickness_nm: &'a [f64],
    /// (layers,)
    pub coherent: &'a [bool],
    /// (elements,)
    pub wavelength_nm: &'a [f64],
    /// (elements,)
    pub angle_deg: &'a [f64],
}

/// One of them.
pub struct Element<'a> {
    pub indices: &'a [Complex64],
    pub thickness_nm: &'a [f64],
    pub wavelength_nm: f64,
    pub incidence: Incidence,
}

impl<'a> Elements<'a> {
    fn check(&self) -> Result<()> {
        let (count, layers) = (self.wavelength_nm.len(), self.coherent.len());
        let fits = self.angle_deg.len() == count
            && self.indices.len() == count * (layers + 2)
            && self.thickness_nm.len() == count * layers;
        if fits { Ok(()) } else { Err(Error::value("the arrays do not belong together")) }
    }

    fn at(&self, element: usize) -> std::result::Result<Element<'a>, OpticsError> {
        let layers = self.coherent.len();
        let indices = &self.indices[element * (layers + 2)..][..layers + 2];
        let thickness_nm = &self.thickness_nm[element * layers..][..layers];
        let wavelength_nm = self.wavelength_nm[element];
        stack::check(indices, thickness_nm, self.coherent, wavelength_nm)
            .map_err(|error| error.at(&format!("(at wavelength_nm = {wavelength_nm})")))?;
        let incidence = Incidence::from_degrees(self.angle_deg[element])?;
        Ok(Element { indices, thickness_nm, wavelength_nm, incidence })
    }

    /// Fills rows of `first` and `second`, `widths` numbers an element each, on all cores.
    pub fn fill<A: Send, B: Send>(
        &self,
        py: Python<'_>,
        widths: [usize; 2],
        first: &mut [A],
        second: &mut [B],
        each: impl Fn(&Element<'a>, &mut [A], &mut [B], &Watch) -> std::result::Result<(), OpticsError> + Sync,
    ) -> Result<()> {
        self.check()?;
        let count = self.wavelength_nm.len();
        if first.len() != count * widths[0] || second.len() != count * widths[1] {
            return Err(Error::value("the output does not have the shape of the result"));
        }
        let run = |start: usize, first: &mut [A], second: &mut [B], watch: &Watch| {
            let rows = first.chunks_exact_mut(widths[0]).zip(second.chunks_exact_mut(widths[1])).enumerate();
            for (i, (a, b)) in rows {
                each(&self.at(start + i)?, a, b, watch)?;
            }
            Ok(())
        };
        let work = self.coherent.len() + widths[0] + widths[1];
        if count * work <= SHORT {
            return Ok(released(py, || run(0, first, second, &Watch::new()))?);
        }
        let task = (SHORT / work).max(1);
        let done: std::result::Result<(), OpticsError> = beside(py, Long::default(), |watch| {
            first
                .par_chunks_mut(task * widths[0])
                .zip(second.par_chunks_mut(task * widths[1]))
                .enumerate()
                .try_for_each(
                    |(number, (a, b))| if watch.is_stopped() { Ok(()) } else { run(number * task, a, b, watch) },
                )
        })?;
        Ok(done?)
    }
}

"""Thicknesses that could be: every minimum of the misfit, gain and baseline as stiff as they are told to be. Internal.

These are where the posterior is looked at; what each is worth is decided there.
"""

from __future__ import annotations

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.inverse.model import GeneralModel, HarmonicModel, Model, Problem, harmonics, uneven
from iridesce.inverse.search import Start, starts
from iridesce.inverse.solve import Data, Fitted, Solver
from iridesce.optics.averages import FWHM

_STARTS = 24
_FIRST_STEPS = 8
_SOME_LINE_NM = 0.5  # sd of the line with which its search starts
# Free blur is taken in where it lowers the misfit by this many variances: by chance, one time in seventy.
_WORTH_BLUR = 6.0
WIDEST_LINE_NM = 25.0


def model_of(problem: Problem, wavelength_nm: Floats) -> Model:
    """The quickest model that holds for a problem."""
    of = harmonics(problem, wavelength_nm)
    return HarmonicModel(of) if of is not None else GeneralModel(problem, wavelength_nm)


class Search:
    """One search with one shape of gain and baseline."""

    def __init__(
        self,
        problem: Problem,
        model: Model,
        data: Data,
        line: float | None,
        bounds: Floats,
        tried_nm: tuple[float, ...] = (0.6, 1.7),
    ) -> None:
        self.problem, self.model, self.data = problem, model, data
        self.line, self.bounds, self.tried_nm = line, bounds, tried_nm
        self.unknown = len(problem.unknown)

    def limits(self) -> tuple[Floats, Floats]:
        """Bounds of the parameters."""
        low, high = list(self.bounds[:, 0]), list(self.bounds[:, 1])
        for model in self.problem.index:
            low += [] if model is None else [1.0]
            high += [] if model is None else [6.0]
            low += [-0.05] if model == "cauchy" else []
            high += [0.3] if model == "cauchy" else []
        widest = max(WIDEST_LINE_NM / FWHM, self.line or 0.0)
        return np.array([*low, 0.0]), np.array([*high, widest**2])

    def solver(self) -> Solver:
        """Least squares of this shape."""
        return Solver(self.model, self.data, *self.limits())

    def _lines(self) -> list[float]:
        """Widths of the line (sd) worth trying in the search."""
        if self.line is not None:
            return [self.line]
        thickest = float(self.bounds[:, 1].max())
        nm = self.data.wavelength_nm
        # The width at which the finest fringe is all but gone.
        gone = 2.5 * nm[0] ** 2 / (4.0 * np.pi * 1.4 * thickest)
        return [0.0] + [sd for sd in self.tried_nm if sd > 0.2 * gone]

    def candidates(self) -> list[Fitted]:
        """All minima, best first; none where the baseline alone does as well."""
        found = starts(self.problem, self.model, self.data, self.bounds, self._lines(), _STARTS)
        solver = self.solver()
        index = self.model.start_index() if isinstance(self.model, GeneralModel) else np.empty(0)
        tried = []
        for thickness, line in found:
            for moved in self._index_starts(index):
                scale = 1.0 if not moved.size else index[0] / moved[0]
                tried.append(solver.at(np.array([*(thickness * scale), *moved, line**2])))
        # A few steps each tell which can win; these are refined to the end.
        tried.sort(key=lambda one: one.misfit)
        sharp = list(range(len(tried[0].parameters) - 1))
        quick = self._quick_solver(solver, found)
        rough = self.unique([quick.solve(one.parameters, sharp, _FIRST_STEPS) for one in tried[:_STARTS]])
        if not rough:
            return []
        refined = [self.refined(solver, one.parameters) for one in rough[:2]]
        least = min(one.misfit for one in refined)
        refined += [self.refined(solver, one.parameters) for one in rough[2:] if one.misfit < 3.0 * least]
        return self.unique(refined)

    def _quick_solver(self, solver: Solver, found: list[Start]) -> Solver:
        """For first steps with a costly model: fewer points, as long as they show the fringes."""
        nm = self.data.wavelength_nm
        if isinstance(self.model, HarmonicModel) or nm.size < 300:
            return solver
        thickest = max(float(thickness.sum()) for thickness, _ in found)
        finest = nm[0] ** 2 / (8.0 * max(thickest, 1.0)) / float(np.median(np.diff(nm)))
        step = int(min(nm.size // 150, max(1.0, finest / 4.0)))
        data = self.data.thinned(step)
        return Solver(GeneralModel(self.problem, data.wavelength_nm), data, *self.limits())

    def _index_starts(self, index: Floats) -> list[Floats]:
        if not index.size:
            return [index]
        shifts = []
        for step in (0.0, -0.12, 0.12):
            moved = index.copy()
            at = 0
            for model in self.problem.index:
                if model is not None:
                    moved[at] += step
                    at += 1 if model == "constant" else 2
            shifts.append(moved)
        return shifts

    def refined(self, solver: Solver, start: Floats) -> Fitted:
        """All parameters but the blur, then the blur too where the data ask for it."""
        last = len(start) - 1
        sharp = list(range(last))
        if self.line is not None:
            return solver.solve(start, sharp)
        best = solver.solve(np.array([*start[:-1], max(start[-1], _SOME_LINE_NM**2)]), [*sharp, last])
        freedom = max(self.data.wavelength_nm.size - len(start) - self.data.linear_count, 1)
        worth = _WORTH_BLUR * best.misfit / freedom
        zero = solver.solve(np.array([*best.parameters[:-1], 0.0]), sharp)
        return best if zero.misfit - best.misfit > worth else zero

    def unique(self, found: list[Fitted]) -> list[Fitted]:
        """One of each minimum, best first."""
        kept: list[Fitted] = []
        for one in sorted(found, key=lambda one: one.misfit):
            if not np.isfinite(one.misfit) or one.gain[0] <= 0.0:
                continue
            if all(self._apart(one, other) for other in kept):
                kept.append(one)
        return kept

    def _apart(self, one: Fitted, other: Fitted) -> bool:
        by = np.abs(one.parameters - other.parameters)[:-1]
        return bool(by[: self.unknown].max() > 0.5 or by[self.unknown :].max(initial=0.0) > 0.02)

    def free(self, fitted: Fitted) -> list[int]:
        """Which parameters were free to move."""
        last = len(fitted.parameters) - 1
        low, high = self.limits()
        blurred = self.line is None and low[-1] < fitted.parameters[-1] < high[-1]
        return [*range(last), *([last] if blurred else [])]


def paled(search: Search, by_line: Model, start: Floats) -> list[tuple[Model, Floats]]:
    """The same film with a thickness that is uneven over the spot instead of a line, where something pales its fringes.

    None where the search was for an uneven film from the start: its model is not that of a line.
    """
    if search.line is not None or start[-1] <= 0.0 or not isinstance(by_line, HarmonicModel):
        return []
    if search.model is not by_line:
        return []
    model = HarmonicModel(uneven(by_line.of, search.data.wavelength_nm))
    fitted = Solver(model, search.data, *search.limits()).solve(start, [0, 1])
    return [(model, fitted.parameters)] if abs(fitted.parameters[0] - start[0]) < 3.0 else []

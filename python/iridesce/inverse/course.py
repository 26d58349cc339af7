"""A series of spectra of one film: the lamp learnt from all of them, the thickness as a path with jumps. Internal.

For the spectrum t and a film of thickness h

    y_t(l) = g_t c(l) (1 + sum_j a_j p_j(l)) R(l, h) + s_t c(l) + noise,

the lamp c common to all, g_t, a_j (smooth changes p_j of a few per cent) and stray light s_t integrated out in closed form
for each t. Few thicknesses explain a spectrum: these candidates, refined, and "no film" are the states of a chain over time.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from iridesce._interrupts import heard
from iridesce.arguments.operands import Floats
from iridesce.inverse.candidates import model_of
from iridesce.inverse.model import HarmonicModel, Problem, by_index, quarter_wave_nm
from iridesce.inverse.posterior import PRIOR_FILM, PRIOR_NONE, prior_density, temper
from iridesce.inverse.search import round_trip_rate
from iridesce.inverse.spectrum_light import LEVEL, Found, Light, least_of, size_of_light

# Phase of a step of the grid of thicknesses, radians.
_STEP = 0.3
# How far a lamp that nobody has divided out may bend, over which length; and one that is known, or learnt.
_WIDE = (0.3, 30.0)
_KNOWN = (0.03, 80.0)
_LEARNT = (0.02, 80.0)
# The lamp itself is learnt as finely as this.
_LAMP = (0.3, 14.0)
# and as truly: curves of 3e-5 of it are left out.
_LEAST_OF_A_LAMP = 1e-8
_STRAY = 0.3
# Candidates within so many units of the logarithm, at most so many.
_FAR, _MOST = 30.0, 8
# A jump that no drift explains has this probability a step; jumps go anywhere.
_JUMP = 0.01
_CLEAR = 0.95
# Spectra of fewer fringes do not teach the lamp: it could have made them.
_TEACHING_FRINGES = 2.5
_LEAST_TEACHERS = 5
# Films of fewer fringes show how large the index is, besides n h; none moves by more than so many times the share it is off by.
_THIN_FRINGES, _STEEPEST = 1.5, 10.0
_PASS = 1 << 21
# Steps towards the top of a candidate, each a third of the last: 8 nm to 0.1 pm.
_TURNS = 16
_LAMP_TURNS = 6


class Course:
    """All spectra against one stack."""

    def __init__(
        self,
        problem: Problem,
        wavelength_nm: Floats,
        spectra: Floats,
        sd: Floats,
        light: Light,
        bounds: tuple[float, float],
        line_nm: float,
    ) -> None:
        self.problem, self.nm, self.y, self.sd = problem, wavelength_nm, spectra, sd
        self.light, self.bounds, self.line = light, bounds, line_nm
        self.model = model_of(problem, wavelength_nm)
        self.rate = round_trip_rate(problem, wavelength_nm, 0)
        low, high = bounds
        count = max(3, math.ceil((high - low) * float(self.rate.max()) / _STEP) + 1)
        self.grid = np.linspace(low, high, count)
        self.on_grid = self.films(self.grid)
        self.mean = max(float(self.on_grid.mean()), 1e-9)
        self.tempered, self.learnt = 1.0, False
        # The size of a spectrum under a learnt lamp, and by how much it varies, relative.
        self.size: tuple[float, float] | None = None
        # What is not known of a learnt lamp, of itself: independent curves of size 1 sd, (wavelengths, curves).
        self.lamp_unknown = np.zeros((wavelength_nm.size, 0))
        # Below this, noise is the rounding of the models.
        self.least_sd = 1e-300
        if light.lamp is not None:
            self.lamp, self.bend = light.lamp, _KNOWN
        else:
            self.lamp, self.bend = self._smooth_lamp(), _WIDE
        self.rate_of_change = 20.0

    def films(self, h: Floats) -> Floats:
        """Spectra of films, (thicknesses, wavelengths)."""
        if isinstance(self.model, HarmonicModel):
            return self.model.many(h, self.line**2)
        stack = self.problem.with_thickness([h[:, None]])
        return np.asarray(
            getattr(stack, self.problem.quantity)(self.nm, self.problem.angle_deg, self.problem.polarization)
        )

    def _smooth_lamp(self) -> Floats:
        """The course of the mean spectrum over the mean film: a start that has no fringes in it."""
        x = (2.0 * self.nm - self.nm[0] - self.nm[-1]) / (self.nm[-1] - self.nm[0])
        basis = np.polynomial.chebyshev.chebvander(x, 6)
        mean = np.maximum(self.y, 0.0).mean(axis=0) / self.on_grid.mean(axis=0)
        course = basis @ np.linalg.lstsq(basis, mean, rcond=None)[0]
        return np.asarray(np.maximum(course, 0.05 * max(float(course.max()), 1e-300)))

    # --- evidence

    def _columns(self, bend: tuple[float, float], least: float = 1e-4) -> Floats:
        """1 and the smooth changes of the lamp, (wavelengths, columns), each of its own size; `least`: variance left out."""
        size, length = bend
        away = (self.nm[:, None] - self.nm[None, :]) / length
        # (Two seconds for 2 000 wavelengths.)
        values, vectors = heard(np.linalg.eigh, np.exp(-0.5 * away * away))
        kept = values > least * values[-1]
        level = _KNOWN[0] if self.light.gain is not None else LEVEL if self.size is None else self.size[1]
        return np.column_stack([np.full(self.nm.size, level), size * vectors[:, kept] * np.sqrt(values[kept])])

    def _gain(self) -> float:
        """The gain that is expected of a spectrum of mean size."""
        if self.light.gain is not None:
            return self.light.gain
        if self.size is not None:
            return self.size[0]
        weight = 1.0 / self.sd**2
        size = np.median(self.y @ (weight * self.lamp)) / max(float(weight @ (self.lamp * self.lamp)), 1e-300)
        return max(float(size) / self.mean, 1e-300)

    def _design(self, films: Floats, gain: float) -> tuple[Floats, Floats]:
        """For films: columns over the noise, (films, columns, wavelengths), and the mean over the noise."""
        changes = self.changes.T
        columns = films[:, None, :] * (gain * self.lamp / self.sd * changes)[None]
        if self.light.stray:
            stray = gain * _STRAY * self.mean * self.lamp / self.sd
            columns = np.concatenate([columns, np.broadcast_to(stray, (len(films), 1, self.nm.size))], axis=1)
        mean = films * (gain * self.lamp / self.sd)
        return columns, mean

    def _costs(self, films: Floats, y: Floats, gain: float) -> tuple[Floats, Floats]:
        """What is left of each spectrum (rows of y over the noise) under each film, squared, and log det M / 2."""
        columns, mean = self._design(films, gain)
        normal = columns @ columns.transpose(0, 2, 1)
        size = normal.shape[1]
        normal[:, range(size), range(size)] += 1.0
        factor = np.linalg.cholesky(normal)
        # C^-1 B^T, so that each spectrum costs products alone.
        whitened = np.linalg.solve(factor, columns)
        volume = np.log(factor[:, range(size), range(size)]).sum(axis=1)
        # |y - m|^2 - |C^-1 B^T (y - m)|^2
        cost = (y * y).sum(axis=1)[:, None] - 2.0 * y @ mean.T + (mean * mean).sum(axis=1)[None, :]
        flat = whitened.reshape(-1, self.nm.size)
        shift = np.einsum("fcn,fn->fc", whitened, mean)
        for start in range(0, len(y), 512):
            part = (y[start : start + 512] @ flat.T).reshape(-1, len(films), size) - shift[None]
            cost[start : start + 512] -= (part * part).sum(axis=2)
        return np.maximum(cost, 0.0), volume

    def candidates(self) -> Found:
        """For each spectrum the films that may explain it."""
        self.changes = self._columns(self.bend)
        gain = self._gain()
        y = self.y / self.sd
        count = len(y)
        cost, volume = np.empty((count, self.grid.size)), np.empty(self.grid.size)
        step = max(1, _PASS // (self.nm.size * (self.changes.shape[1] + 1)))
        for start in range(0, self.grid.size, step):
            part = slice(start, start + step)
            cost[:, part], volume[part] = self._costs(self.on_grid[part], y, gain)
        ones = [np.ones((1, self.nm.size))]
        bare = self.films(np.zeros(1))
        if float(bare.max()) > 1e-6:
            ones.append(bare)
        # No film: lamp light of any size, and the bare base.
        sizes = [gain * self.mean * 10.0 ** (0.5 * power) for power in range(-4, 3)]
        own = self.changes
        if self.light.gain is None:
            # How large a film's light is says nothing of light without a film: its sizes are half a decade apart.
            self.changes = np.column_stack([np.full(self.nm.size, LEVEL), own[:, 1:]])
        none_cost = [self._costs(ones[0], y, size) for size in sizes]
        self.changes = own
        none_cost += [self._costs(one, y, gain) for one in ones[1:]]
        none_costs = np.array([one[0][:, 0] for one in none_cost])
        found = self._refined(y, gain, cost, volume, none_costs.min(axis=0))
        scale = 1.0 / (found.kappa**2 * self.tempered)
        none = -0.5 * none_costs * scale - np.array([one[1][0] for one in none_cost])[:, None] / self.tempered
        found.none = np.logaddexp.reduce(none, axis=0) - math.log(len(none_cost)) + math.log(PRIOR_NONE)
        return found

    def _prior(self, h: Floats) -> Floats:
        return np.asarray(prior_density(h, *self.bounds))

    def _refined(self, y: Floats, gain: float, cost: Floats, volume: Floats, none: Floats) -> Found:
        rows, places = self._minima(cost, none)
        h = self.grid[places]
        first = float(self.grid[1] - self.grid[0])
        width = np.full(h.size, first)
        low, high = self.bounds
        count, points = len(y), self.nm.size
        curve = np.empty(0)
        kappa = np.ones(count)
        for turn in range(_TURNS):
            middle = np.clip(h, low + width, np.maximum(high - width, low + width))
            costs, volumes = self._values(rows, np.stack([middle - width, middle, middle + width], axis=1), y, gain)
            if turn == 2:
                # Twice moved, each film is nearly as good as it can be: most are none.
                kept = costs[:, 1] < self._most(rows, costs[:, 1], none)
                rows, middle, width, costs, volumes = (
                    rows[kept], middle[kept], width[kept], costs[kept], volumes[kept],
                )  # fmt: skip
            # The noise is understated by so much, at least: what the best explanation leaves, refined, not on the grid.
            kappa = np.maximum(1.0, np.sqrt(least_of(rows, costs[:, 1], none) / points))
            scale = (1.0 / (kappa**2 * self.tempered))[rows]
            below, at, above = (-0.5 * costs * scale[:, None] - volumes / self.tempered).T
            bend = 2.0 * at - below - above
            curve = np.where(bend > 0.0, bend, 0.0) / width**2
            move = np.where(bend > 1e-12, 0.5 * (above - below) / np.maximum(bend, 1e-12), np.sign(above - below))
            move = np.clip(move, -1.0, 1.0)
            h = np.clip(middle + width * move, low, high)
            peak = at + 0.5 * curve * (h - middle) ** 2
            sd = np.where(curve > 0.0, 1.0 / np.sqrt(np.maximum(curve, 1e-300)), width)
            # Three points as far apart as the data leave open; on the way there a film's own noise is not yet seen.
            if turn > 2 and bool(((sd > 0.8 * width) & (np.abs(h - middle) < 0.1 * sd)).all()):
                break
            # A top that lies outside the three is walked to with the same steps.
            narrower = np.where((np.abs(move) < 0.5) & (turn < _TURNS - 2), 0.35 * width, width)
            width = np.minimum(np.maximum(np.maximum(sd, narrower), 1e-6), first)
        sd = np.where(curve > 0.0, 1.0 / np.sqrt(np.maximum(curve, 1e-300)), high - low)
        sd = np.minimum(sd, high - low)
        mass = peak + 0.5 * math.log(2.0 * math.pi) + np.log(sd) + np.log(self._prior(h)) + math.log(PRIOR_FILM)
        shape = (count, _MOST)
        found = Found(np.full(shape, np.nan), np.full(shape, np.nan), np.full(shape, -np.inf), np.zeros(count), kappa)
        order = np.lexsort((-mass, rows))
        rows, h, sd, mass = rows[order], h[order], sd[order], mass[order]
        rank = np.arange(rows.size) - np.searchsorted(rows, rows)
        within = rank < _MOST
        rows, rank = rows[within], rank[within]
        found.thickness_nm[rows, rank], found.sd_nm[rows, rank] = h[within], sd[within]
        found.log_mass[rows, rank] = mass[within]
        self._one_of_each(found)
        return found

    def _minima(self, cost: Floats, none: Floats) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
        """Spectrum and place of the minima of the grid that may be films, by what a parabola through three points leaves."""
        padded = np.pad(cost, ((0, 0), (1, 1)), constant_values=np.inf)
        before, after = padded[:, :-2], padded[:, 2:]
        rows, places = np.nonzero((cost <= before) & (cost < after))
        left, here, right = before[rows, places], cost[rows, places], after[rows, places]
        bend = left + right - 2.0 * here
        inner = np.isfinite(bend) & (bend > 0.0)
        rise = np.where(inner, right - left, 0.0)
        deep = here - rise * rise / np.where(inner, 8.0 * bend, 1.0)
        # A parabola misses a sharp minimum by a share of its height.
        slack = 0.02 * np.where(inner, np.fmax(left, right) - here, 0.0) + 0.01 * here
        deep = np.maximum(deep - slack, 0.0)
        order = np.lexsort((deep, rows))
        rows, places, deep = rows[order], places[order], deep[order]
        rank = np.arange(rows.size) - np.searchsorted(rows, rows)
        kept = (rank < 2 * _MOST) & (deep <= self._most(rows, deep + 2.0 * slack[order], none))
        return rows[kept], places[kept]

    def _most(self, rows: npt.NDArray[np.intp], costs: Floats, none: Floats) -> Floats:
        """What a film may leave of the spectrum of its row and still count."""
        least = least_of(rows, costs, none)
        noise = np.maximum(1.0, least / self.nm.size) * self.tempered
        return (least + 2.0 * _FAR * noise)[rows]

    def _one_of_each(self, found: Found) -> None:
        """Candidates that ran to the same top count once."""
        for a in range(_MOST):
            for b in range(a):
                by = np.abs(found.thickness_nm[:, a] - found.thickness_nm[:, b])
                same = by < 3.0 * np.fmax(found.sd_nm[:, a], found.sd_nm[:, b])
                found.log_mass[same, a] = -np.inf

    def _values(self, rows: npt.NDArray[np.intp], h: Floats, y: Floats, gain: float) -> tuple[Floats, Floats]:
        """What some films leave of the spectrum of each row, squared, and log det M / 2; (rows, films) each."""
        left_over, volumes = np.empty(h.shape), np.empty(h.shape)
        step = max(1, _PASS // (2 * self.nm.size * h.shape[1] * (self.changes.shape[1] + 1)))
        for start in range(0, len(rows), step):
            part = slice(start, start + step)
            films = self.films(h[part].reshape(-1))
            columns, mean = self._design(films, gain)
            spectra = np.repeat(y[rows[part]], h.shape[1], axis=0)
            left = spectra - mean
            normal = columns @ columns.transpose(0, 2, 1)
            size = normal.shape[1]
            normal[:, range(size), range(size)] += 1.0
            right = (columns @ left[:, :, None])[:, :, 0]
            solved = np.linalg.solve(normal, right[:, :, None])[:, :, 0]
            cost = (left * left).sum(axis=1) - (right * solved).sum(axis=1)
            left_over[part] = np.maximum(cost, 0.0).reshape(-1, h.shape[1])
            volumes[part] = 0.5 * np.linalg.slogdet(normal)[1].reshape(-1, h.shape[1])
        return left_over, volumes

    # --- time

    def chain(self, found: Found, steps: Floats) -> tuple[Floats, Floats]:
        """Probabilities of the candidates and of no film, given the whole series: forward and backward.

        P(h' | h) = (1 - e) exp(-|h' - h| / (rate dt)) / (2 rate dt) + e / range; no film stays so, or a film comes from anywhere.
        """
        count = len(found.none)
        logs = np.column_stack([found.log_mass, found.none])
        unary = np.exp(logs - logs.max(axis=1)[:, None])
        # As a share of what the same film has by its own prior: else the prior would count at every step.
        prior = np.column_stack([self._prior(np.nan_to_num(found.thickness_nm, nan=self.bounds[0])), np.ones(count)])
        moves = []
        for t in range(count - 1):
            by = np.abs(found.thickness_nm[t][:, None] - found.thickness_nm[t + 1][None, :])
            sd = np.hypot(found.sd_nm[t][:, None], found.sd_nm[t + 1][None, :])
            tau = self.rate_of_change * steps[t] + sd
            move = np.zeros((_MOST + 1, _MOST + 1))
            inner = (1.0 - _JUMP) * np.exp(-by / tau) / (2.0 * tau) + _JUMP * prior[t + 1][:_MOST][None, :]
            move[:_MOST, :_MOST] = np.nan_to_num(inner) / prior[t + 1][:_MOST][None, :]
            # No film comes, and goes, as a jump does.
            move[:_MOST, _MOST], move[_MOST, :_MOST] = _JUMP / PRIOR_NONE, _JUMP / PRIOR_FILM
            move[_MOST, _MOST] = (1.0 - _JUMP) / PRIOR_NONE
            moves.append(move)
        forward, backward = unary.copy(), np.ones_like(unary)
        for t in range(1, count):
            forward[t] = unary[t] * (forward[t - 1] @ moves[t - 1])
            forward[t] /= max(float(forward[t].sum()), 1e-300)
        for t in range(count - 2, -1, -1):
            backward[t] = moves[t] @ (unary[t + 1] * backward[t + 1])
            backward[t] /= max(float(backward[t].max()), 1e-300)
        belief = forward * backward
        belief /= np.maximum(belief.sum(axis=1), 1e-300)[:, None]
        return belief[:, :_MOST], belief[:, _MOST]

    def near_nm(self, h: Floats) -> Floats:
        """Films within this are of one order: a quarter of a wave, less for thin ones."""
        return np.minimum(quarter_wave_nm(self.problem, self.nm), 0.25 * h + 3.0)

    def fringes(self, h: Floats) -> Floats:
        """Over the spectrum."""
        return np.asarray(h * float(np.ptp(self.rate)) / (2.0 * math.pi))

    # --- what all spectra share

    def learn(self, thickness_nm: Floats, sure: npt.NDArray[np.bool_], least: int = _LEAST_TEACHERS) -> bool:
        """The lamp from spectra whose films are sure; whether there were enough of them."""
        teachers = np.flatnonzero(sure & (self.fringes(thickness_nm) > _TEACHING_FRINGES))
        if self.light.lamp is None and teachers.size < least:
            return False
        use = (
            teachers[np.linspace(0, teachers.size - 1, min(teachers.size, 400)).astype(int)]
            if teachers.size
            else teachers
        )
        if not use.size:
            return False
        films, y = self.films(thickness_nm[use]), self.y[use]
        modes = self._columns(_LAMP if self.light.lamp is None else (_KNOWN[0], _LAMP[1]), _LEAST_OF_A_LAMP)[:, 1:]
        base = self.lamp if self.light.lamp is not None else self._lamp_of(films, y)
        lamp, films, normal = self._with_films(base, modes, thickness_nm[use], y)
        self.lamp, self.bend, self.learnt = lamp, _LEARNT, True
        gains, strays = self._linear(films, y, lamp)
        if self.light.gain is None:
            self.size = size_of_light(gains)
        left = (y - (gains[:, None] * films + strays[:, None]) * lamp) / self.sd
        self.tempered = float(np.median([temper(row) for row in left]))
        # Neighbours' errors that hang together count once, and what the noise was understated by, counts; the prior stays.
        excess = self.tempered * max(1.0, float(np.median((left * left).mean(axis=1))))
        prior = np.eye(modes.shape[1])
        factor = np.linalg.cholesky(prior + (normal - prior) / excess)
        self.lamp_unknown = np.linalg.solve(factor, modes.T).T * (base / lamp)[:, None]
        return True

    def errors_of_all(self, thickness_nm: Floats) -> tuple[Floats, Floats]:
        """How far each thickness moves, nm, with what all spectra share: one sd of the learnt lamp, and the index by itself.

        A change d of the spectra, of the lamp or of the index, moves the film of a spectrum by (s.P d) / (s.P s), s the slope of
        the spectrum with thickness, P what gain, drift and stray light cannot take up. So the variance of the joint posterior of
        lamp and films is that of the film under a known lamp, which `Found` has, and the sum of these squares (the law of total
        variance). Of the index, fringes show n h alone; a thin film shows how large n is, too, and moves by up to five times as
        much.
        """
        by_lamp, by_n = np.zeros(len(thickness_nm)), np.array(thickness_nm, dtype=np.float64)
        thin = self.fringes(thickness_nm) < _THIN_FRINGES
        asked = np.isfinite(thickness_nm) if self.lamp_unknown.shape[1] else np.isfinite(thickness_nm) & thin
        known = np.flatnonzero(asked)
        gain, step = self._gain(), 1e-3 / float(self.rate.max())
        rows_at_once = max(1, _PASS // (4 * self.nm.size * (self.changes.shape[1] + 1)))
        for start in range(0, known.size, rows_at_once):
            rows = known[start : start + rows_at_once]
            h = thickness_nm[rows]
            films = self.films(h)
            below = np.maximum(h - step, 0.0)
            slopes = (self.films(h + step) - self.films(below)) / (h + step - below)[:, None]
            columns, mean = self._design(films, gain)
            size = columns.shape[1]
            normal = columns @ columns.transpose(0, 2, 1)
            normal[:, range(size), range(size)] += 1.0
            left = self.y[rows] / self.sd - mean
            theta = np.linalg.solve(normal, (columns @ left[:, :, None]))[:, :, 0]
            part = theta[:, : self.changes.shape[1]]
            response = gain * self.lamp / self.sd * (1.0 + part @ self.changes.T)
            light = mean + np.einsum("tcn,tc->tn", columns, theta)
            moved = response * slopes
            taken = np.linalg.solve(normal, (columns @ moved[:, :, None]))[:, :, 0]
            seen = moved - np.einsum("tcn,tc->tn", columns, taken)
            size_of = np.maximum((seen * moved).sum(axis=1), 1e-300)
            by_lamp[rows] = np.linalg.norm((seen * light) @ self.lamp_unknown, axis=1) / size_of
            for i in np.flatnonzero(thin[rows]):
                contrast = by_index(self.problem, self.nm, float(h[i]))
                more = float((seen[i] * response[i]) @ contrast) / size_of[i]
                by_n[rows[i]] = min(max(abs(h[i] + more), h[i]), _STEEPEST * h[i])
        return by_lamp, by_n

    def _with_films(self, base: Floats, modes: Floats, h: Floats, y: Floats) -> tuple[Floats, Floats, Floats]:
        """The lamp, the films as they are under it, and the normal matrix of the lamp, by Gauss and Newton.

        Lamp and films are the most probable of both together. One after the other they would creep: what a wrong film leaves,
        the lamp takes, and that lamp keeps the film wrong. So gain, stray light and thickness of each spectrum are eliminated
        where the lamp is solved for.
        """
        lamp, films = base, self.films(h)
        low, high = self.bounds
        # Steps of a derivative, and the longest of a film: it stays in its order.
        step, reach = 1e-3 / float(self.rate.max()), 0.5 / float(self.rate.max())
        whole = np.eye(modes.shape[1])
        a = np.zeros(modes.shape[1])
        for _ in range(_LAMP_TURNS):
            gains, strays = self._linear(films, y, lamp)
            slope = (self.films(h + step) - self.films(np.maximum(h - step, 0.0))) / (step + np.minimum(h, step))[
                :, None
            ]
            light = lamp / self.sd
            own = [films * light, gains[:, None] * slope * light]
            if self.light.stray:
                own.insert(1, np.broadcast_to(light, films.shape))
            columns = np.stack(own, axis=2)
            columns = columns / np.maximum(np.linalg.norm(columns, axis=1), 1e-300)[:, None, :]
            base_of, factor = np.linalg.qr(columns)
            seen = (gains[:, None] * films + strays[:, None]) * (base / self.sd)
            left = y / self.sd - (gains[:, None] * films + strays[:, None]) * light
            # D = seen * modes; what gain, stray light and thickness can do is taken out of it, and of what is left.
            part = np.einsum("tnk,nm->tkm", base_of * seen[:, :, None], modes)
            rest = left - np.einsum("tnk,tk->tn", base_of, np.einsum("tnk,tn->tk", base_of, left))
            normal = (
                whole + modes.T @ ((seen * seen).sum(axis=0)[:, None] * modes) - np.einsum("tkm,tkn->mn", part, part)
            )
            move = np.linalg.solve(normal, modes.T @ (seen * rest).sum(axis=0) - a)
            a = a + move
            lamp = base * (1.0 + modes @ a)
            lamp = np.maximum(lamp, 1e-3 * float(lamp.max()))
            # Each film then moves as what is left of it asks.
            after = left - (modes @ move)[None, :] * seen
            moved = np.linalg.solve(factor, np.einsum("tnk,tn->tk", base_of, after)[:, :, None])[:, -1, 0]
            moved /= np.maximum(np.linalg.norm(own[-1], axis=1), 1e-300)
            h = np.clip(h + np.clip(moved, -reach, reach), low, high)
            films = self.films(h)
        # Known up to its size: that of the first lamp.
        return lamp, films, normal

    def _lamp_of(self, films: Floats, y: Floats) -> Floats:
        """The smooth lamp under which these films look like these spectra."""
        x = (2.0 * self.nm - self.nm[0] - self.nm[-1]) / (self.nm[-1] - self.nm[0])
        basis = np.polynomial.chebyshev.chebvander(x, 6)
        sizes = np.maximum(y.sum(axis=1), 1e-300) / films.sum(axis=1)
        weight = ((sizes[:, None] * films) ** 2).sum(axis=0) / self.sd**2
        mean = (sizes[:, None] * films * y).sum(axis=0) / np.maximum(
            ((sizes[:, None] * films) ** 2).sum(axis=0), 1e-300
        )
        root = np.sqrt(weight)[:, None]
        course = basis @ np.linalg.lstsq(basis * root, mean * root[:, 0], rcond=None)[0]
        course = np.maximum(course, 0.05 * max(float(course.max()), 1e-300))
        return np.asarray(course * float(np.median(sizes)))

    def left(self, thickness_nm: Floats, sure: npt.NDArray[np.bool_]) -> Floats:
        """What the lamp and the films leave of some sure spectra."""
        use = np.flatnonzero(sure)[:200]
        films, y = self.films(thickness_nm[use]), self.y[use]
        gains, strays = self._linear(films, y, self.lamp)
        return np.asarray(y - (gains[:, None] * films + strays[:, None]) * self.lamp)

    def _linear(self, films: Floats, y: Floats, lamp: Floats) -> tuple[Floats, Floats]:
        """Gain and stray light of each spectrum, the lamp known."""
        weight = lamp * lamp / self.sd**2
        z = y / lamp
        ff, f1, one = (films * films) @ weight, films @ weight, float(weight.sum())
        fz, oz = ((films * z) @ weight), z @ weight
        if not self.light.stray:
            return fz / np.maximum(ff, 1e-300), np.zeros(len(y))
        # Stray light is not negative, and small: a ridge of its own prior.
        ridge = 1.0 / max((_STRAY * self.mean * self._gain()) ** 2, 1e-300)
        determinant = ff * (one + ridge) - f1 * f1
        gains = ((one + ridge) * fz - f1 * oz) / np.maximum(determinant, 1e-300)
        return gains, (oz - f1 * gains) / (one + ridge)

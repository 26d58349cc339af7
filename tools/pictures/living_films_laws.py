"""Draw docs/images/living-films-laws.png: what flowing films do against what their laws say.

Run from the root of the repository: python tools/pictures/living_films_laws.py
The panel of errors against the grid takes what the tests of the laws print (cargo is needed); the others let films flow.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

from iridesce.thickness import simulate

mpl.use("Agg")
import matplotlib.pyplot as plt

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#666666")
LINE = re.compile(
    r"^(?P<law>[^:]+): (?:l2 )?(?P<coarse>-?[\d.e-]+) at (?P<columns>\d+)(?: x \d+| rows)?, "
    r"(?P<fine>-?[\d.e-]+) at (?P<finer>\d+)"
)
NAMES = {
    "bell, 45 deg": "cosine bell, 45°, l2",
    "bell, 90 deg": "cosine bell, over the poles, l2",
    "zonal flow": "steady zonal flow",
    "harmonic 5, 4": "decay of harmonic 5, 4",
    "surfactant diffusion": "diffusion of surfactant",
    "rigid film": "rigid film (by rows)",
}


def orders(axes: Any) -> None:
    """Errors against the grid, as the tests print them."""
    command = ["cargo", "test", "-p", "iridesce-flow", "laws", "--", "--nocapture"]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    found = {}
    for line in printed.splitlines():
        match = LINE.match(line.replace("off by ", ""))
        if match and match["law"] in NAMES:
            found[match["law"]] = match
    for (law, name), color in zip(NAMES.items(), COLORS, strict=False):
        match = found[law]
        columns = np.array([int(match["columns"]), int(match["finer"])])
        errors = np.abs([float(match["coarse"]), float(match["fine"])])
        axes.loglog(columns, errors, "o-", color=color, label=f"{name}: {np.log2(errors[0] / errors[1]):.1f}")
    cells = np.array([32.0, 256.0])
    for power, start in ((1, 4e-3), (2, 0.4)):
        axes.loglog(cells, start * (cells / 32.0) ** -power, ":", color="#999999")
        axes.text(cells[1], start * 8.0**-power, f" order {power}", color="#666666", va="center", fontsize=8)
    axes.set(title="Errors against the grid, and their order", xlabel="columns", ylabel="relative error")
    axes.set_xticks([32, 64, 128, 256], ["32", "64", "128", "256"])
    axes.minorticks_off()
    axes.set_xlim(28, 420)
    axes.set_ylim(2e-5, 0.6)
    axes.legend(fontsize=7, frameon=False, loc="lower left")


def regeneration(axes: Any) -> None:
    """Volume of a film that regenerates."""
    start, rim, strength = 450e-9, 0.025, 0.5
    film = simulate(
        "bubble-on-bath", 8.0, 4.0, columns=256, regeneration=strength, patch_m=3e-3, noise=0.1, evaporation_nm_s=0.0,
        drains_inside=0.0, black_below_nm=0.0, black_nm=0.0, air_mass_kg_m2=0.0, step_s=0.01,
    )  # fmt: skip
    times, volumes = [], []
    for frame in film:
        times.append(frame.time_s)
        volumes.append(film.facts["volume_m3"] or 0.0)
    rate = 1.5 * strength * (0.03 / 1.5e-3) * start**1.5 / (0.3e-3**1.5 * rim)
    along = np.linspace(0.0, 8.0, 200)
    axes.plot(along, 450.0 * (1.0 + rate * along) ** (-2.0 / 3.0), color="black", label="(1 + t/t*)$^{-2/3}$")
    axes.plot(times, 450.0 * np.array(volumes) / volumes[0], "o", color=COLORS[0], ms=4, label="measured")
    axes.set(title="Regenerating dome: mean thickness", xlabel="time, s", ylabel="nm")
    axes.legend(frameon=False)


def rigid(axes: Any) -> None:
    """A rigid vertical film, from the flow between its faces alone."""
    film = simulate(
        "vertical-film", 4e4, 1e-3, columns=32, thickness_nm=5000.0, noise=0.0, regeneration=0.0, evaporation_nm_s=0.0,
        surface_viscosity_pa_s_m=1.0, elasticity_n_m=1e3, black_below_nm=0.0, black_nm=0.0, step_s=20.0,
    )  # fmt: skip
    frames = list(film)
    times = np.array([frame.time_s for frame in frames])
    rows = frames[0].thickness_nm.shape[0]
    for depth, color in zip((0.01, 0.03, 0.05), COLORS, strict=False):
        row = int(depth / 0.06 * rows)
        place = (row + 0.5) / rows * 0.06
        law = 2e9 * np.sqrt(1.5e-3 * place / (1000 * 9.81 * np.maximum(times, 1.0)))
        axes.loglog(times[1:], law[1:], color="black", lw=1, label="2 √(μz/ρgt)" if depth == 0.01 else None)
        seen = [frame.thickness_nm[row].mean() for frame in frames[1:]]
        axes.loglog(times[1:], seen, "o", ms=3, color=color, label=f"{place * 100:.0f} cm below the top")
    axes.set(title="Rigid vertical film, 5 µm at the start", xlabel="time, s", ylabel="nm")
    axes.set_xlim(1e3, 4e4)
    axes.legend(frameon=False, fontsize=8)


def heights(axes: Any, preset: str, places: dict[str, float], end: float, title: str, lost: Any) -> None:
    """Mean thickness along three heights of a film, and the law of its mean."""
    film = simulate(preset, end, 10.0, rupture_nm=0.0)
    frames = list(film)
    times = np.array([frame.time_s for frame in frames])
    rows = frames[0].thickness_nm.shape[0]
    for (name, share), color in zip(places.items(), COLORS, strict=False):
        row = min(int(share * rows), rows - 2)
        axes.plot(times, [frame.thickness_nm[row - 1 : row + 2].mean() for frame in frames], color=color, label=name)
    mean = [frames[0].thickness_nm.mean() if not lost.sphere else lost.start]
    steps = 200
    for _ in range(int(end * steps)):
        mean.append(mean[-1] - lost(mean[-1]) / steps)
    axes.plot(np.arange(len(mean)) / steps, mean, color="black", lw=1, ls="--", label="mean: regeneration and drying")
    weight = film.facts["start_m3"] or 1.0
    axes.plot(
        times[-1:], [mean[0] * (film.facts["volume_m3"] or 0.0) / weight], "k*", label="mean, measured at the end"
    )
    axes.set(title=title, xlabel="time, s", ylabel="nm", ylim=(0, None))
    axes.legend(frameon=False, fontsize=7)


class Lost:
    """What a mean thickness loses, nm/s: the meniscus takes K (sigma / mu) h^(5/2) / r_m^(3/2) per length of rim."""

    def __init__(self, start: float, strength: float, evaporation: float, per_area: float, sphere: bool) -> None:
        self.start, self.sphere = start, sphere
        self._strength, self._evaporation, self._per_area = strength, evaporation, per_area

    def __call__(self, nm: float) -> float:
        flux = self._strength * (0.03 / 1.5e-3) * (nm * 1e-9) ** 2.5 / 0.3e-3**1.5
        return float(flux * self._per_area * 1e9 + self._evaporation)


def main() -> None:
    """Draw the panels."""
    figure, ((a, b, c), (d, e, f)) = plt.subplots(2, 3, figsize=(15, 9), dpi=100)
    orders(a)
    regeneration(b)
    rigid(c)
    dome = {"20° from the top": 20 / 90, "50°": 50 / 90, "80°": 80 / 90}
    lost = Lost(450.0, 6 * 0.06, 6 * 20.0, 1 / 0.025, True)
    heights(d, "bubble-on-bath-time-lapse", dome, 3.0, "Dome, time-lapse: along three circles", lost)
    plane = {"1 cm below the top": 1 / 6, "3 cm": 3 / 6, "5 cm": 5 / 6}
    # Both sides, and the bottom with its wider meniscus.
    lost = Lost(700.0, 6 * 0.06, 6 * 10.0, 2 / 0.1 + (0.3 / 1.24) ** 1.5 / 0.06, False)
    heights(e, "vertical-film-time-lapse", plane, 3.0, "Vertical film, time-lapse: along three lines", lost)
    profile(f)
    for axes in (a, b, c, d, e, f):
        axes.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    figure.savefig(Path("docs/images/living-films-laws.png"))


def profile(axes: Any) -> None:
    """Late thickness against depth: sorted, thin above."""
    for preset, height, color in (
        ("bubble-on-bath-time-lapse", 0.025, COLORS[0]),
        ("vertical-film-time-lapse", 0.06, COLORS[1]),
    ):
        film = simulate(preset, 2.0, 0.5, rupture_nm=0.0)
        *_, last = film
        rows = last.thickness_nm.shape[0]
        middle = (np.arange(rows) + 0.5) / rows
        depth = height * (1.0 - np.cos(middle * np.pi / 2)) if height == 0.025 else height * middle
        mean = last.thickness_nm.mean(axis=1)
        spread = last.thickness_nm.std(axis=1)
        axes.plot(depth * 100, mean, color=color, label=preset)
        axes.fill_between(depth * 100, mean - spread, mean + spread, color=color, alpha=0.2, lw=0)
    axes.set(
        title="After 2 s: thickness against depth, with its spread",
        xlabel="cm below the top",
        ylabel="nm",
        ylim=(0, None),
    )
    axes.legend(frameon=False, fontsize=8, loc="lower right")


if __name__ == "__main__":
    main()

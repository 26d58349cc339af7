"""The charts of the reference suite: which film, which light, which grid; computed by the core. Internal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from iridesce import color
from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import refusal
from iridesce.exchange.films import ANGLES_DEG, COUNT, Film, film_of, read_stack

RANGE_NM = (50.0, 1200.0)
THICKNESS_NM = tuple(float(t) for t in np.linspace(*RANGE_NM, COUNT))

CODES = 255
"""Steps of an 8-bit map of thickness over the chart's range."""


@dataclass(frozen=True)
class Chart:
    """One chart: 24 thicknesses across, seven angles down."""

    name: str
    title: str
    stack: str
    quantity: str = "reflectance"
    illuminant: str = "D65"
    moved: Callable[[Floats], Floats] | None = None
    """What is done to the thickness before it is drawn: charts that show what small errors do."""

    def film(self) -> Film:
        """The film of the chart."""
        return _film(self.stack, self.illuminant)

    def xyz(self, thickness_nm: Floats, angle_deg: Floats) -> Floats:
        """The truth at thicknesses and angles that broadcast."""
        thickness = thickness_nm if self.moved is None else self.moved(np.asarray(thickness_nm))
        film = self.film()
        if self.quantity == "furnace":
            return film.xyz(thickness, angle_deg) + film.xyz(thickness, angle_deg, "transmittance")
        return film.xyz(thickness, angle_deg, self.quantity)

    def truth(self) -> Floats:
        """The chart itself, (7, 24, 3)."""
        return self.xyz(np.array(THICKNESS_NM)[None, :], np.array(ANGLES_DEG)[:, None])

    @property
    def is_metal(self) -> bool:
        """Whether what carries the film absorbs."""
        return not self.film().transmits


@cache
def _film(stack: str, illuminant: str) -> Film:
    parsed, layer = read_stack(stack)
    return film_of(parsed, layer, RANGE_NM, None, color.illuminant(illuminant))


def coded(thickness_nm: Floats) -> Floats:
    """A thickness as an 8-bit map over the chart's range holds it."""
    low, high = RANGE_NM
    return np.asarray(low + np.rint((thickness_nm - low) / (high - low) * CODES) * (high - low) / CODES)


def _off(nm: float) -> Callable[[Floats], Floats]:
    return lambda thickness_nm: thickness_nm + nm


_SOAP = "air / soap ? / air"
_PLAIN = (
    Chart("C1", "soap film in air, reflected", _SOAP),
    Chart("C2", "soap film in air, transmitted", _SOAP, "transmittance"),
    Chart("C3", "oil (n = 1.47) on water", "air / 1.47 ? / water"),
    Chart("C4", "magnesium fluoride on N-BK7 glass", "air / MgF2 ? / N-BK7"),
    Chart("C5", "silica on silicon", "air / SiO2 ? / Si"),
    Chart("C6", "titania on titanium", "air / TiO2 ? / Ti"),
    Chart("C7", "furnace: R + T of a soap film, white everywhere", _SOAP, "furnace"),
)
LAMPS = {"A": "A", "FL2": "FL2", "FL11": "FL11", "LED-B1": "LED-B1", "sodium": "lines:589.158*2,589.756"}
_LAMPS = tuple(Chart(f"C8-{name}", f"C1 under {name}", _SOAP, illuminant=light) for name, light in LAMPS.items())
_STEPS = (
    Chart("C9-0nm", "C1 as it is", _SOAP),
    Chart("C9-1nm", "C1, 1 nm thicker", _SOAP, moved=_off(1.0)),
    Chart("C9-2nm", "C1, 2 nm thicker", _SOAP, moved=_off(2.0)),
    Chart("C9-5nm", "C1, 5 nm thicker", _SOAP, moved=_off(5.0)),
    Chart("C9-8bit", "C1 with its thickness in 8 bits", _SOAP, moved=coded),
)

CHARTS: dict[str, Chart] = {chart.name: chart for chart in (*_PLAIN, *_LAMPS, *_STEPS)}
GROUPS: dict[str, tuple[Chart, ...]] = {"C8": _LAMPS, "C9": _STEPS}
"""Names that stand for several charts, of which a picture shows one."""


def charts_named(name: object) -> tuple[Chart, ...]:
    """The chart of a name, or the group; `ValueError` with all names."""
    if isinstance(name, str):
        for known, chart in CHARTS.items():
            if known.lower() == name.lower():
                return (chart,)
        if name.upper() in GROUPS:
            return GROUPS[name.upper()]
    raise refusal("chart", f"one of {', '.join([*CHARTS, *GROUPS])}", name)

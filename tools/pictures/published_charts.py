"""Compare published colour charts with computed colours, and write the tables of docs/evidence/published-charts.md.

    python tools/pictures/published_charts.py            # rewrite the tables
    python tools/pictures/published_charts.py --check    # exit code 1 if a table of the page is not what is computed

The charts name colours; a name is turned into a range of CIELAB hue by one fixed rule (`HUE_NAMES` and `FAMILIES`
below), the same for every chart and every row. python/tests/color/test_published_charts.py checks that rule against the
Munsell renotation and the tables of the page against this file.
"""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import iridesce as ir

Floats = NDArray[np.float64]
Colours = Callable[[Floats], Floats]

PAGE = Path(__file__).resolve().parents[2] / "docs" / "evidence" / "published-charts.md"

# CIELAB hue in degrees at which each of the ten Munsell hue families begins: the mean over value 4 to 8 and chroma 4 to
# 8 of the Munsell renotation (Newhall, Nickerson & Judd, J. Opt. Soc. Am. 33, 385 (1943)) under illuminant C, rounded.
FAMILIES = {"R": 13, "YR": 45, "Y": 79, "GY": 104, "G": 140, "BG": 173, "B": 206, "PB": 249, "P": 297, "RP": 334}

# A colour name and the Munsell families that it may lie in. Munsell's own words where he has them; violet counts as his
# purple (and so red-violet as red-purple, blue-violet as purple-blue), brown and tan as dark and pale orange, pink and
# melon as pale reds.
HUE_NAMES = {
    "red": ("R",),
    "orange": ("YR",),
    "brown": ("YR",),
    "tan": ("YR",),
    "gold": ("YR", "Y"),
    "straw": ("Y",),
    "yellow": ("Y",),
    "yellow-green": ("GY",),
    "green": ("G",),
    "blue-green": ("BG",),
    "turquoise": ("BG",),
    "blue": ("B", "PB"),
    "royal blue": ("PB",),
    "blue-violet": ("PB",),
    "violet": ("P",),
    "purple": ("P",),
    "red-violet": ("RP",),
    "pink": ("RP", "R"),
    "melon": ("R", "YR"),
    "salmon": ("R", "YR"),
}

# Chroma C*ab below which a colour may be called silver, grey or metallic: about Munsell chroma 2.
NEUTRAL_CHROMA = 10.0
# Chroma below which no hue is seen: about Munsell chroma 1.
NO_HUE_CHROMA = 5.0
# A hue this close to its range, in degrees, is "near": half a Munsell family is 18.
NEAR_DEG = 18.0


@dataclass(frozen=True)
class Row:
    """One line of a chart: where, its wording, the hue names in it, and whether a neutral will do as well."""

    at: float
    wording: str
    names: tuple[str, ...]
    neutral: bool = False


@dataclass(frozen=True)
class Verdict:
    """The computed colour of a row and whether it bears out the name."""

    hue_deg: float
    chroma: float
    answer: str


def chart(text: str) -> list[Row]:
    """Rows of `at | wording | names, comma separated; * for a neutral`."""
    rows = []
    for line in text.strip().splitlines():
        at, wording, names = (field.strip() for field in line.split("|"))
        parts = [name.strip() for name in names.split(",")]
        rows.append(Row(float(at), wording, tuple(n for n in parts if n != "*"), "*" in parts))
    return rows


# Colour chart of thermally grown silicon dioxide on silicon, seen from above under daylight fluorescent light:
# after W. A. Pliskin & E. E. Conrad (1964), as handed out by a university's clean room (University of Illinois,
# fabrication laboratory, table GT7).
SIO2_ON_SI = chart("""
    50 | tan | tan
    70 | brown | brown
    100 | dark violet to red violet | violet, red-violet
    120 | royal blue | royal blue
    150 | light blue to metallic blue | blue
    170 | metallic to very light yellow-green | yellow-green, *
    200 | light gold or yellow, slightly metallic | gold, yellow
    220 | gold, slight yellow-orange | gold, orange
    250 | orange to melon | orange, melon
    270 | red-violet | red-violet
    300 | blue to violet-blue | blue, blue-violet
    310 | blue | blue
    320 | blue to blue-green | blue, blue-green
    340 | light green | green
    350 | green to yellow-green | green, yellow-green
    360 | yellow-green | yellow-green
    370 | green-yellow | yellow-green
    390 | yellow | yellow
    410 | light orange | orange
    420 | carnation pink | pink
    440 | violet-red | red-violet
    460 | red-violet | red-violet
    470 | violet | violet
    480 | blue-violet | blue-violet
    490 | blue | blue
    500 | blue-green | blue-green
    520 | green | green
    540 | yellow-green | yellow-green
    560 | green-yellow | yellow-green
    570 | yellow to "yellowish" | yellow
    580 | light orange or yellow to pink | orange, yellow, pink
    600 | carnation pink | pink
    630 | violet-red | red-violet
    680 | "bluish", greyish | blue, *
    720 | blue-green to green | blue-green, green
    770 | "yellowish" | yellow
    800 | orange | orange
    820 | salmon | salmon
    850 | dull light red-violet | red-violet
    860 | violet | violet
    870 | blue-violet | blue-violet
    890 | blue | blue
    920 | blue-green | blue-green
    950 | dull yellow-green | yellow-green
    970 | yellow to "yellowish" | yellow
    990 | orange | orange
""")

# Anodised titanium, by voltage: a hobbyist's chart (nokit.org) that reckons 2 nm of oxide to the volt.
TITANIUM = chart("""
    4 | pale gold | gold
    8 | golden | gold
    12 | purple | purple
    16 | blue-violet | blue-violet
    20 | deep blue | blue
    25 | royal blue | royal blue
    30 | sky blue | blue
    35 | blue-green | blue-green
    40 | yellow-green | yellow-green
    45 | straw | straw
    55 | pink | pink
    65 | turquoise | turquoise
    80 | pale pink | pink
    90 | pale green | green
""")

# The sequence reported from 0 to 140 V (carlesso.net).
TITANIUM_SEQUENCE = chart("""
    1 | yellow | yellow
    2 | purple | purple
    3 | blue | blue
    4 | silver | *
    5 | yellow | yellow
    6 | pink | pink
    7 | violet | violet
    8 | cobalt | blue
    9 | green | green
    10 | yellow-green | yellow-green
    11 | pink | pink
""")

# Temper colours of steel, in the order in which a heated blade runs through them (176, 205 and 226; 260; 282; 310 and
# 337; 371 degrees Celsius). How thick the oxide is the chart does not say, so only the order can be asked for.
TEMPER = chart("""
    1 | faint yellow, light straw, dark straw | straw
    2 | brown | brown
    3 | purple | purple
    4 | dark blue, light blue | blue
    5 | grey-blue | blue, *
""")


# ---------------------------------------------------------------------------------------------------------------------
# The rule


def sectors(row: Row) -> list[tuple[float, float]]:
    """The ranges of hue (from, to) of a row in degrees, one per family, `to` above 360 where red is crossed."""
    order = list(FAMILIES)
    wanted = {order.index(family) for name in row.names for family in HUE_NAMES[name]}
    found = []
    for index in sorted(wanted):
        start = FAMILIES[order[index]]
        end = FAMILIES[order[(index + 1) % len(order)]]
        found.append((float(start), float(end if end > start else end + 360)))
    return found


def distance(hue_deg: float, ranges: Iterable[tuple[float, float]]) -> float:
    """Degrees from a hue to the nearest of some ranges, 0 inside."""
    apart = [360.0]
    for start, end in ranges:
        if (hue_deg - start) % 360.0 <= end - start:
            return 0.0
        apart += [(start - hue_deg) % 360.0, (hue_deg - end) % 360.0]
    return min(apart)


def fits(row: Row, hue_deg: float, chroma: float) -> bool:
    """Whether a colour bears out the name of a row."""
    if row.neutral and chroma < NEUTRAL_CHROMA:
        return True
    return chroma >= NO_HUE_CHROMA and distance(hue_deg, sectors(row)) == 0.0


def judge(rows: list[Row], colours: Colours) -> list[Verdict]:
    """Each row against the computed colours `colours(at) -> (..., 3)` in LCh.

    "yes": the hue at the stated value bears out the name. "row": it does at a value that the chart gives the same name,
    nearer to this row than to the next. "near": the hue is at most NEAR_DEG away. "no": otherwise.
    """
    verdicts = []
    for index, row in enumerate(rows):
        below = (rows[index - 1].at + row.at) / 2 if index else row.at
        above = (rows[index + 1].at + row.at) / 2 if index + 1 < len(rows) else row.at
        _, chroma, hue_deg = (float(v) for v in colours(np.array(row.at)))
        span = colours(np.linspace(below, above, 41))
        if fits(row, hue_deg, chroma):
            answer = "yes"
        elif any(fits(row, float(h), float(c)) for _, c, h in span):
            answer = "row"
        elif chroma >= NO_HUE_CHROMA and distance(hue_deg, sectors(row)) <= NEAR_DEG:
            answer = "near"
        else:
            answer = "no"
        verdicts.append(Verdict(hue_deg, chroma, answer))
    return verdicts


def in_order(rows: list[Row], thickness_nm: Floats, colours: Floats) -> list[Floats]:
    """The stretch of thicknesses over which each name holds, every one after the one before it; empty if it is not met.

    thickness_nm   ascending          (n,)
    colours        LCh at each        (n, 3)
    """
    found = []
    position = 0
    for row in rows:
        holds = [fits(row, float(h), float(c)) for _, c, h in colours]
        start = next((i for i in range(position, len(holds)) if holds[i]), None)
        if start is None:
            found.append(thickness_nm[:0])
            continue
        end = next((i for i in range(start, len(holds)) if not holds[i]), len(holds))
        found.append(thickness_nm[start:end])
        position = end
    return found


# ---------------------------------------------------------------------------------------------------------------------
# The films


def lch(film: str | float, base: str, illuminant: str = "D65") -> Colours:
    """Computed colours in LCh of a film in air on a base, at normal incidence, as a function of its thickness in nm."""

    def colours(thickness_nm: Floats) -> Floats:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # tables that end short of 830 nm: of no weight in the colour
            return ir.Stack(["air", ir.Layer(film, thickness_nm), base]).color(space="lch", illuminant=illuminant)

    return colours


def anodised(nm_per_volt: float, native_nm: float) -> Colours:
    """Anodised titanium by voltage: thickness of the oxide = native + nm per volt times voltage."""
    colours = lch("TiO2", "Ti")
    return lambda volt: colours(native_nm + nm_per_volt * volt)


def oil(thickness_nm: Floats) -> Floats:
    """LCh of an oil of n = 1.47 on water, exposed so that the brightest thickness is white."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        xyz = ir.Stack(["air", ir.Layer(1.47, thickness_nm), "water"]).color()
    return ir.color.convert(xyz / xyz[:, 1].max(), "xyz", "lch")


# ---------------------------------------------------------------------------------------------------------------------
# Scores


def count(verdicts: list[Verdict], *answers: str) -> int:
    """How many of the verdicts are among the answers."""
    return sum(verdict.answer in answers for verdict in verdicts)


def shuffled(rows: list[Row], colours: Colours, rounds: int = 200, seed: int = 1) -> Floats:
    """Rows that are "yes" when the names are dealt out anew at random, once per round: what chance would give."""
    random = np.random.default_rng(seed)
    at = np.array([row.at for row in rows])
    computed = colours(at)
    scores = []
    for _ in range(rounds):
        dealt = random.permutation(len(rows))
        scores.append(sum(fits(rows[j], float(h), float(c)) for j, (_, c, h) in zip(dealt, computed, strict=True)))
    return np.array(scores, dtype=float)


# ---------------------------------------------------------------------------------------------------------------------
# The page


def range_text(row: Row) -> str:
    """The hue ranges of a row, in words."""
    merged: list[list[float]] = []
    for start, end in sectors(row):
        if merged and start == merged[-1][1]:
            merged[-1][1] = end
        else:
            merged.append([start, end])
    if len(merged) > 1 and merged[-1][1] - 360 == merged[0][0]:  # joined across 0 degrees
        merged[-1][1] = merged[0][1] + 360
        merged.pop(0)
    parts = [f"{start:.0f} to {end % 360:.0f}" for start, end in merged]
    return " or ".join([*parts, "neutral"] if row.neutral else parts)


def cell(verdict: Verdict) -> str:
    """Hue and chroma, in a cell of a table."""
    return f"{verdict.hue_deg:.0f}, {verdict.chroma:.0f}"


def table_sio2() -> str:
    daylight = judge(SIO2_ON_SI, lch("SiO2", "Si"))
    lamp = judge(SIO2_ON_SI, lch("SiO2", "Si", "FL2"))
    lines = ["| nm | name in the chart | hue range | D65: hue, chroma | agrees | F2: hue, chroma | agrees |"]
    lines += ["|---|---|---|---|---|---|---|"]
    for row, day, night in zip(SIO2_ON_SI, daylight, lamp, strict=True):
        lines.append(
            f"| {row.at:.0f} | {row.wording} | {range_text(row)} | {cell(day)} | {day.answer} "
            f"| {cell(night)} | {night.answer} |"
        )
    return "\n".join(lines)


def score(name: str, rows: list[Row], verdicts: list[Verdict]) -> str:
    n = len(rows)
    yes, row, near = (count(verdicts, *words) for words in (("yes",), ("yes", "row"), ("yes", "row", "near")))
    return f"| {name} | {n} | {yes} ({yes / n:.0%}) | {row} ({row / n:.0%}) | {near} ({near / n:.0%}) |"


def table_shares() -> str:
    lines = ["| chart | rows | yes | yes or row | yes, row or near |", "|---|---|---|---|---|"]
    for light, label in (("D65", "D65"), ("FL2", "F2")):
        colours = lch("SiO2", "Si", light)
        verdicts = judge(SIO2_ON_SI, colours)
        lines.append(score(f"SiO2 on Si, {label}", SIO2_ON_SI, verdicts))
        thin = [row for row in SIO2_ON_SI if row.at <= 750]
        lines.append(score(f"SiO2 on Si, {label}, up to 750 nm", thin, verdicts[: len(thin)]))
    lines.append(score("titanium, 2 nm/V as the chart has it", TITANIUM, judge(TITANIUM, anodised(2.0, 0.0))))
    fitted = judge(TITANIUM, anodised(2.4, 5.0))
    lines.append(score("titanium, 2.4 nm/V + 5 nm, fitted to the chart", TITANIUM, fitted))
    return "\n".join(lines)


def table_chance() -> str:
    lines = ["| names of SiO2 on Si | rows that say yes, D65 | F2 |", "|---|---|---|"]
    both = [lch("SiO2", "Si", light) for light in ("D65", "FL2")]
    dealt = [shuffled(SIO2_ON_SI, colours) for colours in both]
    lines.append(f"| dealt at random, mean of {dealt[0].size} | {dealt[0].mean():.1f} | {dealt[1].mean():.1f} |")
    lines.append(f"| dealt at random, best of {dealt[0].size} | {dealt[0].max():.0f} | {dealt[1].max():.0f} |")
    for scale in (0.94, 0.96, 0.98, 1.0, 1.01, 1.02, 1.03, 1.04, 1.06):
        day, night = (count(judge(SIO2_ON_SI, lambda nm, f=f, scale=scale: f(scale * nm)), "yes") for f in both)
        name = "as printed" if scale == 1.0 else f"as printed, all thicknesses times {scale}"
        lines.append(f"| {name} | {day} | {night} |")
    return "\n".join(lines)


# The pairs (nm per volt, native nm) that were tried on the titanium chart: the usual bounds.
TITANIUM_PAIRS = [(1.5 + 0.1 * step, native_nm) for step in range(11) for native_nm in (0.0, 2.0, 4.0, 5.0)]


def titanium_by_chance(rounds: int = 1000, seed: int = 1) -> Floats:
    """The best strict score over all the pairs when the names are dealt out at random, once per round.

    A rule that was picked from many must be held against names that had the same choice.
    """
    random = np.random.default_rng(seed)
    at = np.array([row.at for row in TITANIUM])
    # hits[pair, row, name]: does this name fit the colour that this pair gives this row?
    hits = np.array(
        [
            [[fits(name, float(h), float(c)) for name in TITANIUM] for _, c, h in anodised(*pair)(at)]
            for pair in TITANIUM_PAIRS
        ]
    )
    places = np.arange(len(TITANIUM))
    return np.array([hits[:, places, random.permutation(places)].sum(axis=1).max() for _ in range(rounds)], dtype=float)


def table_titanium_chance() -> str:
    printed = [count(judge(TITANIUM, anodised(*pair)), "yes") for pair in TITANIUM_PAIRS]
    dealt = titanium_by_chance()
    lines = [f"| names of the chart, best of {len(TITANIUM_PAIRS)} pairs | rows that say yes |", "|---|---|"]
    lines.append(f"| as printed | {max(printed)} |")
    lines.append(f"| dealt at random, mean of {dealt.size} | {dealt.mean():.1f} |")
    lines.append(f"| dealt at random, share that does as well | {(dealt >= max(printed)).mean():.1%} |")
    return "\n".join(lines)


def table_lamps() -> str:
    lines = ["| lamp | yes | yes or row | 800 nm, orange | 820 nm, salmon |", "|---|---|---|---|---|"]
    for light in ("A", "C", "D65", "FL1", "FL2", "FL3", "FL4", "FL7", "FL11"):
        verdicts = judge(SIO2_ON_SI, lch("SiO2", "Si", light))
        answer = {row.at: verdict.answer for row, verdict in zip(SIO2_ON_SI, verdicts, strict=True)}
        lines.append(
            f"| {light} | {count(verdicts, 'yes')} | {count(verdicts, 'yes', 'row')} | {answer[800.0]} | {answer[820.0]} |"
        )
    return "\n".join(lines)


def table_titanium() -> str:
    nominal, fitted = judge(TITANIUM, anodised(2.0, 0.0)), judge(TITANIUM, anodised(2.4, 5.0))
    lines = ["| V | name in the chart | hue range | 2 nm/V: hue, chroma | agrees | 2.4 nm/V + 5 nm | agrees |"]
    lines += ["|---|---|---|---|---|---|---|"]
    for row, one, two in zip(TITANIUM, nominal, fitted, strict=True):
        lines.append(
            f"| {row.at:.0f} | {row.wording} | {range_text(row)} | {cell(one)} | {one.answer} | {cell(two)} | {two.answer} |"
        )
    return "\n".join(lines)


def ordered(rows: list[Row], colours: Colours, up_to_nm: float) -> str:
    thickness_nm = np.arange(0.0, up_to_nm + 0.5, 0.5)
    computed = colours(thickness_nm)
    lines = ["| name | hue range | oxide, nm | lightness L* |", "|---|---|---|---|"]
    for row, stretch in zip(rows, in_order(rows, thickness_nm, computed), strict=True):
        if stretch.size:
            first, last = (int(np.searchsorted(thickness_nm, nm)) for nm in (stretch[0], stretch[-1]))
            place = f"{stretch[0]:.1f} to {stretch[-1]:.1f}"
            lightness = f"{computed[first, 0]:.0f} to {computed[last, 0]:.0f}"
        else:
            place = lightness = "not met"
        lines.append(f"| {row.wording} | {range_text(row)} | {place} | {lightness} |")
    return "\n".join(lines)


def table_oil() -> str:
    bands = (
        ("none", 0.0, 0.04, "water bare"),
        ("1 sheen (silvery, grey)", 0.04, 0.3, "0.04 to 0.30 um"),
        ("2 rainbow", 0.3, 5.0, "0.30 to 5.0 um"),
        ("3 metallic", 5.0, 50.0, "5 to 50 um"),
    )
    um = np.concatenate([np.arange(0.0, 5.0, 0.01), np.arange(5.0, 50.01, 0.05)])
    colours = oil(1000.0 * um)
    lines = ["| code | thickness | least chroma | most chroma | at |", "|---|---|---|---|---|"]
    for name, low, high, text in bands:
        inside = (um >= low - 1e-9) & (um < high - 1e-9)
        chroma = colours[inside, 1]
        most = um[inside][chroma.argmax()]
        lines.append(f"| {name} | {text} | {chroma.min():.1f} | {chroma.max():.1f} | {most:.2f} um |")
    vivid = um[colours[:, 1] >= NEUTRAL_CHROMA]
    lines.append(
        f"| neutral (chroma below {NEUTRAL_CHROMA:.0f}) | up to {vivid.min():.2f} um, from {vivid.max():.2f} um on | | | |"
    )
    seen = um[colours[:, 1] >= 1.0]
    lines.append(f"| no colour at all (chroma below 1) | from {seen.max():.2f} um on | | | |")
    return "\n".join(lines)


TABLES = {
    "sio2": table_sio2,
    "shares": table_shares,
    "chance": table_chance,
    "lamps": table_lamps,
    "titanium": table_titanium,
    "titanium-chance": table_titanium_chance,
    "titanium-sequence": lambda: ordered(TITANIUM_SEQUENCE, lch("TiO2", "Ti"), 300.0),
    "temper": lambda: ordered(TEMPER, lch("Fe3O4", "Fe"), 110.0),
    "oil": table_oil,
    "families": lambda: "\n".join(
        ["| begins at | family |", "|---|---|", *(f"| {hue} | {family} |" for family, hue in FAMILIES.items())]
    ),
    "names": lambda: "\n".join(
        ["| name | families |", "|---|---|", *(f"| {name} | {', '.join(f)} |" for name, f in HUE_NAMES.items())]
    ),
}


def renewed(page: str) -> str:
    """The page with every table between `<!-- table: NAME -->` and `<!-- end -->` as computed."""

    def table(match: re.Match[str]) -> str:
        return f"{match[1]}\n\n{TABLES[match[2]]()}\n\n<!-- end -->"

    return re.sub(r"(<!-- table: ([\w-]+) -->).*?<!-- end -->", table, page, flags=re.S)


def main() -> int:
    page = PAGE.read_text()
    new = renewed(page)
    if "--check" in sys.argv:
        return int(new != page)
    PAGE.write_text(new)
    return 0


if __name__ == "__main__":
    sys.exit(main())

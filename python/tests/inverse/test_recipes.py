"""`ir.recipes`: planted films come back, yields are those of draws, what is not reachable is said. Scores: bench/recipes.py."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import iridesce as ir
from conftest import Run
from iridesce.color import film_tables
from iridesce.files import cache


def color_of(text: str) -> Any:
    return ir.Stack.parse(text).color(space="lab")


@pytest.mark.parametrize(
    ("text", "media", "substrate"),
    [
        ("air / SiO2 137.3 / Si", ["SiO2"], "Si"),
        ("air / SiO2 291.7 / TiO2 61.2 / Si", ["TiO2", "SiO2"], "Si"),
        ("air / TiO2 18.4 / MgF2 322.9 / N-BK7", ["TiO2", "MgF2"], "N-BK7"),
    ],
)
def test_a_planted_film_is_found(text: str, media: list[str], substrate: str) -> None:
    stack = ir.Stack.parse(text)
    found = ir.recipes(color_of(text), media=media, substrate=substrate, count=None)
    wanted = [float(layer.thickness_nm) for layer in stack.layers]
    near = [one for one in found if len(one.thickness_nm) == len(wanted)]
    near = [one for one in near if np.abs(np.subtract(one.thickness_nm, wanted)).max() < 0.1]
    assert any(one.stack.media == stack.media and one.delta_e < 1e-3 for one in near)
    assert all(one.reachable for one in found)
    shares = [one.yield_ for one in found]
    assert shares == sorted(shares, reverse=True)
    assert ir.recipes(color_of(text), media=media, substrate=substrate, count=1)[0].yield_ == shares[0]


def test_three_layers_of_which_one_is_given() -> None:
    text = "air / MgF2 90 / TiO2 60 / SiO2 150 / Si"
    found = ir.recipes(
        color_of(text), media=["MgF2", "TiO2", "SiO2"], substrate="Si", layers=3, thickness_range_nm=(40.0, 200.0)
    )
    choices = [tuple(layer.medium.name for layer in one.stack.layers) for one in found]
    assert len(set(choices)) == len(choices) and ("MgF2", "TiO2", "SiO2") in choices
    assert all(one.delta_e <= 2.0 for one in found)


def test_the_yield_is_the_share_of_draws() -> None:
    target = color_of("air / SiO2 180 / TiO2 90 / Si")
    random = np.random.default_rng(1)
    for one in ir.recipes(target, media=["SiO2", "TiO2"], substrate="Si", sigma=0.02, count=2):
        drawn = [h * (1.0 + 0.02 * random.standard_normal(10_000)) for h in one.thickness_nm]
        layers = [ir.Layer(layer.medium, h) for layer, h in zip(one.stack.layers, drawn, strict=True)]
        lab = ir.Stack([one.stack.first, *layers, one.stack.last]).color(
            space="lab", wavelength_nm=film_tables.COARSE_NM
        )
        share = float((ir.color.delta_e(lab, target) <= 2.0).mean())
        # Four standard deviations of a share of 10 000.
        assert abs(one.yield_ - share) < 4.0 * np.sqrt(0.25 / 10_000)
        assert 0.02 < share < 0.98, "a share near the ends would prove nothing"


def test_slopes_are_those_of_the_colour() -> None:
    one = ir.recipes(color_of("air / SiO2 180 / TiO2 90 / Si"), media=["SiO2", "TiO2"], substrate="Si", count=1)[0]
    for place, slope in enumerate(one.delta_e_per_nm):
        moved = list(one.thickness_nm)
        moved[place] += 0.2
        layers = [ir.Layer(layer.medium, h) for layer, h in zip(one.stack.layers, moved, strict=True)]
        lab = ir.Stack([one.stack.first, *layers, one.stack.last]).color(space="lab")
        assert slope == pytest.approx(ir.color.delta_e(lab, one.lab) / 0.2, rel=0.1)


def test_what_is_not_reachable_is_said() -> None:
    found = ir.recipes([90.0, 80.0, 0.0], media=["SiO2"], substrate="Si")
    assert len(found) == 1 and not found[0].reachable and "not reachable" in found.notes[0]
    # No film on a fine grid is nearer.
    h = np.linspace(5.0, 400.0, 4000)
    lab = ir.Stack(["air", ir.Layer("SiO2", h), "Si"]).color(space="lab", wavelength_nm=film_tables.COARSE_NM)
    assert found[0].delta_e < ir.color.delta_e(lab, [90.0, 80.0, 0.0]).min() + 0.3
    assert "SiO2" in found._repr_html_()


def test_volts_of_coupons() -> None:
    random = np.random.default_rng(2)
    volts = np.arange(10.0, 70.0, 10.0)
    nm = 1.9 * volts + 6.0 + 1.5 * random.standard_normal(volts.size)
    target = color_of("air / TiO2 82 / Ti")
    how: dict[str, Any] = {"media": ["TiO2"], "substrate": "Ti", "layers": (1,)}
    by_nm = ir.recipes(target, **how, coupons=list(zip(volts, nm, strict=True)))[0]
    assert by_nm.volts is not None and by_nm.volts_sd is not None
    assert abs(by_nm.volts - (82.0 - 6.0) / 1.9) < 3.0 * by_nm.volts_sd and 0.3 < by_nm.volts_sd < 2.5
    labs = ir.Stack(["air", ir.Layer("TiO2", nm), "Ti"]).color(space="lab")
    by_color = ir.recipes(target, **how, coupons=list(zip(volts, labs, strict=True)))[0]
    assert by_color.volts == pytest.approx(by_nm.volts, abs=0.2)
    two = ir.recipes(target, **how, coupons=[(20.0, 40.0), (40.0, 80.0)])[0]
    assert two.volts == pytest.approx(41.0, abs=0.1)


def test_the_observer_and_light_of_the_target_are_those_of_the_films() -> None:
    how = {"illuminant": "A", "observer": "cie1964", "angle_deg": 30.0}
    target = ir.Stack.parse("air / SiO2 200 / Si").color(space="xyz", **how)
    found = ir.recipes(target, media=["SiO2"], substrate="Si", space="xyz", layers=(1,), **how)
    assert found[0].thickness_nm[0] == pytest.approx(200.0, abs=0.05)
    assert found[0].color == pytest.approx(target, abs=1e-4)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"media": []}, "media must be"),
        ({"media": "SiO2"}, "media must be"),
        ({"media": ["unobtainium"]}, "unknown medium"),
        ({"layers": (4,)}, "layers must be"),
        ({"thickness_range_nm": (400.0, 5.0)}, "thickness_range_nm must be"),
        ({"sigma": -0.1}, "sigma must be"),
        ({"sigma": 0.01, "sigma_nm": 1.0}, "left out beside sigma, got both"),
        ({"max_delta_e": np.nan}, "max_delta_e must be"),
        ({"target": [np.nan, 0.0, 0.0]}, "target must be"),
        ({"target": [4500.0, 0.0, 0.0]}, "lightness"),
        ({"space": "cmyk"}, "space"),
        ({"count": 0}, "count must be"),
        ({"coupons": [(10.0, 20.0)]}, "two voltages"),
        ({"coupons": [(10.0, 20.0), (20.0, 10.0)]}, "thicker"),
        ({"coupons": [(10.0, 20.0), (20.0, (50.0, 0.0, 0.0))]}, "coupons must be"),
        ({"media": ["Si"]}, "two faces"),
    ],
)
def test_bad_input(changed: dict[str, Any], words: str) -> None:
    given: dict[str, Any] = {"target": [45.0, 0.0, -30.0], "media": ["SiO2"], "substrate": "Si", "layers": (1,)}
    given.update(changed)
    with pytest.raises(ValueError, match=words):
        ir.recipes(given.pop("target"), **given)


def test_too_many_tables_are_refused() -> None:
    media = [1.3 + 0.05 * step for step in range(20)]
    with pytest.raises(ir.ResourceError, match="fewer media"):
        ir.recipes([45.0, 0.0, -30.0], media=media, substrate="Si", layers=(1, 2, 3))


def test_the_edge_of_the_reachable_colours() -> None:
    ax = ir.plot.reachable(media=["SiO2"], substrate="Si", layers=1, target=[45.0, 50.0, -30.0])
    assert {one.get_gid() for one in ax.get_children()} >= {"reachable", "edge", "target"}
    picture = next(one for one in ax.images if one.get_gid() == "reachable").get_array()
    held = np.asarray(picture)[..., 3] > 0
    lab = color_of("air / SiO2 100 / Si")
    half = held.shape[0] // 2
    assert held[round(lab[2] / 2.0) + half, round(lab[1] / 2.0) + half]
    assert 0 < held.sum() < 0.1 * held.size


def test_the_verb(iridesce: Run) -> None:
    found = iridesce(
        "recipes", "lab 45 20 -30", "--media", "SiO2", "--substrate", "Si", "--max-delta-e", "40", "--json"
    )
    assert found.returncode == 0 and '"reachable": true' in found.stdout
    assert iridesce("recipes", "lab 45", "--media", "SiO2", "--substrate", "Si").returncode == 2
    assert iridesce("recipes", "lab 45 0 0", "--media", "xx", "--substrate", "Si").returncode == 3


# --- what is kept


def test_what_is_kept_comes_back_and_what_is_torn_does_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path / "kept"))
    assert cache.load("a") is None
    assert cache.keep("a", b"123") and cache.load("a") == b"123"
    path = tmp_path / "kept" / "a.cache"
    content = path.read_bytes()
    for torn in (content[:-1], content[:10], b"", content[:-1] + b"4"):
        path.write_bytes(torn)
        assert cache.load("a") is None
    monkeypatch.setenv(cache.VARIABLE, str(path / "below a file"))
    assert not cache.keep("a", b"1") and cache.load("a") is None


def test_the_longest_unused_goes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import os

    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))
    monkeypatch.setattr(cache, "LIMIT_BYTES", 500)
    for place, name in enumerate("abc"):
        cache.keep(name, bytes(100))
        os.utime(tmp_path / f"{name}.cache", (1000.0 + place, 1000.0 + place))
    assert cache.load("a") is not None  # used: now the youngest
    cache.keep("d", bytes(100))
    assert cache.load("a") is not None and cache.load("b") is None and cache.load("d") is not None
    assert cache.used_bytes() <= 500 and not cache.keep("e", bytes(600))


def test_many_may_keep_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))

    def work(seed: int) -> bool:
        kept = cache.load("a")
        return cache.keep("a", bytes(50_000)) and (kept is None or kept == bytes(50_000))

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(work, range(64)))
    assert [path.name for path in tmp_path.iterdir()] == ["a.cache"]

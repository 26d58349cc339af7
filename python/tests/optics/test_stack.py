"""Stacks from Python: numbers against independent programs, broadcasting, and what bad input meets."""

from __future__ import annotations

import copy
import json
import math
import os
import pickle
import signal
import threading
import time
from typing import Any

import numpy as np
import pytest
import tmm

import iridesce as ir
from conftest import ROOT

REFERENCE = json.loads((ROOT / "crates/optics/tests/reference/optics_reference.json").read_text())

POWERS = ("reflectance", "transmittance", "absorptance")


def number(pair: list[float]) -> complex | float:
    return complex(*pair) if pair[1] else pair[0]


def film(thickness_nm: Any = 320.0) -> ir.Stack:
    return ir.Stack(["air", ir.Layer("soap", thickness_nm=thickness_nm), "air"])


def mixed() -> ir.Stack:
    """Dispersive, absorbing, three layers."""
    return ir.Stack(["air", ir.Layer("TiO2", 60.0), ir.Layer(0.06 + 3.6j, 12.0), ir.Layer("SiO2", 90.0), "Si"])


# --- reference vectors, through the public face


@pytest.mark.parametrize("case", REFERENCE["cases"], ids=lambda case: case["id"])
def test_reference_case(case: dict[str, Any]) -> None:
    media = [number(pair) for pair in case["n"]]
    layers = [ir.Layer(n, d) for n, d in zip(media[1:-1], case["d_nm"], strict=True)]
    stack = ir.Stack([media[0], *layers, media[-1]])
    at = (case["wavelength_nm"], case["angle_deg"], case["pol"])
    assert abs(stack.reflectance(*at) - float(case["R40"])) <= 1e-12 + 1e3 * case["dR_ulp"]
    through, expected = stack.transmittance(*at), float(case["T40"])
    assert abs(through - expected) <= 1e-12 + 1e3 * case["dT_ulp"]
    if expected > 1e-300:
        assert abs(through / expected - 1.0) <= 1e-9
    r, t = stack.amplitudes(*at)
    assert abs(r - complex(*case["r"])) <= 1e-11 + 1e3 * case["dR_ulp"]
    if abs(complex(*case["t"])) > 1e-290:
        assert abs(t / complex(*case["t"]) - 1.0) <= 1e-9
    absorbed = stack.layer_absorptance(*at)
    if "A_layer" in case:
        np.testing.assert_allclose(absorbed, case["A_layer"], rtol=0, atol=1e-11)
    # One is summed layer by layer, the other is what enters less what leaves, and each may err as R and T may.
    allowed = 1e-12 + 1e3 * (case["dR_ulp"] + case["dT_ulp"])
    assert stack.absorptance(*at) == pytest.approx(absorbed.sum(), rel=0, abs=allowed)


@pytest.mark.parametrize("case", REFERENCE["ellipsometry"], ids=lambda case: case["id"])
def test_reference_ellipsometry(case: dict[str, Any]) -> None:
    media = [number(pair) for pair in case["n"]]
    layers = [ir.Layer(n, d) for n, d in zip(media[1:-1], case["d_nm"], strict=True)]
    psi, delta = ir.Stack([media[0], *layers, media[-1]]).ellipsometry(case["wavelength_nm"], case["angle_deg"])
    assert abs(psi - case["psi_deg"]) <= 1e-9
    assert abs(delta - case["delta_deg"]) <= 1e-9


@pytest.mark.parametrize("case", REFERENCE["incoherent"], ids=lambda case: case["id"])
def test_reference_slab(case: dict[str, Any]) -> None:
    def coherent(entries: list[Any]) -> list[ir.Layer]:
        return [ir.Layer(number(n), d) for n, d in entries]

    slab = ir.Layer(number(case["slab"][0]), case["slab"][1], coherent=False)
    layers = [*coherent(case["front"]), slab, *coherent(case["back"])]
    stack = ir.Stack([number(case["n_in"]), *layers, number(case["n_out"])])
    at = (case["wavelength_nm"], case["angle_deg"], case["pol"])
    assert abs(stack.reflectance(*at) - case["R"]) <= 1e-11
    assert abs(stack.transmittance(*at) - case["T"]) <= 1e-11
    assert abs(stack.reflectance(*at) + stack.transmittance(*at) + stack.absorptance(*at) - 1.0) <= 1e-12


# --- package tmm, on well-conditioned stacks


def random_stack(rng: np.random.Generator) -> tuple[list[complex], list[float], float, float]:
    count = int(rng.integers(1, 6))
    n = [complex(rng.uniform(1.2, 2.6), rng.choice([0.0, rng.uniform(0, 1.5)])) for _ in range(count)]
    media = [1.0, *n, complex(rng.uniform(1.2, 4.0), rng.choice([0.0, 2.0]))]
    return media, list(rng.uniform(5, 300, count)), float(rng.uniform(400, 700)), float(rng.uniform(0, 80))


@pytest.mark.parametrize("seed", range(40))
def test_against_tmm(seed: int) -> None:
    media, d_nm, wavelength, angle = random_stack(np.random.default_rng(seed))
    stack = ir.Stack([media[0], *map(ir.Layer, media[1:-1], d_nm), media[-1]])
    mean = {"R": 0.0, "T": 0.0}
    for pol in "sp":
        theirs = tmm.coh_tmm(pol, media, [np.inf, *d_nm, np.inf], math.radians(angle), wavelength)
        r, t = stack.amplitudes(wavelength, angle, pol)
        assert abs(r - theirs["r"]) < 1e-11
        assert abs(t - theirs["t"]) < 1e-11
        assert stack.reflectance(wavelength, angle, pol) == pytest.approx(theirs["R"], abs=1e-12)
        assert stack.transmittance(wavelength, angle, pol) == pytest.approx(theirs["T"], abs=1e-12)
        absorbed = tmm.absorp_in_each_layer(theirs)[1:-1]
        np.testing.assert_allclose(stack.layer_absorptance(wavelength, angle, pol), absorbed, rtol=0, atol=1e-11)
        mean["R"] += theirs["R"] / 2
        mean["T"] += theirs["T"] / 2
    assert stack.reflectance(wavelength, angle) == pytest.approx(mean["R"], abs=1e-12)
    assert stack.transmittance(wavelength, angle) == pytest.approx(mean["T"], abs=1e-12)
    theirs = tmm.ellips(media, [np.inf, *d_nm, np.inf], math.radians(angle), wavelength)
    psi, delta = stack.ellipsometry(wavelength, angle)
    assert psi == pytest.approx(math.degrees(theirs["psi"]), abs=1e-9)
    # Another sign of r_p there: their delta is ours less 180 degrees.
    assert math.isclose((delta - 180.0 - math.degrees(theirs["Delta"]) + 180.0) % 360.0, 180.0, abs_tol=1e-9)


@pytest.mark.parametrize("pol", ["s", "p"])
def test_two_slabs_against_tmm(pol: str) -> None:
    n = [1.0, 2.1, 1.5, 0.06 + 3.6j, 1.6, 1.38, 1.0]
    d_nm = [70.0, 1e6, 8.0, 2e6, 95.0]
    coherence = ["i", "c", "i", "c", "i", "c", "i"]
    theirs = tmm.inc_tmm(pol, n, [np.inf, *d_nm, np.inf], coherence, math.radians(40.0), 550.0)
    layers = [ir.Layer(*item) for item in zip(n[1:-1], d_nm, [c == "c" for c in coherence[1:-1]], strict=True)]
    stack = ir.Stack([n[0], *layers, n[-1]])
    assert stack.reflectance(550.0, 40.0, pol) == pytest.approx(theirs["R"], abs=1e-12)
    assert stack.transmittance(550.0, 40.0, pol) == pytest.approx(theirs["T"], abs=1e-12)
    absorbed = tmm.inc_absorp_in_each_layer(theirs)[1:-1]
    np.testing.assert_allclose(stack.layer_absorptance(550.0, 40.0, pol), absorbed, rtol=0, atol=1e-11)


# --- closed values


def test_closed_values() -> None:
    assert ir.Stack(["air", 1.5]).reflectance(550.0) == pytest.approx(0.04, abs=1e-15)
    assert film(5.0).reflectance(550.0) < 0.001, "a film of 5 nm is black"
    assert film(0.0).reflectance(550.0) == 0.0
    coat = ir.Stack(["air", ir.Layer(1.38, 550.0 / (4 * 1.38)), 1.52])
    assert coat.reflectance(550.0) == pytest.approx(0.0126, abs=5e-5)
    brewster = math.degrees(math.atan(1.5))
    assert ir.Stack(["air", 1.5]).reflectance(550.0, brewster, "p") < 1e-30
    # A bare clear slab, fringes averaged out: R = 2 r0/(1 + r0).
    slab = ir.Stack(["air", ir.Layer(1.5, 1e6, coherent=False), "air"])
    assert slab.reflectance(550.0) == pytest.approx(0.08 / 1.04, abs=1e-15)
    assert slab.absorptance(550.0) == 0.0


def test_light_from_the_other_side() -> None:
    stack = ir.Stack(["air", ir.Layer(2.1, 80.0), ir.Layer(0.06 + 3.6j, 12.0), 1.52])
    inside = math.degrees(math.asin(math.sin(math.radians(30.0)) / 1.52))
    for pol in "sp":
        assert stack.transmittance(550.0, 30.0, pol) == pytest.approx(
            stack.reversed().transmittance(550.0, inside, pol), rel=1e-12
        )
        assert abs(stack.reflectance(550.0, 30.0, pol) - stack.reversed().reflectance(550.0, inside, pol)) > 0.001
    assert stack.reversed().reversed() == stack


def test_two_beam_form() -> None:
    angle = np.array([0.0, 30.0, 60.0])
    stack = ir.Stack(["air", ir.Layer(1.38, 437.0), 1.52])
    r12, r23 = (1 - 1.38) / 2.38, (1.38 - 1.52) / 2.9
    cos_film = np.sqrt(1.0 - (np.sin(np.radians(angle)) / 1.38) ** 2)
    delta = 4 * np.pi * 1.38 * 437.0 * cos_film / 550.0
    eps = stack.two_beam_purity(550.0)
    assert eps == pytest.approx((r12 - r23) ** 2 / (4 * r12 * r23), rel=1e-14)
    expected = 4 * r12 * r23 * (eps + np.cos(delta / 2) ** 2)
    np.testing.assert_allclose(stack.two_beam_reflectance(550.0, angle), expected, rtol=0, atol=1e-15)
    assert film().two_beam_purity([500.0, 600.0]).tolist() == [-1.0, -1.0], "a free film is as pure as can be"
    with pytest.raises(ValueError, match="exactly one layer"):
        mixed().two_beam_reflectance(550.0)
    with pytest.raises(ValueError, match="real indices"):
        ir.Stack(["air", ir.Layer("TiO2", 60.0), "Ti"]).two_beam_reflectance(550.0)
    with pytest.raises(ValueError, match="real indices"):
        ir.Stack(["air", ir.Layer("TiO2", 60.0), "Ti"]).two_beam_purity(550.0)
    with pytest.raises(ValueError, match=r"does not reflect at index \(0,\)"):
        ir.Stack(["air", ir.Layer(1.5, 60.0), 1.5]).two_beam_purity([550.0])
    with pytest.raises(ValueError, match=r"critical angle.*at index \(1,\)"):
        ir.Stack([1.5, ir.Layer("air", 60.0), 1.5]).two_beam_reflectance(550.0, [10.0, 60.0])


# --- broadcasting


def test_scalars_give_scalars() -> None:
    stack = mixed()
    for name in POWERS:
        assert type(getattr(stack, name)(550.0, 30.0, "p")) is float
        assert type(getattr(stack, name)(np.float32(550.0), np.array(30), "p")) is float
    assert [type(value) for value in stack.amplitudes(550, 30, "s")] == [complex, complex]
    assert [type(value) for value in stack.ellipsometry(550, 30)] == [float, float]
    assert stack.layer_absorptance(550.0).shape == (3,)
    assert ir.Stack(["air", "soap"]).layer_absorptance([500.0, 600.0]).shape == (2, 0)
    assert type(film().two_beam_purity(550)) is float


def test_everything_broadcasts_like_numpy() -> None:
    wavelength = np.linspace(420.0, 680.0, 7)
    angle = np.array([0.0, 33.0, 61.0])[:, None]
    thick = np.array([10.0, 200.0])[:, None, None]
    thin = np.array([5.0, 9.0, 14.0])[:, None]
    stack = ir.Stack(["air", ir.Layer("SiO2", thick), ir.Layer("Ag", thin), "N-BK7"])
    for pol in ("s", "p", "unpolarized"):
        results = {name: getattr(stack, name)(wavelength, angle, pol) for name in POWERS}
        layers = stack.layer_absorptance(wavelength, angle, pol)
        assert layers.shape == (2, 3, 7, 2)
        for i, j, k in np.ndindex(2, 3, 7):
            one = ir.Stack(
                ["air", ir.Layer("SiO2", thick[i, 0, 0]), ir.Layer("Ag", thin[j, 0]), "N-BK7"],
            )
            for name, result in results.items():
                assert result.shape == (2, 3, 7)
                assert result.dtype == np.float64
                assert result[i, j, k] == getattr(one, name)(wavelength[k], angle[j, 0], pol)
            assert layers[i, j, k].tolist() == one.layer_absorptance(wavelength[k], angle[j, 0], pol).tolist()
    r, t = stack.amplitudes(wavelength, angle, "p")
    psi, delta = stack.ellipsometry(wavelength, angle)
    assert r.shape == t.shape == psi.shape == delta.shape == (2, 3, 7)
    assert r.dtype == np.complex128
    np.testing.assert_allclose(np.abs(r) ** 2, stack.reflectance(wavelength, angle, "p"), rtol=1e-14)
    assert (delta >= 0).all()
    assert (delta < 360).all()


def test_more_elements_than_a_task_and_odd_layouts() -> None:
    wavelength = np.linspace(400.0, 700.0, 2000)
    expected = np.array([mixed().reflectance(nm, 20.0) for nm in wavelength[::97]])
    assert mixed().reflectance(wavelength, 20.0)[::97].tolist() == expected.tolist()
    # Views that are not contiguous, reversed, transposed, of other types, read-only.
    assert (
        mixed().reflectance(wavelength[::-97], 20.0).tolist() == mixed().reflectance(wavelength, 20.0)[::-97].tolist()
    )
    grid = wavelength.reshape(40, 50)
    assert np.array_equal(mixed().reflectance(grid.T, 20.0), mixed().reflectance(grid, 20.0).T)
    whole = np.arange(400, 700, 50, dtype=np.int16)
    assert np.array_equal(mixed().reflectance(whole), mixed().reflectance(whole.astype(float)))
    assert np.array_equal(mixed().reflectance(whole.astype(">f8")), mixed().reflectance(whole.astype(float)))
    wavelength.flags.writeable = False
    assert mixed().reflectance(wavelength).shape == (2000,)


def test_inputs_are_not_changed_and_later_changes_do_not_matter() -> None:
    thickness = np.array([100.0, 200.0])
    wavelength = np.array([500.0, 600.0])
    stack = film(thickness)
    before = stack.reflectance(wavelength)
    thickness[:] = 999.0
    assert stack.reflectance(wavelength).tolist() == before.tolist()
    assert wavelength.tolist() == [500.0, 600.0]
    with pytest.raises(ValueError, match="read-only"):
        stack.layers[0].thickness_nm[0] = 1.0


@pytest.mark.parametrize("name", [*POWERS, "layer_absorptance"])
def test_any_number_of_threads_gives_the_same_bytes(name: str) -> None:
    wavelength = np.linspace(400.0, 700.0, 5001)
    results = [getattr(mixed(), name)(wavelength, 40.0, threads=threads).tobytes() for threads in (None, 1, 2, 5)]
    assert len(set(results)) == 1


@pytest.mark.parametrize("name", POWERS)
def test_out_is_written_and_returned(name: str) -> None:
    wavelength = np.linspace(400.0, 700.0, 31)
    out = np.full(31, np.nan)
    assert getattr(mixed(), name)(wavelength, 10.0, out=out) is out
    assert out.tolist() == getattr(mixed(), name)(wavelength, 10.0).tolist()
    scalar = np.empty(())
    assert getattr(mixed(), name)(550.0, out=scalar) is scalar
    assert float(scalar) == getattr(mixed(), name)(550.0)
    # Results over the input they were made from.
    both = wavelength.copy()
    getattr(mixed(), name)(both, 10.0, out=both)
    assert both.tolist() == out.tolist()


@pytest.mark.parametrize(
    ("out", "message"),
    [
        (np.empty(4), r"shape of the result, \(3,\), got \(4,\)"),
        (np.empty((3, 1)), "shape of the result"),
        (np.empty(3, np.float32), "float64, got float32"),
        (np.empty(3, ">f8"), "float64"),
        (np.empty(6)[::2], "C order"),
        ([0.0, 0.0, 0.0], "numpy array, got list"),
        (np.broadcast_to(np.float64(0.0), 3), "C order"),
    ],
)
def test_unfit_out_is_refused(out: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        film().reflectance([500.0, 550.0, 600.0], out=out)


def test_read_only_out_is_refused() -> None:
    out = np.zeros(3)
    out.flags.writeable = False
    with pytest.raises(ValueError, match="out must be writable"):
        film().reflectance([500.0, 550.0, 600.0], out=out)
    assert out.tolist() == [0.0, 0.0, 0.0]
    with pytest.raises(ValueError, match=r"\(3, 1\)"):
        film().layer_absorptance([500.0, 550.0, 600.0], out=np.empty(3))


# --- what cannot fit, and long work


def test_monstrous_results_are_refused_before_anything_is_allocated() -> None:
    side = np.broadcast_to(500.0, (10**6, 1))
    start = time.monotonic()
    with pytest.raises(ir.ResourceError, match=r"reflectance of shape \(1000000, 10000000\) needs .* GiB"):
        film().reflectance(side, np.broadcast_to(0.0, 10**7))
    with pytest.raises(ir.ResourceError):
        film(np.broadcast_to(100.0, (10**9, 10**9))).reflectance(500.0)
    with pytest.raises(ir.ResourceError):
        film(np.broadcast_to(100.0, (10**9, 10**9))).amplitudes(500.0, 0.0, "s")
    with pytest.raises(ir.ResourceError):
        film(np.broadcast_to(100.0, (10**9, 10**9))).layer_absorptance(500.0)
    assert time.monotonic() - start < 1.0
    assert issubclass(ir.ResourceError, ValueError)


def long_job() -> ir.Stack:
    return ir.Stack(["air", *(ir.Layer(1.4 + 0.1 * (j % 2), 80.0 + j) for j in range(30)), 1.5])


def test_ctrl_c_stops_long_work() -> None:
    wavelength = np.linspace(400.0, 700.0, 10**7)
    out = np.empty(10**7)
    sent: list[float] = []

    def interrupt() -> None:
        time.sleep(0.3)
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        long_job().reflectance(wavelength, out=out)
    stopped = time.monotonic()
    thread.join()
    assert stopped - sent[0] < 2.0, "the whole job takes tens of seconds"


def test_other_threads_run_meanwhile() -> None:
    ticks: list[float] = []
    done = threading.Event()

    def tick() -> None:
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    # On a machine with much else to do the other thread may not get its turn in one of them.
    for _ in range(20):
        start = time.monotonic()
        long_job().reflectance(np.linspace(400.0, 700.0, 200_000))
        end = time.monotonic()
        if sum(start < t < end for t in ticks) >= 5:
            break
    done.set()
    thread.join()
    assert sum(start < t < end for t in ticks) >= 5, "the interpreter was held all the time"


# --- bad input


@pytest.mark.parametrize(
    ("wavelength", "angle", "message"),
    [
        (0.0, 0.0, "wavelength_nm must be > 0 and finite, got 0.0"),
        ([500.0, -1.0], 0.0, r"wavelength_nm must be > 0 and finite, got -1.0 at index \(1,\)"),
        (math.nan, 0.0, "wavelength_nm must be > 0 and finite, got nan"),
        (math.inf, 0.0, "wavelength_nm .* got inf"),
        ([], 0.0, r"wavelength_nm must not be empty, got shape \(0,\)"),
        (np.empty((3, 0)), 0.0, r"empty, got shape \(3, 0\)"),
        ("550", 0.0, "wavelength_nm must be real numbers"),
        (None, 0.0, "wavelength_nm must be real numbers"),
        (True, 0.0, "wavelength_nm must be real numbers"),
        (550.0 + 1j, 0.0, "wavelength_nm must be real numbers"),
        ([[500.0], [500.0, 600.0]], 0.0, "wavelength_nm must be"),
        (10**400, 0.0, "wavelength_nm must be real numbers"),
        (np.longdouble("1e4000"), 0.0, "wavelength_nm .* finite"),
        (np.ma.masked_array([500.0, 600.0], [True, False]), 0.0, "masked"),
        (550.0, -1e-9, "angle_deg must be >= 0 and < 90, got -1e-09"),
        (550.0, 90.0, "angle_deg must be >= 0 and < 90, got 90.0"),
        (550.0, [[0.0, 95.0]], r"angle_deg must be >= 0 and < 90, got 95.0 at index \(0, 1\)"),
        (550.0, math.nan, "angle_deg .* got nan"),
        (550.0, math.inf, "angle_deg .* got inf"),
        ([500.0, 600.0], [0.0, 1.0, 2.0], r"wavelength_nm and angle_deg must broadcast: shapes \(2,\) and \(3,\)"),
    ],
)
def test_bad_arguments_are_named(wavelength: Any, angle: Any, message: str) -> None:
    for name in [*POWERS, "layer_absorptance", "ellipsometry"]:
        with pytest.raises(ValueError, match=message):
            getattr(mixed(), name)(wavelength, angle)
    with pytest.raises(ValueError, match=message):
        mixed().amplitudes(wavelength, angle, "s")


def test_shapes_of_layers_are_named() -> None:
    stack = ir.Stack(["air", ir.Layer(1.4, np.ones((2, 1))), ir.Layer(1.5, np.ones(3)), "air"])
    message = r"wavelength_nm, thickness_nm of layer 1 and thickness_nm of layer 2 must broadcast"
    with pytest.raises(ValueError, match=message):
        stack.reflectance([400.0, 500.0])
    with pytest.raises(ValueError, match=r"wavelength_nm and thickness_nm must broadcast: shapes \(2,\) and \(3,\)"):
        film(np.ones(3)).reflectance([400.0, 500.0])


@pytest.mark.parametrize("polarization", ["S", "TE", "", "unpolarised", None, 0, ["s"]])
def test_only_three_polarizations(polarization: Any) -> None:
    with pytest.raises(ValueError, match='polarization must be "s", "p" or "unpolarized", got'):
        film().reflectance(550.0, 0.0, polarization)
    with pytest.raises(ValueError, match="polarization must be"):
        film().amplitudes(550.0, 0.0, polarization)


def test_amplitudes_of_unpolarized_light_do_not_exist() -> None:
    with pytest.raises(ValueError, match="unpolarized"):
        film().amplitudes(550.0, 0.0, "unpolarized")


@pytest.mark.parametrize("threads", [0, -1, 1.5, "2", True, 10**6])
def test_bad_threads(threads: Any) -> None:
    with pytest.raises(ValueError, match="threads must be a whole number from 1 to 1024, or None"):
        film().reflectance(550.0, threads=threads)


def test_incoherent_stacks_have_no_phase() -> None:
    slab = ir.Stack(["air", ir.Layer("N-BK7", 1e6, coherent=False), "air"])
    with pytest.raises(ValueError, match=r"amplitudes of a stack need coherent layers; layer 1, .*N-BK7"):
        slab.amplitudes(550.0, 0.0, "s")
    with pytest.raises(ValueError, match="ellipsometry of a stack need coherent layers"):
        slab.ellipsometry(550.0, 0.0)


def test_ellipsometry_without_reflection_has_no_value() -> None:
    with pytest.raises(ValueError, match=r"nothing is reflected \(at index \(0,\)\)"):
        film(np.array([0.0, 100.0])).ellipsometry(550.0, 50.0)


def test_first_and_last_medium() -> None:
    with pytest.raises(ValueError, match=r"first medium must have real n > 0 and k = 0, got .*1.5"):
        ir.Stack([1.5 + 1e-9j, 1.0])
    with pytest.raises(ValueError, match="first medium"):
        ir.Stack(["air", ir.Layer(1.4, 10.0), 2.0 + 3.0j]).reversed()
    with pytest.raises(ValueError, match=r"first medium must have real n > 0 and k = 0, got .*wavelength_nm = 550"):
        ir.Stack(["Ag", "air"]).reflectance(550.0)
    with pytest.raises(ValueError, match="last medium must have k >= 0"):
        ir.Stack(["air", 1.5 - 0.1j])
    with pytest.raises(ValueError, match="incoherent slab must have k >= 0"):
        ir.Stack(["air", ir.Layer(1.5 - 0.1j, 10.0, coherent=False), "air"]).reflectance(550.0)
    gain = ir.Stack(["air", ir.Layer(1.5 - 0.01j, 300.0), "air"])
    assert gain.reflectance(550.0) + gain.transmittance(550.0) > 1.0
    assert gain.absorptance(550.0) < 0.0


def test_wavelengths_outside_the_data_name_medium_and_range() -> None:
    with pytest.raises(ValueError, match=r'medium "Ag" has data for 187.9-1937 nm; .* got 2000.0 at index \(1,\)'):
        ir.Stack(["air", ir.Layer("Ag", 20.0), "air"]).reflectance([550.0, 2000.0])


def test_extremes_are_finite() -> None:
    stacks = [
        ir.Stack(["air", ir.Layer(3.5 + 2.7j, 1e9), ir.Layer("soap", 300.0), "air"]),  # opaque tungsten on top
        ir.Stack([1.5, ir.Layer("air", 1e12), 1.5]),
        ir.Stack([1.5, ir.Layer(2.0, 0.0), 1.0 + 3e-8j]),
        ir.Stack([2.5, ir.Layer(1.25, 210.0), 2.2]),  # the layer at its critical angle, 30 degrees
    ]
    for stack in stacks:
        for angle in (0.0, 30.0, 60.0, 89.999999, np.nextafter(90.0, 0.0)):
            for pol in ("s", "p", "unpolarized"):
                r, t, a = (getattr(stack, name)(550.0, angle, pol) for name in POWERS)
                assert 0.0 <= r <= 1.0
                assert 0.0 <= t <= 1.0
                assert abs(r + t + a - 1.0) < 1e-12
    with pytest.raises(
        ValueError, match=r"thickness_nm must be at most 1e30 wavelengths, got 1e\+?300 in layer 1 at 550 nm"
    ):
        film(1e300).reflectance(550.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("soap", -12.0), "thickness_nm must be >= 0 and finite, got -12.0"),
        (("soap", [[1.0, 2.0], [3.0, -4.0]]), r"thickness_nm must be >= 0 and finite, got -4.0 at index \(1, 1\)"),
        (("soap", math.nan), "thickness_nm .* got nan"),
        (("soap", math.inf), "thickness_nm .* got inf"),
        (("soap", []), "thickness_nm must not be empty"),
        (("soap", "thick"), "thickness_nm must be real numbers"),
        (("soap", None), "thickness_nm must be real numbers"),
        (("sopa", 100.0), "soap"),
        ((math.nan, 100.0), "NaN"),
        ((None, 100.0), "medium"),
        (("soap", 100.0, "no"), "coherent must be True or False, got 'no'"),
    ],
)
def test_bad_layers(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ir.Layer(*arguments)


@pytest.mark.parametrize(
    ("items", "message"),
    [
        ([], "needs a first and a last medium"),
        (["air"], "needs a first and a last medium"),
        ("air / soap 320 / air", "takes a list"),
        (3, "takes a list"),
        (["air", "soap", "air"], "item 1 of a Stack must be a Layer"),
        ([ir.Layer("soap", 1.0), "air"], "item 0 of a Stack must be a medium"),
        (["air", ir.Layer("soap", 1.0)], "item 1 of a Stack must be a medium"),
        (["air", None], "medium"),
    ],
)
def test_bad_stacks(items: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ir.Stack(items)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"quantity": "color"}, 'quantity must be "reflectance", "transmittance" or "absorptance"'),
        ({"model": "three-beam"}, 'model must be "exact" or "two-beam"'),
        ({"polarization": "x"}, "polarization must be"),
        ({"model": "two-beam", "polarization": "s"}, "knows no polarisation"),
        ({"model": "two-beam", "quantity": "transmittance"}, "gives the reflectance only"),
        ({"angle_deg": 90.0}, "angle_deg must be"),
        ({"angle_deg": [0.0, 1.0, 2.0]}, r"angle_deg and thickness_nm must broadcast: shapes \(3,\) and \(2,\)"),
    ],
)
def test_bad_color_requests(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        film(np.array([100.0, 200.0])).color(**arguments)
    with pytest.raises(ValueError, match="exactly one layer"):
        mixed().color(model="two-beam")


# --- the objects


def test_repr_equality_and_pickling() -> None:
    stack = ir.Stack(["air", ir.Layer("soap", thickness_nm=320.0), ir.Layer(2.0 + 3.0j, 1e6, coherent=False), 1.5])
    text = (
        "Stack(['air', Layer('soap', thickness_nm=320.0), Layer((2+3j), thickness_nm=1000000.0, coherent=False), 1.5])"
    )
    assert repr(stack) == text
    assert eval(text, {"Stack": ir.Stack, "Layer": ir.Layer}) == stack
    assert repr(ir.Layer("soap", [[1.0, 2.0]])) == "Layer('soap', thickness_nm=<(1, 2), 1 to 2>)"
    for one in (stack, film(np.arange(6.0).reshape(2, 3))):
        for twin in (pickle.loads(pickle.dumps(one)), copy.deepcopy(one), copy.copy(one)):
            assert twin == one
            assert hash(twin) == hash(one)
    assert film(320.0) != film(321.0)
    assert film([1.0, 2.0]) != film([1.0, 3.0])
    assert film([1.0, 2.0]) != film([[1.0, 2.0]])
    assert ir.Layer("soap", 1.0) != ir.Layer("water", 1.0)
    assert ir.Layer("soap", 1.0) != ir.Layer("soap", 1.0, coherent=False)
    assert film() != "film"
    assert stack.media == tuple(map(ir.Medium, ["air", "soap", 2.0 + 3.0j, 1.5]))


def test_stacks_cannot_be_changed() -> None:
    stack = film()
    for target, name in [
        (stack, "layers"),
        (stack, "new"),
        (stack.layers[0], "thickness_nm"),
        (stack.layers[0], "medium"),
    ]:
        with pytest.raises(AttributeError, match="cannot be changed"):
            setattr(target, name, 1)
    with pytest.raises(AttributeError, match="cannot be changed"):
        del stack.layers


# --- text


def test_stacks_from_text() -> None:
    assert ir.Stack.parse("air / soap 320 / air") == film()
    assert ir.Stack.parse("  air /  TiO2 60   / Ti ") == ir.Stack(["air", ir.Layer("TiO2", 60.0), "Ti"])
    assert ir.Stack.parse("1 / 1.5") == ir.Stack([1.0, 1.5])
    expected = ir.Stack(["air", ir.Layer(2.54 + 3.43j, 10.5), ir.Layer("N-BK7", 1e6, coherent=False), 0.06 + 3.6j])
    assert ir.Stack.parse("air / 2.54+3.43j 10.5 / N-BK7 1e6 incoherent / 0.06+3.6j") == expected


@pytest.mark.parametrize(
    "text",
    [
        "air/soap 320/air",
        "air /soap 320/ air",
        "air / soap 320nm / air",
        "air / soap 320 nm / air",
        "air / soap 0.32um / air",
        "air/soap 0.32 \u00b5m/air",
        "air / soap 3200A / air",
        "air / soap 3.2e-4mm / air",
    ],
)
def test_texts_of_people_mean_what_they_say(text: str) -> None:
    assert ir.Stack.parse(text) == ir.Stack.parse("air / soap 320 / air")


def test_a_slab_in_another_unit_is_incoherent() -> None:
    assert ir.Stack.parse("air / N-BK7 1mm incoherent / air").layers[0] == ir.Layer("N-BK7", 1e6, coherent=False)
    assert ir.Stack.parse("air / N-BK7 1 mm incoherent / air").layers[0] == ir.Layer("N-BK7", 1e6, coherent=False)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "two or more items"),
        ("air", "two or more items"),
        ("air/soap 320//air", "item 3 of the stack is empty"),
        ("air / / air", "item 2 of the stack is empty"),
        ("air / soap / air", "item 2 of the stack, 'soap': a layer needs its thickness in nm"),
        ("air / soap 320km / air", "item 2 .*thickness in nm must be a number, got '320km'"),
        ("air / soap 320 km / air", "item 2 .*only \"incoherent\" may follow, got 'km'"),
        ("air / soap -0.3um / air", "item 2 .*thickness_nm must be >= 0 and finite, got -300.0"),
        ("air / soap -5 / air", "item 2 .*thickness_nm must be >= 0 and finite, got -5.0"),
        ("air / soap nan / air", "item 2 .*thickness_nm must be >= 0 and finite, got nan"),
        ("air / soap 320 thick / air", "item 2 .*only \"incoherent\" may follow, got 'thick'"),
        ("air / soap 320 incoherent x / air", 'item 2 .*only "incoherent" may follow'),
        ("air 5 / soap 320 / air", "item 1 .*without thickness"),
        ("air / soap 320 / air 3", "item 3 .*without thickness"),
        ("air / 1.3+4x 320 / air", "item 2 .*an index is written n or n\\+kj, got '1.3\\+4x'"),
        ("air / sopa 320 / air", "item 2 .*sopa"),
        ("air / -1.5 320 / air", "item 2 .*-1.5"),
        (None, "looks like"),
    ],
)
def test_text_that_is_no_stack(text: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ir.Stack.parse(text)

"""Joint fits: measurements of one film share what they can, and each keeps its own gain."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import iridesce as ir
from iridesce.inverse.blocks import PowerBlock
from iridesce.inverse.full import full
from iridesce.inverse.members import members

Floats = npt.NDArray[np.float64]
NM = np.arange(420.0, 780.0, 6.0)
OXIDE = "air / SiO2 ? / Si"


def ellipsometry(
    text: str, angle_deg: float, seed: int = 1, noise: float = 0.05, told_deg: float | None = None
) -> list[ir.Measurement]:
    random = np.random.default_rng(seed)
    psi, delta = ir.Stack.parse(text).ellipsometry(NM, angle_deg)
    psi = psi + noise * random.standard_normal(NM.size)
    delta = (delta + 2.0 * noise * random.standard_normal(NM.size)) % 360.0
    told = angle_deg if told_deg is None else told_deg
    return [ir.Measurement("psi", NM, psi, told), ir.Measurement("delta", NM, delta, told)]


def power(
    text: str, quantity: str = "reflectance", angle_deg: float = 0.0, gain: float = 1.0, **how: Any
) -> ir.Measurement:
    random = np.random.default_rng(int(10.0 * angle_deg) + len(quantity))
    clean = getattr(ir.Stack.parse(text), quantity)(NM, angle_deg)
    return ir.Measurement(
        quantity, NM, gain * (clean + 0.002 * random.standard_normal(NM.size)), angle_deg=angle_deg, **how
    )


# Spectra of which some channels are full: plateaus of three and more.
FINE = np.arange(440.0, 780.0, 1.5)


def fine(text: str, quantity: str = "reflectance", angle_deg: float = 0.0, gain: float = 1.0) -> ir.Measurement:
    clean = np.asarray(getattr(ir.Stack.parse(text), quantity)(FINE, angle_deg))
    noise = 0.02 * np.std(clean) * np.random.default_rng(int(angle_deg) + len(quantity)).standard_normal(FINE.size)
    return ir.Measurement(quantity, FINE, gain * (clean + noise), angle_deg)


def fit(measurements: Any, stack: Any = OXIDE, **how: Any) -> Any:
    how.setdefault("thickness_range_nm", (1.0, 3000.0))
    # Films of the very index, spectrometers of the very wavelengths that were said.
    how.setdefault("index_tolerance", 0.0)
    how.setdefault("wavelength_tolerance_nm", 0.0)
    return ir.fit_thickness(measurements=measurements, stack=stack, **how)


@pytest.mark.parametrize("thickness_nm", [3.0, 25.0, 283.0, 1234.0])
def test_ellipsometry(thickness_nm: float) -> None:
    """From 3 nm on, through the place where delta passes 360 degrees (some 283 nm)."""
    result = fit(ellipsometry(OXIDE.replace("?", f"{thickness_nm}"), 65.0))
    assert result.verdict == "clear"
    best = result.best
    assert abs(best.thickness_nm - thickness_nm) < 4.0 * best.sd_nm and best.sd_nm < 0.1
    assert sum(one.weight for one in result) + result.no_film + result.other == pytest.approx(1.0, abs=1e-9)


@pytest.mark.slow
def test_intervals_of_joint_fits_hold_what_they_claim() -> None:
    """Of 60 intervals of 68 %, the share that holds the truth is within four standard deviations (0.24)."""
    held = 0
    for seed in range(60):
        thickness = 60.0 + 2.1 * seed
        result = fit(
            ellipsometry(OXIDE.replace("?", f"{thickness}"), 70.0, seed),
            probability=0.68,
            thickness_range_nm=(20.0, 260.0),
        )
        held += result.best.interval_nm[0] <= thickness <= result.best.interval_nm[1]
    assert 0.44 < held / 60.0 < 0.92


def test_powers_with_gains_of_their_own() -> None:
    text = "air / Ta2O5 777 / N-BK7"
    parts = [
        power(text, gain=30_000.0),
        power(text, angle_deg=45.0, gain=2.0),
        power(text, "transmittance", gain=1.0),
    ]
    result = fit(parts, "air / Ta2O5 ? / N-BK7", thickness_range_nm=(650.0, 950.0))
    assert result.verdict == "clear" and abs(result.best.thickness_nm - 777.0) < 4.0 * result.best.sd_nm
    assert result.best.gain == pytest.approx(30_000.0, rel=0.05)
    assert len(result.measurements) == 3 and result.measured.size == 3 * NM.size
    alone = fit(parts[:1], "air / Ta2O5 ? / N-BK7", thickness_range_nm=(650.0, 950.0))
    assert result.best.sd_nm < alone.best.sd_nm


def clipped(of: ir.Measurement, share: float) -> ir.Measurement:
    """Its channels full above this share of the range."""
    values = np.asarray(of.values)
    return replace(of, values=np.minimum(values, values.min() + share * np.ptp(values)))


@pytest.mark.parametrize(
    ("text", "thickness_nm", "which"),
    [
        ("air / SiO2 ? / Si", 640.0, (0,)),
        ("air / PMMA ? / N-BK7", 1197.0, (0, 1)),
        ("air / soap ? / air", 750.0, (1,)),
    ],
)
def test_full_channels_at_one_angle_are_limits(text: str, thickness_nm: float, which: tuple[int, ...]) -> None:
    parts = [fine(text.replace("?", f"{thickness_nm}"), angle_deg=angle, gain=3e4) for angle in (0.0, 45.0)]
    given = [clipped(one, 0.85) if place in which else one for place, one in enumerate(parts)]
    result = fit(given, text)
    assert result.verdict == "clear" and result.best.kappa == 1.0
    assert abs(result.best.thickness_nm - thickness_nm) < 4.0 * result.best.sd_nm < 8.0
    words = [note for note in result.notes if "channels are full" in note]
    assert len(words) == len(which) and all(note.startswith("reflectance, ") for note in words)
    # What is full is no value: of each measurement those are told that were used.
    assert result.points == tuple(
        int((np.asarray(one.values) < np.max(one.values)).sum()) if place in which else np.size(one.values)
        for place, one in enumerate(given)
    )
    assert result.measured.size == sum(result.points) == result.best.fitted.size
    assert sum(line.get_gid() == "fitted" for line in result.plot().get_lines()) == 2


def test_full_channels_of_reflectance_and_transmittance_are_limits() -> None:
    text = "air / Ta2O5 777 / N-BK7"
    gains = {"reflectance": 9e3, "transmittance": 5e4}
    parts = [clipped(fine(text, quantity, gain=gain), 0.8) for quantity, gain in gains.items()]
    result = fit(parts, "air / Ta2O5 ? / N-BK7")
    assert result.verdict == "clear" and result.best.kappa == 1.0
    assert abs(result.best.thickness_nm - 777.0) < 4.0 * result.best.sd_nm < 4.0
    assert sum("channels are full" in note for note in result.notes) == 2


def test_full_counts_beside_a_dark_and_a_reference_are_limits() -> None:
    """Divided by the lamp they are no plateau any more; the counts tell which they are."""
    random = np.random.default_rng(2)
    light = 4e4 * np.exp(-(((FINE - 590.0) / 160.0) ** 2))
    parts, divided = [], []
    for angle in (0.0, 50.0):
        seen, mirror = (
            light * ir.Stack.parse(text).reflectance(FINE, angle) + 300.0 + 15.0 * random.standard_normal(FINE.size)
            for text in ("air / SiO2 640 / Si", "air / Si")
        )
        full = np.minimum(seen, 0.75 * seen.max())
        how: Any = {"dark": 300.0 + 0.0 * FINE, "reference": mirror, "reference_stack": "air / Si"}
        parts.append(ir.Measurement("reflectance", FINE, full, angle, **how))
        share = (full - 300.0) / (mirror - 300.0) * np.asarray(ir.Stack.parse("air / Si").reflectance(FINE, angle))
        divided.append(ir.Measurement("reflectance", FINE, share, angle))
    near: Any = {"thickness_range_nm": (300.0, 1000.0)}
    result = fit(parts, **near)
    assert result.verdict == "clear" and result.best.thickness_nm == pytest.approx(640.0, rel=0.002)
    assert sum("channels are full" in note for note in result.notes) == 2
    assert fit(divided, **near).verdict == "doubtful"


def test_a_film_must_fill_the_channels_that_are_full() -> None:
    """Of two films that go with the channels that were measured, the one that is darker at the full ones is none."""
    text = "air / soap ? / air"
    dark, bright = (np.asarray(ir.Stack.parse(text.replace("?", h)).reflectance(FINE)) for h in ("640", "750"))
    over = (bright > 0.8 * bright.max()) & (dark < 0.5 * bright)
    assert 10 < over.sum() < 150
    values = np.where(over, 0.8 * bright.max(), np.minimum(bright, 0.79 * bright.max()))
    (member,) = members([ir.Measurement("reflectance", FINE, values, gain=1.0, baseline="none", noise=1e-3)], [])
    assert member.full is not None
    block = PowerBlock(member, 0.05)
    logs = []
    for h in (750.0, 640.0):
        spectrum = block.spectra(ir.Stack.parse(text.replace("?", f"{h}")), 0.0)[0]
        block.fix(spectrum)
        logs.append(block.log_full(spectrum))
    assert logs[0] > -1.0 and logs[1] < -50.0


def test_angles_of_ellipsometry_are_never_full() -> None:
    """Films whose psi stands at its largest value for many channels are films all the same."""
    values = np.where(FINE > 600.0, 90.0, 30.0 + 0.1 * FINE % 7.0)
    assert full(values).any()
    notes: list[str] = []
    found = members([ir.Measurement("psi", FINE, values, 65.0)], notes)[0]
    assert found.full is None and found.values.size == FINE.size and not notes


def test_an_index_is_found_with_the_thickness() -> None:
    parts = ellipsometry("air / 1.62 340 / Si", 70.0)
    result = fit(parts, "air / 1.55 ? / Si", index="constant", thickness_range_nm=(200.0, 500.0))
    assert result.best.thickness_nm == pytest.approx(340.0, abs=0.3)
    assert result.best.index[1]["n"] == pytest.approx(1.62, abs=1e-3)
    # Known to 2 %, it is found too, and what is not known of it widens the interval.
    loose = fit(
        ellipsometry("air / 1.56 340 / Si", 70.0),
        "air / 1.55 ? / Si",
        index_tolerance=0.02,
        thickness_range_nm=(200.0, 500.0),
    )
    tight = fit(ellipsometry("air / 1.55 340 / Si", 70.0), "air / 1.55 ? / Si", thickness_range_nm=(200.0, 500.0))
    assert abs(loose.best.thickness_nm - 340.0) < 4.0 * loose.best.sd_nm
    assert loose.best.sd_nm > 2.0 * tight.best.sd_nm


@pytest.mark.parametrize(("thickness_nm", "tolerance"), [(340.0, 0.002), (120.0, 0.01)])
def test_a_tolerance_of_the_index_is_the_width_of_one_reflectance_of_free_gain(
    thickness_nm: float, tolerance: float
) -> None:
    """Thickness and index lie on a ridge, n h; along it little is known but the tolerance, which is all the width there is.

    (Steps along thickness and index apart led off the ridge, where the posterior bends the other way: 340 +- 318 nm.)
    """
    nm = np.arange(450.0, 750.0, 2.0)
    clean = ir.Stack.parse(f"air / Ta2O5 {thickness_nm} / N-BK7").reflectance(nm)
    counts = 3e4 * (clean + 2e-3 * np.random.default_rng(1).standard_normal(nm.size))
    best = fit([ir.Measurement("reflectance", nm, counts)], "air / Ta2O5 ? / N-BK7", index_tolerance=tolerance).best
    # Dispersion and contrast may know more of the index; and a posterior is no wider than its prior, but for a tail.
    assert 0.1 * tolerance * thickness_nm < best.sd_nm < 1.5 * tolerance * thickness_nm
    assert abs(best.thickness_nm - thickness_nm) < 4.0 * best.sd_nm
    assert best.precision_nm < best.sd_nm and best.index[1]["n_sd"] < 1.5 * tolerance * best.index[1]["n"]


def test_what_was_not_said_of_index_and_wavelengths_is_in_the_accuracy() -> None:
    """What a fit finds under an index that is off by hand is what the accuracy holds."""
    unsaid: dict[str, Any] = {"index_tolerance": None, "wavelength_tolerance_nm": None}
    near = {"thickness_range_nm": (250.0, 420.0)}
    # A film whose index is 1 % higher than what was said of it.
    alone = fit([power("air / 1.5655 340 / Si")], "air / 1.55 ? / Si", **near, **unsaid).best
    exact = fit([power("air / 1.5655 340 / Si")], "air / 1.55 ? / Si", **near).best
    assert alone.accuracy_interval_nm[0] < 340.0 < alone.accuracy_interval_nm[1]
    assert not exact.accuracy_interval_nm[0] < 340.0 < exact.accuracy_interval_nm[1]
    assert alone.interval_nm == pytest.approx(exact.interval_nm)
    assert alone.precision_nm < 0.7 and alone.accuracy_nm == pytest.approx(3.4, rel=0.3)
    low, high = alone.precision_interval_nm
    assert high - low == pytest.approx(2.0 * 1.96 * alone.precision_nm, rel=0.01)
    parts = ellipsometry("air / 1.55 340 / Si", 70.0)
    sharp = fit(parts, "air / 1.55 ? / Si", thickness_range_nm=(200.0, 500.0), **unsaid).best
    off = fit(parts, "air / 1.5655 ? / Si", thickness_range_nm=(200.0, 500.0)).best
    wanted = np.hypot(off.thickness_nm - sharp.thickness_nm, 0.3 * 340.0 / 550.0)
    assert sharp.accuracy_nm == pytest.approx(wanted, rel=0.2) and sharp.precision_nm < 0.1


def test_an_angle_that_is_off_is_found_if_it_may_be() -> None:
    parts = ellipsometry("air / SiO2 120 / Si", 70.2, told_deg=70.0)
    stiff = fit(parts)
    loose = fit(parts, angle_tolerance_deg=0.2)
    assert loose.best.angle_offset_deg == pytest.approx(0.2, abs=0.02)
    assert abs(loose.best.thickness_nm - 120.0) < 4.0 * loose.best.sd_nm
    assert abs(stiff.best.thickness_nm - 120.0) > abs(loose.best.thickness_nm - 120.0)
    assert stiff.best.kappa > 1.0 and any("an angle" in note for note in stiff.notes)


def test_two_thicknesses_together() -> None:
    text = "air / SiO2 90 / Si3N4 60 / Si"
    parts = [*ellipsometry(text, 65.0), *ellipsometry(text, 75.0, 2)]
    result = fit(parts, "air / SiO2 ? / Si3N4 ? / Si", thickness_range_nm=(20.0, 160.0))
    assert np.abs(np.subtract(result.best.thickness_nm, (90.0, 60.0))).max() < 0.2
    assert len(result.best.interval_nm) == 2 and result.verdict == "clear"


def test_no_film_and_another_sign_are_not_sized() -> None:
    assert fit(ellipsometry("air / Si", 70.0)).verdict == "none"
    # An instrument that writes n - ik: its delta is 360 - ours.
    foreign = ellipsometry("air / SiO2 120 / Si", 65.0)
    foreign[1] = ir.Measurement("delta", NM, 360.0 - np.asarray(foreign[1].values), 65.0)
    assert fit(foreign).verdict in ("doubtful", "none")


def test_an_answer_is_shown() -> None:
    result = fit(ellipsometry("air / SiO2 120 / Si", 65.0))
    assert "120" in result._repr_html_()
    ax = result.plot()
    assert sum(line.get_gid() == "fitted" for line in ax.get_lines()) == 2
    assert result.to_dict()["verdict"] == "clear"


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ir.Measurement("phase", NM, NM, 65.0), "quantity must be"),
        (lambda: ir.Measurement("psi", NM, NM), "needs angle_deg > 0"),
        (lambda: ir.Measurement("psi", NM, NM, 65.0, gain=1.0), "has no gain"),
        (lambda: ir.Measurement("psi", NM, NM[1:], 65.0), "one length"),
        (lambda: ir.Measurement("psi", NM, NM * np.nan, 65.0), "usable points"),
        (lambda: ir.Measurement("psi", NM, NM, 65.0, noise=0.0), "noise must be"),
        (lambda: ir.Measurement("psi", NM, NM, 65.0, reference=NM), "no count"),
        (lambda: ir.Measurement("reflectance", NM, NM, dark=NM), "go with a reference"),
        (lambda: ir.Measurement("reflectance", NM, NM, reference=NM[1:]), "reference and values"),
        (lambda: fit([ir.Measurement("reflectance", NM, NM, reference=0.0 * NM)]), "the reference is above the dark"),
        (lambda: fit([]), "measurements must be"),
        (lambda: fit(ellipsometry("air / Si", 65.0), index="cauchy"), "index must be"),
        (lambda: fit(ellipsometry("air / Si", 65.0), dark=NM), "without measurements="),
        (lambda: fit(ellipsometry("air / Si", 65.0), angle_tolerance_deg=-1.0), "angle_tolerance_deg must be"),
        (lambda: fit(ellipsometry("air / Si", 65.0), "air / SiO2 ? / Si 1e6 incoherent / air"), "incoherent"),
        (lambda: fit(ellipsometry("air / Si", 65.0), None), "stack must say"),
        (lambda: ir.fit_thickness(stack=OXIDE), "must be given"),
    ],
)
def test_bad_input(make: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make()

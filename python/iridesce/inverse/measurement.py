"""One of several measurements of the same film, for a joint fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats, plain_reals
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import number, one_of

QUANTITIES = ("reflectance", "transmittance", "psi", "delta")
BASELINES = ("auto", "none", "constant", "linear", "quadratic")
FEWEST = 4


@dataclass(frozen=True)
class Measurement:
    """One measurement of a film: a reflectance, a transmittance, or an angle of ellipsometry, at one angle of incidence.

    quantity       "reflectance", "transmittance"; "psi", "delta" in degrees: tan(psi) exp(i delta) = r_p / r_s, delta in
                   this package's sign (360 - delta of instruments that write n - ik)
    wavelength_nm  vacuum wavelengths                                                              (n,)
    values         what was measured                                                               (n,)
    angle_deg, polarization  of the light; psi and delta need an angle > 0 and know no polarization
    noise          standard deviation, in the unit of the values; None: estimated                   () or (n,)
    gain           None: unknown; a number > 0 where it is known; "linear", "quadratic": unknown and changing along the
                   wavelengths. psi and delta have none
    baseline       stray light: "none", or smooth ("auto", "constant", "linear", "quadratic")
    dark, reference, reference_stack  of counts, as for `ir.fit_thickness`: values, and noise where it is given, are then counts,
                   and the gain is 1 within a few per cent unless ``gain`` says otherwise
    Raises         ValueError naming what is wrong

    >>> import iridesce as ir
    >>> nm = np.arange(400.0, 800.0, 2.0)
    >>> psi, delta = ir.Stack.parse("air / SiO2 120 / Si").ellipsometry(nm, 70.0)
    >>> both = [ir.Measurement("psi", nm, psi, 70.0), ir.Measurement("delta", nm, delta, 70.0)]
    >>> round(ir.fit_thickness(measurements=both, stack="air / SiO2 ? / Si").best.thickness_nm, 2)
    120.0
    """

    quantity: str
    wavelength_nm: npt.ArrayLike
    values: npt.ArrayLike
    angle_deg: float = 0.0
    polarization: str = "unpolarized"
    noise: npt.ArrayLike | None = None
    gain: float | str | None = None
    baseline: str = "auto"
    dark: npt.ArrayLike | None = None
    reference: npt.ArrayLike | None = None
    reference_stack: Any = None

    def __post_init__(self) -> None:
        one_of("quantity", self.quantity, QUANTITIES)
        angle = number("angle_deg", self.angle_deg, low=0.0, high=90.0)
        one_of("polarization", self.polarization, ("s", "p", "unpolarized"))
        one_of("baseline", self.baseline, BASELINES)
        if isinstance(self.gain, str):
            one_of("gain", self.gain, ("linear", "quadratic"))
        elif self.gain is not None:
            number("gain", self.gain, low=0.0, high=float("inf"), includes_low=False)
        if self.of_polarization:
            if angle == 0.0:
                raise complaint(
                    f"{self.quantity} needs angle_deg > 0: at normal incidence s and p are the same",
                    "angle_deg",
                    "> 0 for psi and delta",
                    angle,
                )
            if self.gain is not None or self.baseline != "auto" or self.polarization != "unpolarized":
                raise complaint(
                    f"{self.quantity} has no gain, baseline or polarization",
                    "quantity",
                    "reflectance or transmittance where gain, baseline or polarization is given",
                    self.quantity,
                )
            if self.reference is not None:
                raise complaint(
                    f"{self.quantity} is no count, and has no reference",
                    "reference",
                    "left out for psi and delta",
                    Words("given"),
                )
        if self.reference is None and (self.dark is not None or self.reference_stack is not None):
            raise complaint(
                "dark and reference_stack go with a reference: give reference=, too",
                "dark" if self.dark is not None else "reference_stack",
                "given with a reference",
                Words("no reference"),
            )
        for name in ("dark", "reference"):
            given = getattr(self, name)
            if given is not None and (size := _column(name, given).size) != np.size(self.values):
                raise complaint(
                    f"{name} and values of {self.label} must be of one length, got {size}, {np.size(self.values)}",
                    name,
                    f"as long as values ({np.size(self.values)})",
                    Words(size),
                    f"of {self.label}",
                )
        self.cleaned()

    @property
    def of_polarization(self) -> bool:
        """Whether it is psi or delta."""
        return self.quantity in ("psi", "delta")

    @property
    def label(self) -> str:
        """The quantity and its angle."""
        part = "" if self.polarization == "unpolarized" else f" {self.polarization}"
        return f"{self.quantity}{part}, {self.angle_deg:g} degrees"

    def cleaned(self) -> tuple[Floats, Floats, Floats | None]:
        """Ascending wavelengths, values and their standard deviations, as given, without what is not finite.

        Returns    three arrays; the third is None where ``noise`` is
        Raises     ValueError naming what is wrong

        >>> import iridesce as ir
        >>> ir.Measurement("reflectance", [600.0, 500.0, 700.0, 400.0], [0.2, 0.1, 0.3, 0.0]).cleaned()[1].tolist()
        [0.0, 0.1, 0.2, 0.3]
        """
        nm, values = _column("wavelength_nm", self.wavelength_nm), _column("values", self.values)
        if nm.shape != values.shape:
            raise complaint(
                f"wavelength_nm and values of {self.label} must be of one length, got {nm.size}, {values.size}",
                "values",
                f"as long as wavelength_nm ({nm.size})",
                Words(values.size),
                f"of {self.label}",
            )
        sd = None
        if self.noise is not None:
            sd = _column("noise", np.atleast_1d(np.asarray(self.noise)))
            if sd.size not in (1, nm.size):
                raise refusal("noise", f"one number or one a point ({nm.size})", Words(sd.size))
            sd = np.broadcast_to(sd, nm.shape)
            if not (np.isfinite(sd).all() and (sd > 0.0).all()):
                raise refusal("noise", "> 0 and finite", Words(f"{float(sd.min())!r} to {float(sd.max())!r}"))
        good = np.isfinite(nm) & np.isfinite(values) & (nm > 0.0)
        order = np.argsort(nm[good], kind="stable")
        if order.size < FEWEST:
            raise complaint(
                f"{self.label} has {order.size} usable points, at least {FEWEST} are needed",
                "values",
                f"{FEWEST} usable points or more",
                Words(order.size),
                f"of {self.label}",
            )
        return nm[good][order], values[good][order], None if sd is None else np.asarray(sd)[good][order].copy()


def _column(name: str, given: Any) -> Floats:
    found = plain_reals(name, given, "real numbers")
    if found.ndim != 1:
        raise refusal(name, "one axis", Words(f"shape {found.shape}"), must="have")
    return found

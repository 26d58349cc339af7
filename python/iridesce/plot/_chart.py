"""Thickness against angle. Internal."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from iridesce import color
from iridesce.arguments.operands import real_operand
from iridesce.arguments.refusals import refusal
from iridesce.color.screen import gains, gains_in_words, screen
from iridesce.plot._arguments import StackLike, even, family, samples
from iridesce.plot._style import begin, circumstances, heading, shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def chart(
    stack: StackLike,
    thickness_nm: ArrayLike | None = None,
    angle_deg: ArrayLike = (0.0, 85.0),
    *,
    layer: int | str | None = None,
    illuminant: str | os.PathLike[str] | color.Illuminant = "D65",
    observer: str = "cie1931",
    polarization: str = "unpolarized",
    quantity: str = "reflectance",
    model: str = "exact",
    exposure: float | str = "auto",
    title: str | None = None,
    theme: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """All colours of a film: its thickness to the right, the angle of incidence upwards.

    stack          `iridesce.Stack` or text such as "air / soap / air"; see `iridesce.plot`
    thickness_nm   (first, last) or evenly spaced ascending values, up to 1e5 nm; None: the values the layer has, or 0 to
                   2000 nm                                                                                     (n,)
    angle_deg      (first, last) or evenly spaced ascending values in the first medium, [0, 90)                 (m,)
    layer          the layer that grows, where there are several
    illuminant, observer, polarization, quantity, model  as for `Stack.color`
    exposure, title, theme, ax  see `iridesce.plot`
    Returns        the Axes; its image has the shape (m, n, 3), row 0 at the least angle
    Raises         ValueError naming the argument, the value and what is allowed

    >>> import numpy as np
    >>> import iridesce as ir
    >>> ax = ir.plot.chart("air / soap / air", np.linspace(0, 800, 41), angle_deg=[0, 30, 60])
    >>> ax.images[0].get_array().shape, ax.get_xlabel()
    ((3, 41, 3), 'soap thickness (nm)')
    """
    film = family(stack, layer)
    across = even("thickness_nm", samples("thickness_nm", thickness_nm, film.own_thicknesses(), (0.0, 2000.0), 2.5))
    up = real_operand("angle_deg", angle_deg, low=0.0, high=90.0).full()
    if up.ndim != 1 or up.size < 2 or not (np.diff(up) > 0.0).all():
        raise refusal("angle_deg", "two ascending numbers or an ascending array", angle_deg)
    up = even("angle_deg", up if up.size > 2 else np.linspace(up[0], up[1], 171))
    light = color.illuminant(illuminant)
    options = {"polarization": polarization, "observer": observer, "quantity": quantity, "model": model}
    colors = film.at(across).color(up[:, None], illuminant=light, **options)
    factors = gains(colors, exposure)

    ax, look = begin(ax, theme, (7.6, 5.0))
    half, step = 0.5 * (across[1] - across[0]), 0.5 * (up[1] - up[0])
    extent = (across[0] - half, across[-1] + half, up[0] - step, up[-1] + step)
    ax.imshow(
        screen(colors, factors), extent=extent, origin="lower", aspect="auto", interpolation="bilinear", zorder=0.5
    )
    ax.set(xlim=(across[0], across[-1]), ylim=(up[0], up[-1]))
    ax.set_xlabel(f"{film.medium.name} thickness (nm)")
    ax.set_ylabel(f"angle of incidence in {film.stack.first.name} (\u00b0)")
    facts = circumstances(
        f"illuminant {shortened(light.name)}",
        gains_in_words(factors, "each angle"),
        polarization=polarization,
        quantity=quantity,
        model=model,
    )
    heading(ax, look, title, film.name, facts)
    return ax

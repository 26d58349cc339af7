"""The notebook widget: the page's elements beside a kernel, with numbers by Python (extra ``notebook``)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from iridesce.arguments.refusals import Words, complaint, refusal, short

if TYPE_CHECKING:
    from iridesce.scene import Scene
    from iridesce.stack import Stack

__all__ = ["widget"]

_FIELD = (256, 128)


def widget(what: Stack | Scene | str = "bubble", *, illuminant: str = "D65", thickest_nm: float | None = None) -> Any:
    """A film or a bubble to look at and to turn knobs on, in a notebook.

    what         a `Stack` (or its text) whose first layer varies, "bubble", or a `Scene` (or the name of one) with a bubble:
                 a sphere whose surface is a film
    illuminant   a light as `iridesce.color.illuminant` names it
    thickest_nm  how far thickness reaches; without it 1200, or twice the thickness that is given
    Returns      an anywidget with the live traits ``thickness_nm``, ``angle_deg``, ``illuminant``: set them, or observe them
    Raises       ValueError naming what cannot be shown; ImportError where the extra is missing:
                 ``pip install "iridesce[notebook]"``

    >>> import iridesce as ir
    >>> film = ir.widget("air / soap 320 / air")
    >>> film.angle_deg = 30.0
    >>> film.description
    'film 320 nm at 30 degrees: XYZ 0.0537 0.0711 0.0472'
    """
    try:
        from iridesce.notebooks.live import FilmWidget
    except ImportError as error:
        raise ImportError('a widget needs the extra: pip install "iridesce[notebook]"') from error
    return FilmWidget(*_subject(what, thickest_nm), illuminant=illuminant)


def _subject(what: Stack | Scene | str, thickest_nm: float | None) -> tuple[str, Stack, float, float, Any]:
    """Kind, stack, thickness at first, thickest, and for a bubble its thickness over the mean."""
    from iridesce.scene import Scene
    from iridesce.stack import Stack

    if isinstance(what, str) and "/" in what.split():
        what = Stack.parse(what)
    if isinstance(what, Stack):
        if not what.layers:
            raise complaint(
                f"a widget shows a layer that varies, and {short(what)} has none",
                "what",
                "a stack with a layer that varies",
                what,
            )
        first = np.asarray(what.layers[0].thickness_nm, dtype=float)
        nm = float(first.mean())
        last = thickest_nm if thickest_nm is not None else max(1200.0, 2.0 * nm, float(first.max()))
        _check_last(last)
        return "film", what, min(nm, last), last, None
    if what == "bubble":
        what = "soap-bubble"
    scene = what if isinstance(what, Scene) else Scene.load(what)
    shares, medium, nm = _bubble(scene)
    last = thickest_nm if thickest_nm is not None else max(1500.0, 4.0 * nm)
    _check_last(last)
    from iridesce.stack import Layer

    return "bubble", Stack(["air", Layer(medium, thickness_nm=nm), "air"]), nm, last, shares


def _check_last(last: float) -> None:
    if not (50.0 <= last <= 10000.0):
        raise refusal("thickest_nm", "from 50 to 10000", last)


def _bubble(scene: Scene) -> tuple[Any, Any, float]:
    """Thickness over its mean on a sphere's map, the medium, and the mean, of a scene's first bubble."""
    for part in scene.to_dict()["object"]:
        film = part.get("surface", {}).get("film")
        if film is None or "sphere" not in part.get("shape", {}):
            continue
        medium = film["medium"]
        thickness = _thickness(film["thickness_nm"])
        weights = np.sin((np.arange(_FIELD[1]) + 0.5) * np.pi / _FIELD[1])[:, None]
        mean = float((thickness * weights).sum() / (weights.sum() * _FIELD[0]))
        if mean <= 0.0:
            raise complaint(
                "the bubble of this scene has no thickness", "scene", "one whose bubble has a thickness", Words("none")
            )
        return (thickness / mean).astype(np.float32), complex(*medium) if isinstance(medium, list) else medium, mean
    raise complaint(
        "a widget shows a bubble, and this scene has none: an object with a sphere and the surface film",
        "scene",
        "one with a bubble: a sphere and the surface film",
        Words("none"),
    )


def _thickness(value: Any) -> Any:
    """What a scene says of a film's thickness, over a whole sphere, row 0 on top."""
    from iridesce import thickness

    columns, rows = _FIELD
    if isinstance(value, int | float):
        return np.full((rows, columns), float(value))
    [(kind, how)] = value.items() if len(value) == 1 else [("more", value)]
    if kind == "gradient":
        share = (1.0 + np.cos((np.arange(rows) + 0.5) * np.pi / rows))[:, None] / 2.0
        low, high = float(how["bottom"]), float(how["top"])
        return np.broadcast_to(low + (high - low) * share ** float(how.get("exponent", 1.0)), (rows, columns)).copy()
    if kind == "flow":
        how = {"preset": how["preset"], "time_s": float(how["time_s"]), "seed": int(how.get("seed", 1))}
        return np.asarray(thickness.flow(**how).map(columns, rows).thickness_nm, dtype=float)
    raise complaint(
        f"a widget shows bubbles whose thickness_nm is a number, a gradient or a flow, got {sorted(value)}",
        "scene",
        "one whose thickness_nm is a number, a gradient or a flow",
        sorted(value),
    )

"""What sweeps refuse: the parts of each message, and its words."""

from __future__ import annotations

import threading

import distributed
import pytest

import iridesce as ir
from refused import Case, check

FILM = ir.Stack(["air", ir.Layer("soap", 320.0), "air"])


class Locked:
    """A quantity that holds what no other process can have."""

    def __init__(self) -> None:
        self.lock = threading.Lock()

    def __call__(self, _stack: ir.Stack) -> float:
        return 1.0

    def __repr__(self) -> str:
        return "Locked()"


class Waiting(distributed.Client):
    """A client of a program that goes on while it is asked; of nobody, so that none has to answer."""

    asynchronous = True

    def __init__(self) -> None:
        pass

    def __del__(self) -> None:
        pass


CASES: list[Case] = [
    (
        lambda: ir.sweep(FILM, {"angle_deg": [1.0]}, client=3),
        None,
        *("client", "3", "None, an address or a dask.distributed Client", ""),
    ),
    (
        lambda: ir.sweep(FILM, {"angle_deg": [1.0]}, client="local:0"),
        None,
        *("client", "'local:0'", '"local:N" with N >= 1', ""),
    ),
    (
        lambda: ir.sweep(FILM, {"angle_deg": [1.0]}, quantity="shine"),
        None,
        *(
            "quantity of a stack",
            "'shine'",
            (
                '"color", "reflectance", "transmittance", "absorptance", "layer_absorptance", "psi", '
                '"delta" or a function'
            ),
            "",
        ),
    ),
    (
        lambda: ir.sweep(FILM, {"layers.3.thickness_nm": [1.0]}),
        'vary: no "layers.3.thickness_nm"; the stack has layers 0 to 0',
        *("vary", "'layers.3.thickness_nm'", "keys of a stack that has layers 0 to 0", ""),
    ),
    (
        lambda: ir.sweep(FILM, {"angle": [1.0]}),
        (
            'vary: unknown "angle" of a stack\'s color; known: layers.N.thickness_nm, layers.N.medium, '
            "layers.N.coherent, first, last, angle_deg, polarization, illuminant, observer, space, "
            "quantity, model, wavelength_nm, adaptation, gamut"
        ),
        *("vary", "'angle'", "keys of the stack and its quantity", ""),
    ),
    (
        lambda: ir.sweep(FILM, {3: [1.0]}),
        'keys of vary are texts such as "angle_deg", got 3',
        *("vary", "3", 'a dict whose keys are texts such as "angle_deg"', ""),
    ),
    (lambda: ir.sweep(FILM, {"angle_deg": "wide"}), None, *("vary['angle_deg']", "'wide'", "a list of values", "")),
    (lambda: ir.sweep(FILM, {"angle_deg": 3}), None, *("vary['angle_deg']", "3", "a list of values", "")),
    (lambda: ir.sweep(FILM, [3]), None, *("vary[0]", "3", "a dict of key and value", "")),
    (
        lambda: ir.sweep(FILM, []),
        "vary is an empty list; name at least one point",
        *("vary", "[]", "a list of one point or more", ""),
    ),
    (lambda: ir.sweep(FILM, 3), None, *("vary", "3", "a dict of key and values, or a list of dicts", "")),
    (
        lambda: ir.sweep(FILM, {}),
        'vary is empty; name what varies, as in {"layers.0.thickness_nm": [100.0, 200.0]}',
        *("vary", "{}", "a dict of one key or more", ""),
    ),
    (
        lambda: ir.sweep(FILM, {"angle_deg": [1.0]}, client="nowhere:x"),
        (
            'client must be an address such as "tcp://127.0.0.1:8786", or "local:N", got \'nowhere:x\' '
            "(invalid literal for int() with base 10: 'x')"
        ),
        *("client", "'nowhere:x'", 'an address such as "tcp://127.0.0.1:8786", or "local:N"', ""),
    ),
    (
        lambda: ir.sweep(FILM, {"angle_deg": [1.0]}, client=""),
        (
            'client must be an address such as "tcp://127.0.0.1:8786", or "local:N", got \'\' (missing '
            "port number in address '')"
        ),
        *("client", "''", 'an address such as "tcp://127.0.0.1:8786", or "local:N"', ""),
    ),
    (
        lambda: ir.sweep(FILM, {"layers.0.thickness_nm": [1.0]}, quantity=Locked(), client="local"),
        "quantity cannot be sent to workers: TypeError: cannot pickle '_thread.lock' object",
        *("quantity", "Locked()", "a function that can be sent to workers", ""),
    ),
    (
        lambda: ir.sweep(FILM, {"angle_deg": [1.0]}, client=Waiting()),
        None,
        *("client", "an asynchronous one", "a synchronous dask.distributed Client", ""),
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[2]} {case[3]}"[:40])
def test_a_refusal_has_its_parts_and_words(case: Case) -> None:
    check(case)

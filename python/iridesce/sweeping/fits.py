"""Many spectra, each fitted by itself, on the workers of a cluster."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from iridesce._progress import progress_bar
from iridesce.inverse.fit import fit_thickness
from iridesce.sweeping.cluster import opened
from iridesce.sweeping.worker import Sent


def fit_one(sent: Sent, question: dict[str, Any]) -> Any:
    """One fit on a worker."""
    return fit_thickness(**question)


def fit_each(client: Any, questions: Sequence[dict[str, Any]], raises: bool = True) -> list[Any]:
    """The results of ``fit_thickness`` for each of some arguments, in their order.

    raises   the first error of a fit is raised; else it stands in the place of its result
    """
    results: list[Any] = [None] * len(questions)
    with opened(client) as cluster, progress_bar("spectra", counted=True) as advance:
        assert cluster is not None
        advance(0, len(questions))
        for done, (place, result, error) in enumerate(cluster.ask(fit_one, None, [(q,) for q in questions]), start=1):
            if error is not None and (raises or not isinstance(error, ValueError)):
                raise error
            results[place] = result if error is None else error
            advance(done, len(questions))
    return results

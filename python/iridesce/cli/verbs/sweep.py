"""The verb ``sweep``: a scene or a stack at many points, into a folder that resumes and that shards share."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import typer

from iridesce.cli.answers import note, print_json, quiet_dask
from iridesce.cli.options import STACK_HELP, DaskOption, JsonOption, OutsideOption, SetOption, ThreadsOption
from iridesce.cli.reading import assignment, changed_scene, is_stack_text, load_scene, shard_of, varied


def verb(
    source: Annotated[
        str, typer.Argument(metavar="SCENE|STACK", help=f"A scene, or a stack. {STACK_HELP}", show_default=False)
    ],
    vary: Annotated[
        list[str],
        typer.Option(
            metavar="KEY=A:B:N|V1,V2",
            help="What varies: N values from A to B, or a list; several make an outer product. Keys as of --set, of a "
            "stack layers.0.thickness_nm, angle_deg, illuminant, ...",
            show_default=False,
        ),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="Folder.", show_default=False)],
    quantity: Annotated[
        str | None,
        typer.Option(help="Of a scene image; of a stack color, reflectance, transmittance, absorptance, psi, delta."),
    ] = None,
    dask: DaskOption = None,
    shard: Annotated[
        str | None,
        typer.Option(metavar="I/N", help="Only every Nth point from the Ith on; shards share the folder."),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with a sweep that was interrupted.")] = False,
    threads: ThreadsOption = None,
    set_: SetOption = None,
    allow_outside: OutsideOption = False,
    as_json: JsonOption = False,
) -> None:
    """A scene or a stack at many points: one file a point (.exr, .npy), and an index that is checked on --resume.

    The same bytes for any number of threads, workers, shards and restarts. A point that fails is kept with its message.
    """
    values, part = varied(vary), shard_of(shard)
    base: Any = source
    if is_stack_text(source):
        if set_:
            raise typer.BadParameter("is for scenes; write the stack itself, or --vary", param_hint="--set")
    else:
        base = changed_scene(load_scene(source, allow_outside), [assignment(text) for text in set_ or []])
    if not resume and part is None and (output / "sweep.json").exists():
        raise ValueError(f"{output} holds a sweep; --resume goes on with it, another name starts afresh")
    if resume and not (output / "sweep.json").exists():
        raise ValueError(f"{output} holds no sweep to resume: no sweep.json")

    import iridesce as ir

    if dask is not None:
        quiet_dask()
    began = time.perf_counter()
    result = ir.sweep(
        base,
        values,
        quantity=quantity,
        store=output,
        client=dask,
        threads=threads,
        progress=True,
        shard=part,
    )
    took = time.perf_counter() - began
    if as_json:
        failed = [{"point": point, "error": message} for point, message in result.failed]
        print_json({"store": str(output), "points": len(result), "failed": failed, "seconds": took})
    else:
        print(output)
    for point, message in result.failed[:10]:
        note(f"note: failed at {_words(point)}: {message}")
    if len(result.failed) > 10:
        note(f"note: {len(result.failed) - 10} more failed; their messages are in {output / 'points'}")
    note(f"{len(result)} points, {len(result.failed)} failed, {took:.1f} s")


def _words(point: dict[str, Any]) -> str:
    return ", ".join(f"{key}={value}" for key, value in point.items())

"""The page that comes with the package: one file that works from disk, built by ``make web``. Internal."""

from __future__ import annotations

from pathlib import Path

from iridesce.arguments.refusals import complaint

SCENES = ("bubble", "rings", "slick", "titanium", "wafer", "film")


def page_path() -> Path:
    """Where the one-file page lies."""
    return Path(__file__).with_name("iridesce.html")


def page_link(scene: str | None = None) -> str:
    """The address of the page, with the fragment of a scene."""
    if scene is not None and scene not in SCENES:
        raise complaint(
            f"the page has the scenes {', '.join(SCENES)}, got {scene!r}", "scene", f"one of {', '.join(SCENES)}", scene
        )
    return page_path().as_uri() + ("" if scene is None else f"#v=1&scene={scene}")

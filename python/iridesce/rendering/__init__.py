"""From a scene to its picture, or to a film of pictures."""

from __future__ import annotations

from iridesce.rendering.merging import merge
from iridesce.rendering.pictures import render

__all__ = ["merge", "render"]

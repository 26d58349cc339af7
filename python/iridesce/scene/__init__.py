"""Scenes: what to render, read from a file, a dict or the built-in set."""

from __future__ import annotations

from iridesce.scene.scene import Scene, _restore, scene_names, scene_text  # noqa: F401  (scenes pickled before name _restore here)

__all__ = ["Scene", "scene_names", "scene_text"]

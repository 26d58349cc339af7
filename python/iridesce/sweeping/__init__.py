"""Many points of one scene or stack: grids, a store that resumes, threads of this machine or a cluster."""

from __future__ import annotations

from iridesce.sweeping.results import SweepResult
from iridesce.sweeping.running import sweep

__all__ = ["SweepResult", "sweep"]

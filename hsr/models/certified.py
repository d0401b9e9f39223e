"""The certified depth buffer: it has no error but the tessellation."""

from __future__ import annotations

from hsr.algorithms.zbuffer import render
from hsr.models.rounded import TESSELLATED
from hsr.models.stages import Pipeline, rerun

PIPELINE = Pipeline((TESSELLATED,), rerun(render))

"""Embree, as far as it can be followed."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from hsr.algorithms.embree import Options
from hsr.arrays import Array, Ints
from hsr.difference.models.rounded import of_polygons, tessellation, true_faces
from hsr.difference.models.stages import Cause, Pipeline, Stage
from hsr.viewing import View


@lru_cache(maxsize=2)
def _in_world(view: View) -> View:
    return of_polygons(view, replace(view.polygons, vertices=view.polygons.vertices.astype(np.float32)))


def input_rounding(view: View, options: Options, samples: Array) -> Ints:  # noqa: ARG001
    """Model the rounding of world points to float32."""
    return true_faces(_in_world(view.tessellated()))[samples]


PIPELINE = Pipeline(
    (Stage(Cause.TESSELLATION, tessellation), Stage(Cause.INPUT_ROUNDING, input_rounding)), None
)

"""Embree, as far as it can be followed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hsr.algorithms.embree import Options
from hsr.arrays import Array, Ints
from hsr.difference.models.rounded import of_polygons, tessellation, true_faces
from hsr.difference.models.stages import Cause, Pipeline, Stage
from hsr.viewing import View


def input_rounding(view: View, options: Options, samples: Array) -> Ints:  # noqa: ARG001
    """Model the rounding of world points to float32."""
    view = view.tessellated()
    polygons = replace(view.polygons, vertices=view.polygons.vertices.astype(np.float32))
    return true_faces(of_polygons(view, polygons, np.ones(len(polygons), dtype=np.bool_)))[samples]


PIPELINE = Pipeline(
    (Stage(Cause.TESSELLATION, tessellation), Stage(Cause.INPUT_ROUNDING, input_rounding)), None
)

"""The depth buffer of half-space tests without certification, stage by stage.

It rounds world points and clip coordinates as :mod:`hsr.models.scanline` does in float64. The fill rule is
modelled by the triangles that it draws itself. Its depths are rounded to keys while they are computed, so
that their arithmetic and their format are one stage: the method itself, run once more.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import wraps

import numpy as np

from hsr.algorithms import scanline
from hsr.algorithms.zbuffer import Options, clusters_of, draw, eye_of, in_clusters, render
from hsr.base.arrays import Array, Ints
from hsr.kernels.projection import clip_rows
from hsr.models import scanline as scanned
from hsr.models.rounded import TESSELLATED
from hsr.models.stages import Cause, Model, ending, named, rerun
from hsr.problem.map import BACKGROUND
from hsr.problem.view import View

FLOAT64 = scanline.Options()


def _in_float64(model: Model) -> Model:
    """Make a model of scan conversion one of this method, which works as it does in float64."""
    return wraps(model)(lambda view, _, samples: model(view, FLOAT64, samples))


def fill_rule(view: View, options: Options, samples: Array) -> Ints:  # noqa: ARG001
    """Model the coverage: of the polygons that the method draws at a sample, the nearest."""
    view = view.tessellated()
    polygons = scanned.on_screen(view, FLOAT64)
    layers = scanned.layers_of(view, polygons, samples)
    return scanned.nearest_drawn(view, polygons, _drawn(view, layers), samples)


def _drawn(view: View, layers: list[list[int]]) -> Iterator[Ints]:
    """Rasterise each layer by itself, and yield which polygon (H, W) is drawn at each sample."""
    rows, polygon = clip_rows(view.clip_from_world, view.depth_row), view.polygons.triangle_polygon
    eye = eye_of(view, clusters_of(view), rows)
    for layer in layers:
        alone = in_clusters(view.geometry, np.flatnonzero(np.isin(polygon, layer)), polygon)
        size = (view.height, view.width)
        answer = np.full(size, BACKGROUND, np.int32), np.full(size, np.inf)
        draw(view, alone, rows, eye, np.empty((alone.vertices.shape[1], 4)), False, answer)
        yield answer[0]


MODELS = named(_in_float64(scanned.input_rounding), _in_float64(scanned.transform), fill_rule)
PIPELINE = ending(rerun(render), Cause.DEPTH_FORMAT, TESSELLATED, *MODELS)

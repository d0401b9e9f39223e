"""The ray caster, stage by stage.

==============  ==============================================================================
Stage           Model: the exact answer
==============  ==============================================================================
input rounding  with float32, for the vertices in object space, rounded to it
transform       on the screen, for the objects carried there by their matrices, as rounded; of
                meshes the vertices, as rounded (with tiles, of all planar shapes)
traversal       the same, but where the plain object list gives another answer than the method,
                the method's
intersector     (the method itself)
==============  ==============================================================================

Certified tiles have no error. Left alone, they round clip coordinates; what they pass by is proven to show
nothing, so that traversal brings in no error, and all else, rounding depths to keys included, is the
intersector's.

Single rays meet generic shapes in object space, as they do meshes unless triangles are tested on
the screen. The rounding of the rays there counts as the intersector's, as does that of near and far. The
last model is the method run once more: that it shows the same proves that the method does not depend on
chance, and the other models say at which stage it leaves the truth.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from hsr.algorithms.prepare.ray_tiles import clip_matrices
from hsr.algorithms.raycast import Options, cast_by_list, render, screen_matrices
from hsr.base.arrays import Array, Floats, Ints
from hsr.exact.oracle import owners
from hsr.models.rounded import seen_along_third
from hsr.models.stages import Cause, at_samples, ending, named, rerun
from hsr.problem.geometry import as_float32
from hsr.problem.view import Placement, View
from hsr.scene.shapes import Kind, Shape

RENDERED = rerun(render)


def _on_screen(view: View) -> View:
    """Return the view of the objects on the screen: (X, Y, depth), X and Y as in ``corner_of``."""
    width, height = float(view.width), float(view.height)
    seen = seen_along_third(view, 2.0 * height, -2.0 * width, width * height)
    return _carried(seen, screen_matrices(view), lambda shape: shape.kind == Kind.MESH)


def _in_clip_space(view: View) -> View:
    """Return the view of the objects in clip space: (x, y, depth), for tiles of rays."""
    return _carried(seen_along_third(view), clip_matrices(view), lambda shape: not shape.curved)


def _carried(seen: View, matrices: Iterable[Floats], by_vertices: Callable[[Shape], bool]) -> View:
    """Carry each object by its matrix (3, 4)."""
    placed = zip(seen.placements, matrices, strict=True)
    return replace(seen, placements=tuple(_moved(*one, by_vertices) for one in placed))


def _moved(placement: Placement, matrix: Floats, by_vertices: Callable[[Shape], bool]) -> Placement:
    """Carry an object as it is, or by its vertices, each rounded."""
    polygons = placement.shape.polygons
    if polygons is None or not by_vertices(placement.shape):
        return replace(placement, world_from_object=np.vstack([matrix, [0.0, 0.0, 0.0, 1.0]]))
    x, y, z = polygons.vertices.T[:, :, None]
    # The order of the sum is that of the method.
    corners = matrix[:, 0] * x + matrix[:, 1] * y + matrix[:, 2] * z + matrix[:, 3]
    shape = replace(placement.shape, polygons=replace(polygons, vertices=corners))
    return replace(placement, shape=shape, world_from_object=np.eye(4))


def input_rounding(view: View, options: Options, samples: Array) -> Ints:
    """Model the rounding of vertices to float32, if that is the arithmetic."""
    if options.arithmetic == "float32":
        view = replace(view, placements=tuple(_rounded(placement) for placement in view.placements))
    return owners(view, samples)


def _rounded(placement: Placement) -> Placement:
    polygons = placement.shape.polygons
    if polygons is None:
        return placement
    vertices = as_float32(polygons.vertices, "raycast", "choose float64").astype(np.float64)
    return replace(placement, shape=replace(placement.shape, polygons=replace(polygons, vertices=vertices)))


def transform(view: View, options: Options, samples: Array) -> Ints:
    """Model the rounding of the composed matrices and of projected vertices."""
    if options.acceleration == "tiles":
        return owners(_in_clip_space(view), samples)
    if options.test != "screen":
        return input_rounding(view, options, samples)
    return owners(_on_screen(view), samples)


def traversal(view: View, options: Options, samples: Array) -> Ints:
    """Model what the traversal of the objects may have left out."""
    if options.acceleration == "tiles":
        return transform(view, options, samples)
    own = at_samples(RENDERED, view, options, samples)
    return np.where(cast_by_list(view, options, samples) == own, transform(view, options, samples), own)


PIPELINE = ending(RENDERED, Cause.INTERSECTOR, *named(input_rounding, transform, traversal))

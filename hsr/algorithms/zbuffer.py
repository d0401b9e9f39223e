"""The depth buffer, certified: half-space tests in float64, and what they leave in doubt decided exactly.

The same contract as :mod:`hsr.algorithms.scanline`, by another kernel, several times faster. Vertices are
projected, with bounds of their errors; clusters of triangles go through tiles of the image, nearest first,
while those behind what is already there are left out (:mod:`hsr.kernels.zbuffer.tiles`). Every decision that
rounding might turn is noted instead of taken, and taken afterwards in exact arithmetic (:mod:`hsr.certify`).
So the face of every sample is the true one, ties included: that of ``view.tessellated()`` in the limit from
the right and below.

Nothing is clipped. A triangle with a corner at or behind the eye is set up from its exact homogeneous edges
(Olano & Greer, "Triangle Scan Conversion Using 2D Homogeneous Coordinates", 1997), and near and far are two
more tests at each sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hsr.algorithms.prepare.behind_eye import crossing_tables, crossing_triangles
from hsr.algorithms.prepare.doubts import decide, filled, format_of, numbers_of
from hsr.base.arrays import Array, Floats, Ints
from hsr.base.jit import thread_count
from hsr.kernels import hierarchy
from hsr.kernels.projection import clip_rows, to_clip
from hsr.kernels.zbuffer import facing, fill, setup, tiles
from hsr.kernels.zbuffer.setup import CLUSTER, SMALL, TABLE, Eye, U
from hsr.problem.geometry import Geometry
from hsr.problem.map import Clock, VisibilityMap
from hsr.problem.view import View
from hsr.scene.shapes import Shape

ROOM = 64
"""Doubts of a tile for which there is room at first; a tile with more is drawn again."""

NO_TABLES = np.empty((0, TABLE))


@dataclass(frozen=True)
class Options:
    """How sure the answer is.

    Attributes
    ----------
    certified : bool
        Whether what float64 leaves in doubt is decided exactly. Otherwise a sample within rounding of an
        edge belongs to all triangles that seem to cover it, and of equal depths one of them wins: what
        certification costs is the difference in time.
    """

    certified: bool = True


def render(view: View, options: Options) -> VisibilityMap:
    """Render a view with a depth buffer filled by half-space tests.

    Parameters
    ----------
    view : View
        Curved shapes are tessellated.
    options : Options

    Returns
    -------
    VisibilityMap
        Certified, ``face`` is exact; ``depth`` is correctly rounded where it was decided exactly, and
        elsewhere its inverse (under perspective; in a parallel view it itself) is within 2^-35 of the range
        of what is seen, or what its vertices' rounding makes of it if that is more. ``seconds``:
        ``prepare`` puts the triangles into world space and in order, once a scene, and makes room for the
        answer; ``render`` is all the rest. ``work``: ``triangles``, ``clusters_drawn`` and
        ``clusters_hidden``, ``triangles_drawn``, each once for every tile of the image, ``uncertain``
        samples, which were decided exactly, and ``buffer_bytes``, those of the answer.

    Notes
    -----
    Memory beside the answer, which takes 12 bytes a sample: 56 bytes a vertex, 21 a triangle, 96 a cluster of
    32, 49 more where something is culled, and 4 for each tile that it may touch; 540 kB of keys for each
    thread; 17 bytes for each doubt of the most doubtful tile, at most twice, in every tile that is drawn
    again.
    """
    clock = Clock()
    with clock("prepare"):
        view = view.tessellated()
        clusters = clusters_of(view)
        # Touch the memory now: the first touch of a page takes longer than what is computed in it.
        screen = np.full((clusters.vertices.shape[1], 4), 0.0)
        size = (view.height, view.width)
        face, depth = np.full(size, -1, np.int32), np.full(size, np.inf)
    with clock("render"):
        rows = clip_rows(view.clip_from_world, view.depth_row)
        eye = eye_of(view, clusters, rows)
        found, counts = draw(view, clusters, rows, eye, screen, options.certified, (face, depth))
        piece = clusters.number[numbers_of(found, len(clusters.corner))]
        uncertain = decide(view, found, piece, (face, depth))
    work = {
        "triangles": len(clusters.corner),
        "clusters_drawn": int(counts[tiles.DRAWN]),
        "clusters_hidden": int(counts[tiles.HIDDEN]),
        "triangles_drawn": int(counts[fill.TRIANGLES]),
        "uncertain": uncertain,
        "buffer_bytes": face.nbytes + depth.nbytes,
    }
    notes = {"depth_format": format_of(view, len(clusters.corner), eye)}
    return VisibilityMap(face, depth, "zbuffer", work, clock.seconds, notes)


# ---------------------------------------------------------------- once a scene


class Clusters(NamedTuple):
    """Triangles in clusters, which are neighbours on a Morton curve.

    Attributes
    ----------
    vertices : (3, V) float64, world space
    corner : (n, 3) int32
    cull : (n,) int8
    faces : (n,) int32
        Face of each triangle.
    number : (n,) int32
        Its number among the fans of the polygons.
    low, high : (3, clusters) float64
        The boxes around the clusters.
    box : (2, 3) float64
        That around them all.
    slack : (3,) float64
        By how much the vertices, which are rounded, may miss the true ones.
    culls : (clusters,) int8
        What all triangles of each cull, 0 if they differ.
    normals : (low, high) or None
        The boxes (3, clusters) around their normals; None if nothing is culled.
    """

    vertices: Floats
    corner: Ints
    cull: Array
    faces: Ints
    number: Ints
    low: Floats
    high: Floats
    box: Floats
    slack: Floats
    culls: Array
    normals: tuple[Floats, Floats] | None


def clusters_of(view: View) -> Clusters:
    """Put the triangles of a view without curved shapes in clusters, once a scene."""
    geometry = view.geometry
    every, faces = np.arange(len(geometry.polygons.triangle_vertex)), geometry.polygons.triangle_face
    return geometry.once("zbuffer", lambda: in_clusters(geometry, every, faces))


@np.errstate(over="ignore", invalid="ignore")
def in_clusters(geometry: Geometry, chosen: Array, faces: Ints) -> Clusters:
    """Put some triangles (n,) of the fans in clusters; ``faces`` (all,) is what they shall show."""
    polygons = geometry.polygons
    vertex, place = along_the_curve(polygons.vertices, polygons.vertices)
    low, high = hierarchy.boxes_of(polygons.vertices, polygons.triangle_vertex[chosen])
    order, _ = along_the_curve(low, high)
    number, first = chosen[order].astype(np.int32), np.arange(0, len(order), CLUSTER)
    low, high = np.minimum.reduceat(low[order], first), np.maximum.reduceat(high[order], first)
    vertices = np.ascontiguousarray(polygons.vertices[vertex].T)
    corner = place[polygons.triangle_vertex[number]]
    cull, slack = polygons.cull[polygons.triangle_polygon[number]], world_slack(geometry)
    least, most = np.minimum.reduceat(cull, first), np.maximum.reduceat(cull, first)
    return Clusters(
        vertices,
        corner,
        cull,
        faces[number],
        number,
        np.ascontiguousarray(low.T),
        np.ascontiguousarray(high.T),
        np.stack([low.min(axis=0), high.max(axis=0)]),
        slack,
        np.where(least == most, least, 0),
        normals_of(vertices, corner, slack) if cull.any() else None,
    )


def normals_of(vertices: Floats, corner: Ints, slack: Floats) -> tuple[Floats, Floats]:
    """Return opposite corners of the boxes around the normals of clusters."""
    size = (3, -(-len(corner) // CLUSTER))
    low, high = np.empty(size), np.empty(size)
    facing.normal_boxes(vertices, corner, slack, low, high)
    return low, high


def along_the_curve(low: Floats, high: Floats) -> tuple[Ints, Ints]:
    """Return the order of boxes along a Morton curve, and the place of each in it: neighbours get close."""
    _, order = hierarchy.radix_sort(hierarchy.morton_codes(low, high))
    place = np.empty_like(order)
    place[order] = np.arange(len(order), dtype=order.dtype)
    return order, place


def world_slack(geometry: Geometry) -> Floats:
    """Bound (3,) by how much the rounded vertices of a geometry's polygons miss the true ones, world space.

    A coordinate is a sum of three products and a translation: fewer than eight roundings, each of at most
    the sum of their magnitudes.
    """
    matrix = abs(geometry.matrices)
    farthest = {one.shape: abs(_vertices(one.shape)).max(axis=0) for one in geometry}
    reach = np.array([farthest[one.shape] for one in geometry])
    size = (matrix[:, :3, :3] @ reach[:, :, None])[:, :, 0] + matrix[:, :3, 3]
    return np.asarray(8.0 * U * (size.max(axis=0) + SMALL))


def _vertices(shape: Shape) -> Floats:
    assert shape.polygons is not None, "the view is tessellated"
    return shape.polygons.vertices


# ---------------------------------------------------------------- once a picture


# What over- or underflows here and below is bounded by infinity, and so decided exactly.
@np.errstate(all="ignore")
def eye_of(view: View, clusters: Clusters, rows: Floats) -> Eye:
    """Measure a view for the kernels; see :func:`hsr.kernels.zbuffer.setup.eye_around`."""
    size, limits = (view.width, view.height), (view.near, view.far)
    return setup.eye_around(view.perspective, size, limits, rows, clusters.box, clusters.slack)


@np.errstate(all="ignore")
def draw(
    view: View,
    clusters: Clusters,
    rows: Floats,
    eye: Eye,
    screen: Floats,
    certified: bool,
    answer: tuple[Ints, Floats],
) -> tuple[Array, Array]:
    """Draw clusters into face (H, W) and depth (H, W).

    Parameters
    ----------
    view : View
        Without curved shapes.
    clusters : Clusters
    rows : (3, 4) float64
        From world to clip space (x, y, d).
    eye : Eye
    screen : (V, 4) float64
        Room for the projected vertices.
    certified : bool
    answer : (face, depth)
        They show the background.

    Returns
    -------
    found : (m,) DOUBT
        None if not certified.
    counts : (COUNTS,) int64
    """
    extent = np.empty((clusters.low.shape[1], 5))
    uncertain = setup.lay_out(clusters.vertices, clusters.low, clusters.high, rows, eye, screen, extent)
    if clusters.normals is not None:
        form, boxes = facing.determinant_of(view.perspective, rows), (clusters.low, clusters.high)
        facing.leave_out(boxes, clusters.normals, clusters.culls, clusters.slack, form, extent)
    crossing = _crossing(view, clusters, rows, eye, screen) if uncertain else NO_TABLES
    listed, todo = tiles.deal(extent, view.width, view.height, thread_count())
    triangles, image = (screen, clusters.corner, clusters.cull), (clusters.faces, *answer)

    def rasterise(todo: Array, noted: Array | None, counts: Array) -> None:
        tiles.rasterise(triangles, extent, listed, todo, crossing, eye, image, noted, counts)

    found, counts = zip(*filled(todo, ROOM, certified, rasterise), strict=True)
    return np.concatenate(found), sum(counts)


def _crossing(view: View, clusters: Clusters, rows: Floats, eye: Eye, screen: Floats) -> Floats:
    """Set up the triangles of which a corner is not certain."""
    chosen = crossing_triangles(screen, clusters.corner, eye)
    clip = to_clip(clusters.vertices.T[clusters.corner[chosen].ravel()], rows).reshape(-1, 3, 3)
    return crossing_tables(view, clip, clusters.number[chosen], chosen, eye)

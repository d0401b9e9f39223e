"""Back-face detection alone: what faces away from the eye goes, the rest is painted in file order.

A face is a back face if ``V . N >= 0``, N being its outward normal and V running from the eye to the
face; :mod:`hsr.kernels.culling` has the three forms in which that is tested. What an object's ``cull``
says is not heeded: back faces always go, front faces always stay.

By itself the method is complete only where no two faces that face the eye overlap in projection: a
convex solid, or several that lie apart *in the image*. Solids that do not touch but stand one behind the
other are a counterexample, and so are surfaces that are not closed, seen from behind. So the map says
whether it can be trusted, as far as its samples show it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr.algorithms import scanline
from hsr.algorithms.prepare import choices
from hsr.base.arrays import Array, Floats
from hsr.kernels.clipping import clip_polygons, view_volume
from hsr.kernels.culling import CULL_BACK, CULL_BOTH, facing_by_determinant, facing_by_normal, facing_in_ndc
from hsr.kernels.depth_buffer import ALWAYS
from hsr.kernels.projection import clip_rows, to_clip
from hsr.problem.map import Clock, VisibilityMap
from hsr.problem.view import View

PAINT = scanline.Options(stepping="direct", count=True)
"""How polygons are drawn."""

FORMS = ("normal", "ndc", "determinant")


@dataclass(frozen=True)
class Options:
    """How back faces are detected.

    Attributes
    ----------
    form : {"normal", "ndc", "determinant"}
        ``V . N >= 0`` in the camera's frame; ``C <= 0`` in normalised device coordinates; or the sign of
        ``det [a b c]`` of the corners (x, y, w).
    """

    form: str = "normal"

    def __post_init__(self) -> None:
        choices.check("backface", self, {"form": FORMS})


def render(view: View, options: Options) -> VisibilityMap:
    """Remove back faces, and paint the others in file order without a depth test.

    Parameters
    ----------
    view : View
        Curved shapes are tessellated.
    options : Options

    Returns
    -------
    VisibilityMap
        Where faces overlap, the one painted last is shown, with its own depth.
        ``work``: ``polygons``, and of them ``front_faces``, ``back_faces``, ``edge_on``.
        ``notes``: ``overlapping_samples``, how often a painted sample was painted again;
        ``uncovered_samples``, how many samples a removed face covers and no other, counting the faces
        that the scene itself does not cull;
        ``sufficient``, whether both are 0. That is proven at the samples, not between them, and says
        nothing of a removed face that lies in front of a remaining one.
    """
    clock = Clock()
    with clock("prepare"):
        view = view.tessellated()
        clip = to_clip(view.polygons.vertices, clip_rows(view.clip_from_world, view.depth_row))
    with clock("render"):
        facing = _facing(view, clip, options.form)
        front = facing > 0.0
        face, depth, painted = _paint(view, clip, front)
    with clock("judge"):
        removed, _, _ = _paint(view, clip, ~front & (view.polygons.cull != CULL_BACK))
        uncovered = int(np.count_nonzero((removed >= 0) & (face < 0)))
    work = {
        "polygons": len(front),
        "front_faces": int(np.count_nonzero(front)),
        "back_faces": int(np.count_nonzero(facing < 0.0)),
        "edge_on": int(np.count_nonzero(facing == 0.0)),
    }
    notes = {
        "sufficient": painted["overdraw"] == 0 and uncovered == 0,
        "overlapping_samples": painted["overdraw"],
        "uncovered_samples": uncovered,
    }
    return VisibilityMap(face, depth, "backface", work, clock.seconds, notes)


def _facing(view: View, clip: Floats, form: str) -> Floats:
    """Return for each polygon a number: positive in front, negative at the back, 0 edge-on."""
    corner, start = view.polygons.corner, view.polygons.start
    if form == "normal":
        return facing_by_normal(clip, corner, start, view.perspective)
    if form == "determinant":
        return facing_by_determinant(clip, corner, start, view.perspective)
    near = view_volume(view.near, view.far, view.perspective)[:1]
    return facing_in_ndc(*clip_polygons(clip, corner, start, near), view.perspective)


def _paint(view: View, clip: Floats, chosen: Array) -> tuple[Array, Floats, dict[str, int]]:
    cull = np.where(chosen, 0, CULL_BOTH).astype(np.int8)
    return scanline.scan_polygons(view, view.polygons, clip, cull, PAINT, ALWAYS)[:3]

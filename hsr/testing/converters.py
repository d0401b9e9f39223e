"""Visibility maps from the images of ids that other renderers make.

Other renderers number triangles, in the order in which they were given them. With ``view`` a converter
takes them to be ``view.tessellated().triangles`` and returns the faces they belong to, named as the view
names them; without, the numbers are the faces. Without ``depth`` a map tells no depths.

A map is called after its renderer. Its wrong samples are put down to causes by a model of it: the one that
is told, ``model="float32", subpixel_bits=4`` (see :func:`hsr.testing.modelled`), or else one that is found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from hsr.base.arrays import Array, Ints
from hsr.base.errors import MapError
from hsr.models.foreign import modelled
from hsr.problem.map import BACKGROUND, NO_DEPTH, Admissible, VisibilityMap
from hsr.problem.view import View

MISS = 0xFFFFFFFF
"""Open3D's id of a ray that hits nothing."""

EXACT_FLOATS = 2**24
"""Up to here float32 holds every whole number."""


def from_ids(
    ids: Array,
    view: View | None = None,
    *,
    background: int = BACKGROUND,
    first: int = 0,
    bottom_up: bool = False,
    depth: Array | None = None,
    method: str = "ids",
    **model: Any,
) -> VisibilityMap:
    """Make a map from an array of triangle numbers.

    Parameters
    ----------
    ids : (H, W) array of whole numbers, of any type
    view : View, optional
        What was rendered.
    background : int
        The number of samples that show nothing.
    first : int
        The number of the first triangle.
    bottom_up : bool
        Whether row 0 is the bottom row, as OpenGL reads pictures.
    depth : (H, W) array, optional
        Along the view axis, in scene units, with rows in the order of ``ids``.
    method : str
        What to call the renderer.
    **model
        ``model`` and its parameters, as for :func:`hsr.testing.modelled`.

    Returns
    -------
    VisibilityMap

    Raises
    ------
    MapError
        If ids are no whole numbers, name triangles that do not exist, or sizes differ.

    Examples
    --------
    >>> import numpy as np
    >>> from hsr.testing import from_ids
    >>> ids = np.array([[0, 0, 0], [0, 1, 1]])  # 0 where nothing is, then triangles from 1 on
    >>> print(from_ids(ids, background=0, first=1, bottom_up=True).face)
    [[-1  0  0]
     [-1 -1 -1]]
    """
    ids = np.asarray(ids)
    if ids.ndim != 2:
        raise MapError(f"{method}: ids must be an (H, W) array, not {ids.shape}")
    with np.errstate(invalid="ignore"):  # NaN becomes a number, which differs from it
        number = ids.astype(np.int64)
    _refuse(number != ids, ids, method, "is no whole number; switch off antialiasing, which blends ids")
    covered = number != background
    number = np.where(covered, number - first, BACKGROUND)
    depths = np.full(ids.shape, np.nan) if depth is None else np.asarray(depth, dtype=np.float64)
    if depths.shape != ids.shape:
        raise MapError(f"{method}: depth {depths.shape} has not the shape of the ids, {ids.shape}")
    if bottom_up:
        number, covered, depths = number[::-1], covered[::-1], depths[::-1]
    face = _faces(number, covered, view, method)
    notes = {"depth_format": NO_DEPTH} if depth is None else {}
    told: dict[str, Any] = {} if view is None else {"manifest": view.manifest, "hashes": view.hashes}
    shown = VisibilityMap(face, np.where(covered, depths, np.inf), method, notes=notes, **told)
    return modelled(shown, **model) if model else shown


def _faces(number: Array, covered: Array, view: View | None, method: str) -> Ints:
    if view is not None and number.shape != (view.height, view.width):
        height, width = number.shape
        sizes = f"{width}x{height} is not the size of the view, {view.width}x{view.height}"
        raise MapError(f"{method}: {sizes}")
    owner = None if view is None else view.tessellated().triangle_face
    last = int(np.iinfo(np.int32).max) if owner is None else len(owner) - 1
    strange = covered & ((number < 0) | (number > last))
    _refuse(strange, number, method, f"is no triangle: they run from 0 to {last}")
    shown = number.astype(np.int32)
    if owner is not None:
        shown[covered] = owner[number[covered]]
    return shown


def _refuse(wrong: Array, values: Array, method: str, why: str) -> None:
    """Raise if any sample is wrong, naming the first."""
    if wrong.any():
        y, x = np.argwhere(wrong)[0]
        others = int(np.count_nonzero(wrong)) - 1
        more = f" and {others} more" if others else ""
        raise MapError(f"{method}: id {values[y, x]} at {x},{y}{more} {why}")


def _numbers(colours: Array) -> Array:
    """Read colours (..., 3 or more) as numbers: ``red * 65536 + green * 256 + blue``."""
    return np.asarray(colours[..., :3].astype(np.int64) @ np.array([65536, 256, 1]))


def from_png(
    path: str | Path,
    view: View | None = None,
    *,
    background: int = 0,
    first: int = 1,
    method: str = "png",
    **model: Any,
) -> VisibilityMap:
    """Read a PNG whose 24-bit colours are ids: ``red * 65536 + green * 256 + blue``.

    Parameters
    ----------
    path : str or Path
        Of 8 bits a channel, RGB, or RGBA with no transparent pixel; row 0 is the top row.
    view, background, first, method, **model
        As for :func:`from_ids`; by default black is the background and 1 the first triangle.

    Returns
    -------
    VisibilityMap

    Raises
    ------
    MapError
        If the file is no such picture, or see :func:`from_ids`.
    """
    try:
        with Image.open(path) as image:
            kind, mode, pixels = image.format, image.mode, np.asarray(image)
    except (OSError, SyntaxError) as error:
        raise MapError(f"{path}: not a picture that can be read ({error})") from error
    if kind != "PNG" or mode not in ("RGB", "RGBA") or (mode == "RGBA" and (pixels[..., 3] != 255).any()):
        raise MapError(f"{path}: ids need a PNG of opaque 8-bit RGB, not {kind} {mode}")
    return from_ids(_numbers(pixels), view, background=background, first=first, method=method, **model)


def from_nvdiffrast(
    rast: Array, view: View | None = None, *, method: str = "nvdiffrast", **model: Any
) -> VisibilityMap:
    """Take the output of nvdiffrast's ``rasterize``.

    Parameters
    ----------
    rast : (1, H, W, 4) or (H, W, 4) float32
        Channel 3 is the triangle's number plus 1, 0 for none; row 0 is the bottom row. On the CPU.
    view, method, **model
        As for :func:`from_ids`.

    Returns
    -------
    VisibilityMap
        Without depths.

    Raises
    ------
    MapError
        If the shape is another, or ids are beyond what float32 counts; or see :func:`from_ids`.
    """
    values = np.asarray(rast)
    values = values[0] if values.ndim == 4 and len(values) == 1 else values
    if values.ndim != 3 or values.shape[2] != 4:
        raise MapError(f"{method}: rast must be (1, H, W, 4) or (H, W, 4), not {np.shape(rast)}")
    ids = values[..., 3]
    _refuse(ids > EXACT_FLOATS, ids, method, "is beyond 2^24, where float32 counts no longer")
    return from_ids(ids, view, background=0, first=1, bottom_up=True, method=method, **model)


def from_open3d(
    primitive_ids: Array,
    view: View | None = None,
    *,
    geometry_ids: Array | None = None,
    starts: Sequence[int] = (0,),
    depth: Array | None = None,
    method: str = "open3d",
    **model: Any,
) -> VisibilityMap:
    """Take the output of Open3D's ``RaycastingScene.cast_rays``.

    Parameters
    ----------
    primitive_ids : (H, W) uint32
        Triangle within its geometry, 4294967295 for a miss; row 0 is the top row.
    view : View, optional
    geometry_ids : (H, W) uint32, optional
        For scenes of several geometries.
    starts : sequence of int
        Number of the first triangle of every geometry.
    depth : (H, W) array, optional
        Along the view axis, in scene units.
    method, **model
        As for :func:`from_ids`.

    Returns
    -------
    VisibilityMap

    Raises
    ------
    MapError
        If a geometry has no start; or see :func:`from_ids`.
    """
    ids = np.asarray(primitive_ids).astype(np.int64)
    covered = ids != MISS
    geometry = np.zeros_like(ids) if geometry_ids is None else np.asarray(geometry_ids).astype(np.int64)
    _refuse(covered & (geometry >= len(starts)), geometry, method, "is a geometry without a start")
    numbers = np.where(covered, ids + np.asarray(starts)[np.where(covered, geometry, 0)], BACKGROUND)
    return from_ids(numbers, view, depth=depth, method=method, **model)


def from_pyrender(
    seg: Array, colours: Sequence[Sequence[int]], view: View | None = None, *, method: str = "pyrender"
) -> VisibilityMap:
    """Take a picture by pyrender's ``RenderFlags.SEG``, which paints every node in one colour.

    Parameters
    ----------
    seg : (H, W, 3) uint8
        Row 0 is the top row; black shows nothing.
    colours : sequence of (red, green, blue)
        The colour of every node's object, in the order of the scene's objects.
    view : View, optional
        Names the objects. Compare with ``by_object(hsr.render(view, "exact"))``: nodes are objects.
    method : str

    Returns
    -------
    VisibilityMap
        Its faces are whole objects; without depths.

    Raises
    ------
    MapError
        If a colour is of no node, as blended colours are; or sizes differ.
    """
    seg = np.asarray(seg)
    if seg.ndim != 3 or seg.shape[2] != 3:
        raise MapError(f"{method}: seg must be (H, W, 3), not {seg.shape}")
    painted, known = _numbers(seg), np.append(0, _numbers(np.reshape(colours, (-1, 3))))
    order = np.argsort(known)
    number = order[np.searchsorted(known, painted, sorter=order).clip(max=len(known) - 1)]
    _refuse(known[number] != painted, painted, method, "is the colour of no node; switch antialiasing off")
    shown = from_ids(number, background=0, first=1, method=method)
    return shown if view is None else replace(shown, manifest=_objects(view.manifest))


# ---------------------------------------------------------------- objects in place of faces


def by_object(map: VisibilityMap) -> VisibilityMap:
    """Return a map that shows which object owns each sample, for renderers that number objects.

    Parameters
    ----------
    map : VisibilityMap
        With a manifest.

    Returns
    -------
    VisibilityMap
        Every object is one face, numbered in the order of the manifest; who may own ties, too. It is
        no map of the scene's faces any more: give no scene to a check of it.

    Raises
    ------
    MapError
        If the map does not say which faces belong to which object.

    Examples
    --------
    >>> import hsr
    >>> from hsr.testing import by_object
    >>> map = hsr.render(hsr.load("scenes/cyclic.toml"), "exact", size=(12, 9))
    >>> print(by_object(map).face[6:8])
    [[-1 -1 -1  0  0  0  0  0  1 -1 -1 -1]
     [-1 -1  0  2 -1 -1 -1 -1 -1  1 -1 -1]]
    """
    if not map.manifest:
        raise MapError(f"the map of {map.method} has no manifest: its objects are not known")
    starts = np.array([entry["first"] for entry in map.manifest])

    def owner(face: Array) -> Ints:
        return (np.searchsorted(starts, face, side="right") - 1).astype(np.int32)

    ties = None if map.admissible is None else _tied_objects(map.admissible, owner(map.admissible.face))
    return replace(map, face=owner(map.face), manifest=_objects(map.manifest), hashes={}, admissible=ties)


def _tied_objects(ties: Admissible, objects: Ints) -> Admissible:
    """Name each object that may own a sample once."""
    pairs = np.unique(np.stack([np.repeat(ties.sample, np.diff(ties.start)), objects], axis=1), axis=0)
    start = np.searchsorted(pairs[:, 0], ties.sample)
    return Admissible(ties.sample, np.append(start, len(pairs)), pairs[:, 1].astype(np.int32))


def _objects(manifest: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a manifest in which every object is one face."""
    return [entry | {"first": k, "count": 1, "faces": [entry["name"]]} for k, entry in enumerate(manifest)]

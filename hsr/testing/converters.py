"""Visibility maps from the images of ids that other renderers make; :mod:`hsr.testing.images` reads files.

Other renderers number triangles, in the order in which they were given them. With ``view`` a converter
takes them to be ``view.tessellated().triangles`` and returns the faces they belong to, named as the view
names them; without, the numbers are the faces. Without ``depth`` a map tells no depths.

A map is called after its renderer. Its wrong samples are put down to causes by a model of it: the one that
is told, ``model="float32", subpixel_bits=4`` (see :func:`hsr.testing.modelled`), or else one that is found.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL.PngImagePlugin import PngImageFile

from hsr.base.arrays import Array, Ints
from hsr.base.errors import MapError, told_briefly
from hsr.models.foreign import modelled
from hsr.problem.map import BACKGROUND, NO_DEPTH, Admissible, VisibilityMap
from hsr.problem.view import MAX_SIDE, View

PNG = b"\x89PNG\r\n\x1a\n"
"""How a PNG file begins."""

MISS = 0xFFFFFFFF
"""Open3D's id of a ray that hits nothing."""


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
    number = _whole(ids, method, "ids")
    covered = number != background
    number = np.where(covered, number - first, BACKGROUND)
    depths = (
        np.full(number.shape, np.nan) if depth is None else _grid(depth, method, "depth").astype(np.float64)
    )
    if depths.shape != number.shape:
        raise MapError(f"{method}: depth {depths.shape} has not the shape of the ids, {number.shape}")
    if bottom_up:
        number, covered, depths = number[::-1], covered[::-1], depths[::-1]
    face = _faces(number, covered, view, method)
    notes = {"depth_format": NO_DEPTH} if depth is None else {}
    told: dict[str, Any] = {} if view is None else {"manifest": view.manifest, "hashes": view.hashes}
    shown = VisibilityMap(face, np.where(covered, depths, np.inf), method, notes=notes, **told)
    return modelled(shown, **model) if model else shown


def _grid(values: Array, method: str, what: str) -> Array:
    """Return an (H, W) array of real numbers."""
    grid = np.asarray(values)
    if grid.ndim != 2 or grid.dtype.kind not in "biuf" or not grid.size:
        raise MapError(f"{method}: {what} must be an (H, W) array, not {grid.shape} {grid.dtype}")
    return grid


def _whole(ids: Array, method: str, what: str) -> Array:
    """Return ids (H, W) as int64."""
    grid = _grid(ids, method, what)
    with np.errstate(invalid="ignore"):  # NaN becomes a number, which differs from it
        number = grid.astype(np.int64)
    refuse(number != grid, grid, method, "is no whole number; switch off antialiasing, which blends ids")
    if grid.dtype.kind == "f":
        bits = np.finfo(grid.dtype).nmant + 1
        refuse(grid > 2**bits, grid, method, f"is beyond 2^{bits}, where {grid.dtype} counts no longer")
    return number


def _faces(number: Array, covered: Array, view: View | None, method: str) -> Ints:
    if view is not None:
        check_size(number, view, method)
    owner = None if view is None else view.tessellated().triangle_face
    last = int(np.iinfo(np.int32).max) if owner is None else len(owner) - 1
    strange = covered & ((number < 0) | (number > last))
    refuse(strange, number, method, f"is no triangle: they run from 0 to {last}")
    shown = number.astype(np.int32)
    if owner is not None:
        shown[covered] = owner[number[covered]]
    return shown


def check_size(number: Array, view: View, method: str) -> None:
    """Raise if an image has not the size of the view."""
    if number.shape != (view.height, view.width):
        height, width = number.shape
        sizes = f"{width}x{height} is not the size of the view, {view.width}x{view.height}"
        raise MapError(f"{method}: {sizes}")


def refuse(wrong: Array, values: Array, method: str, why: str) -> None:
    """Raise if any sample is wrong, naming the first."""
    if wrong.any():
        y, x = np.argwhere(wrong)[0]
        others = int(np.count_nonzero(wrong)) - 1
        more = f" and {others} more" if others else ""
        raise MapError(f"{method}: id {values[y, x]} at {x},{y}{more} {why}")


def _numbers(colours: Array) -> Array:
    """Read colours (..., 3 or more) as numbers: ``red * 65536 + green * 256 + blue``."""
    red, green, blue = (colours[..., k].astype(np.int32) for k in range(3))
    return np.asarray(red << 16 | green << 8 | blue)


def read_png(path: str | Path) -> tuple[Array, str, int]:
    """Read a PNG: its pixels, their mode, and the bits of a channel in the file, of which Pillow keeps 8.

    Raises
    ------
    MapError
        If it is none.
    """
    try:
        with Path(path).open("rb") as file:
            magic, width, height, bits = struct.unpack(">8s8xIIB", file.read(25))
            if magic != PNG:
                raise MapError("not a PNG file")
            if max(width, height) > MAX_SIDE:
                raise MapError(f"it is larger than {MAX_SIDE}x{MAX_SIDE}")
            file.seek(0)
            # Image.open would refuse what is large, and takes what is no PNG.
            with PngImageFile(file) as image:
                return np.asarray(image), image.mode, bits
    except Exception as error:  # on a damaged file Pillow raises almost anything
        raise MapError(f"{path}: not a picture that can be read ({told_briefly(error)})") from error


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
    pixels, mode, bits = read_png(path)
    if mode not in ("RGB", "RGBA") or bits != 8 or (mode == "RGBA" and (pixels[..., 3] != 255).any()):
        raise MapError(f"{path}: ids need a PNG of opaque 8-bit RGB, not PNG {mode} of {bits} bits")
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
    return from_ids(
        values[..., 3].astype(np.float32), view, background=0, first=1, bottom_up=True, method=method, **model
    )


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
    ids = _whole(primitive_ids, method, "primitive_ids")
    covered = ids != MISS
    geometry = np.zeros_like(ids) if geometry_ids is None else _whole(geometry_ids, method, "geometry_ids")
    if geometry.shape != ids.shape:
        raise MapError(
            f"{method}: geometry_ids {geometry.shape} have not the shape of the others, {ids.shape}"
        )
    without = (geometry < 0) | (geometry >= len(starts))
    refuse(covered & without, geometry, method, "is a geometry without a start")
    refuse(covered & (ids < 0), ids, method, "is no triangle")
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
        If a colour is of no node, as blended colours are, or of several; or sizes differ.
    """
    seg = np.asarray(seg)
    if seg.ndim != 3 or seg.shape[2] != 3 or seg.dtype != np.uint8:
        raise MapError(f"{method}: seg must be (H, W, 3) uint8, not {seg.shape} {seg.dtype}")
    for colour in colours:
        if len(colour) != 3 or not all(part in range(256) for part in colour):
            raise MapError(f"{method}: {tuple(colour)} is not red, green and blue, each from 0 to 255")
    nodes = np.asarray(colours, dtype=np.int64).reshape(-1, 3)
    painted, known = _numbers(seg), np.append(0, _numbers(nodes))
    found, times = np.unique(known, return_counts=True)
    if (times > 1).any():
        double = tuple(int(found[times > 1][0]).to_bytes(3, "big"))
        raise MapError(f"{method}: the colour {double} is of two nodes, or of a node and what shows nothing")
    order = np.argsort(known)
    number = order[np.searchsorted(known, painted, sorter=order).clip(max=len(known) - 1)]
    refuse(known[number] != painted, painted, method, "is the colour of no node; switch antialiasing off")
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

"""Id images of other programs, read from their files.

======  ================================================================================================
Ending  What is in it
======  ================================================================================================
.png    ids packed in channels of 8 bits, or in grey of 8 or 16
.exr    the same in channels of whole numbers, halves or floats, or Cryptomatte; by the extra ``exr``
.npy    an array (H, W) of ids of any type, or (H, W, C) of channels
.npz    the same, the only one or the one that is called ``ids``; or a map of our own
.raw    channels of little-endian whole numbers, row by row; it needs ``ids`` and ``size``
======  ================================================================================================

Whatever might be taken for ids and is none is refused with the reason. No Python object is ever read.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import ZipFile

import numpy as np

from hsr.base.arrays import Array
from hsr.base.errors import MapError, nearest, told_briefly
from hsr.problem.map import BACKGROUND, VisibilityMap, arrays_in, load_map, name_in, reading
from hsr.problem.view import View
from hsr.testing.converters import check_size, from_ids, read_png, refuse

CHANNELS = "rgba"
"""By which letters packings speak of channels, in the order of pixels."""

BITS = (8, 16, 32)
"""What a channel may have."""

COLOURS = ("RGB", "RGBA")
"""Modes of PNG files that hold ids, besides grey."""


class Packing(NamedTuple):
    """How a pixel holds an id.

    Attributes
    ----------
    channels : str
        From the most significant to the least: ``"rgb"``.
    bits : int
        Of each.
    """

    channels: str
    bits: int

    def __str__(self) -> str:
        return f"{self.channels}{self.bits * len(self.channels)}"

    @property
    def least(self) -> int:
        """How many channels a pixel has at least, in their order."""
        return 1 + max(map(CHANNELS.index, self.channels))

    def numbers(self, pixels: Array, path: Path) -> Array:
        """Read pixels (H, W, C) as numbers (H, W)."""
        if pixels.shape[2] < self.least:
            raise MapError(f"{path}: it has {pixels.shape[2]} channels, too few for ids of {self}")
        if pixels.dtype == np.uint8 and pixels.shape[2] == 4 and "a" not in self.channels:
            alpha = pixels[..., 3]
            refuse(alpha != 255, alpha, f"{path}: alpha", "is not opaque; ids must not be blended")
        held = [pixels[..., CHANNELS.index(letter)] for letter in self.channels]
        if len(held) == 1:
            return np.asarray(held[0])
        if pixels.dtype != np.dtype(f"u{self.bits // 8}"):
            raise MapError(f"{path}: ids of {self} need channels of {self.bits} bits, not {pixels.dtype}")
        number = np.zeros(pixels.shape[:2], np.uint32)
        for channel in held:
            number <<= self.bits
            number |= channel
        return number


RGB = Packing("rgb", 8)
"""How pictures of ids are made mostly."""


def packing(ids: str) -> Packing:
    """Read how a pixel holds an id: ``"rgb24"``.

    Raises
    ------
    MapError
        If it is written in another way.

    Examples
    --------
    >>> packing("bgr24")
    Packing(channels='bgr', bits=8)
    """
    found = re.fullmatch(r"([rgba]+)(8|16|24|32)", ids)
    channels, total = (found[1], int(found[2])) if found else ("", 0)
    bits = total // max(len(channels), 1)
    if bits not in BITS or bits * len(channels) != total or len({*channels}) < len(channels):
        told = "channels from the highest on and their bits together: rgb24, bgr24, rgba32, r8, r16, r32"
        raise MapError(f"ids {ids!r}: write {told}")
    return Packing(channels, bits)


def read_map(
    path: str | Path,
    view: View | None = None,
    *,
    ids: str | None = None,
    background: int | None = None,
    faces: str | Path | None = None,
    flip: bool = False,
    size: tuple[int, int] | None = None,
    method: str = "",
    **model: Any,
) -> VisibilityMap:
    """Read a map of our own, or an image of ids that another program wrote.

    Parameters
    ----------
    path : str or Path
        Its ending says what it is; see the head of this module.
    view : View, optional
        What was rendered: ids are its triangles, see :func:`hsr.testing.from_ids`.
    ids : str, optional
        How a pixel holds an id: its channels from the most significant to the least, and their bits together,
        as ``"rgb24"``, which pictures have by default, ``"bgr24"``, ``"rgba32"``, ``"r16"``. Arrays (H, W)
        hold ids as they are.
    background : int, optional
        The id of samples that show nothing; 0 by default, in arrays of signed numbers -1.
        Triangles count from 1 where it is 0, else from 0.
    faces : str or Path, optional
        JSON or CSV that tells which face each id is, by number or by name; several ids may be one face.
    flip : bool
        Whether row 0 is the bottom row.
    size : (width, height), optional
        Of raw files.
    method : str
        What to call the renderer; the name of the file by default.
    **model
        As for :func:`hsr.testing.from_ids`.

    Returns
    -------
    VisibilityMap

    Raises
    ------
    MapError
        If the file cannot be read, does not hold ids so, or they are none of the view.

    Examples
    --------
    >>> import numpy as np
    >>> from hsr.testing import read_map
    >>> np.save("ids.npy", np.array([[0, 7], [7, 3]], np.uint16))
    >>> print(read_map("ids.npy", background=7).face)
    [[ 0 -1]
     [-1  3]]
    """
    path, called = Path(path), method or Path(path).name
    if _ours(path):
        own = load_map(path)
        return replace(own, method=method or own.method)
    number, named = _ids(path, ids, size)
    nothing = background if background is not None else -1 if number.dtype.kind == "i" else 0
    told: dict[str, Any] = {"bottom_up": flip, "method": called, **model}
    if faces is None and not named:
        return from_ids(number, view, background=nothing, first=int(nothing == 0), **told)
    source = path if faces is None else Path(faces)
    pairs = [(name, name) for name in named] if faces is None else _pairs(source)
    table = {**_table(pairs, named, view, source), nothing: BACKGROUND}
    shown = from_ids(_looked_up(number, table, called, source), **told)
    return shown if view is None else _of(view, shown)


def size_of(path: str | Path, ids: str | None = None) -> tuple[int, int]:
    """Return width and height of a map of our own, or of an image of ids.

    Raises
    ------
    MapError
        As for :func:`read_map`; or if the file is raw.
    """
    number = load_map(path).face if _ours(Path(path)) else _ids(Path(path), ids, None)[0]
    return number.shape[1], number.shape[0]


# ---------------------------------------------------------------- files

Ids = tuple[Array, Mapping[str, int]]
"""Numbers (H, W), and those that have names."""


def _ours(path: Path) -> bool:
    """Tell whether a file is a map of our own, or nothing, which reading it as one tells best."""
    if path.suffix.lower() != ".npz":
        return False
    try:
        with ZipFile(path) as archive:
            return "meta.npy" in archive.namelist()
    except Exception:  # on a damaged file zipfile raises almost anything
        return True


def _ids(path: Path, ids: str | None, size: tuple[int, int] | None) -> Ids:
    if not path.is_file():
        raise MapError(f"{path}: no such file")
    if path.suffix.lower() not in READERS:
        raise MapError(f"{path}: ids are read from {', '.join(READERS)}")
    number, named = READERS[path.suffix.lower()](path, None if ids is None else packing(ids), size)
    if number.ndim != 2 or number.dtype.kind not in "iuf":
        raise MapError(f"{path}: ids must be numbers (H, W), or (H, W, C), not {number.shape} {number.dtype}")
    return number, named


def _png(path: Path, how: Packing | None, size: tuple[int, int] | None) -> Ids:
    del size
    (pixels, mode, bits), wanted = read_png(path), how or RGB
    called = {"L": "grey", "I": "grey", "I;16": "grey", "1": "grey", "P": "a palette"}.get(mode, mode)
    grey = called == "grey" and bits in BITS
    if bits != wanted.bits or (wanted.channels != "r" if grey else bits != 8 or mode not in COLOURS):
        can = f"say ids r{bits}" if grey else "write ids as RGB of 8 bits a channel"
        raise MapError(f"{path}: it is {called} of {bits} bits, and no ids of {wanted}; {can}")
    return wanted.numbers(np.atleast_3d(pixels), path), {}


def _npy(path: Path, how: Packing | None, size: tuple[int, int] | None) -> Ids:
    del size
    with reading(path), path.open("rb") as file:
        found: Array = np.lib.format.read_array(file, allow_pickle=False)
    return (how or RGB).numbers(found, path) if found.ndim == 3 else found, {}


def _npz(path: Path, how: Packing | None, size: tuple[int, int] | None) -> Ids:
    del size
    held = arrays_in(path)
    name = "ids" if "ids" in held or len(held) != 1 else next(iter(held))
    if name not in held:
        raise MapError(f"{path}: which of {', '.join(held) or 'no arrays'} is it? call that one 'ids'")
    return (how or RGB).numbers(held[name], path) if held[name].ndim == 3 else held[name], {}


def _raw(path: Path, how: Packing | None, size: tuple[int, int] | None) -> Ids:
    if how is None or size is None:
        raise MapError(f"{path}: raw bytes do not say what they are; give ids, such as r32, and size")
    (width, height), bytes_each = size, how.least * how.bits // 8
    taken, held = width * height * bytes_each, path.stat().st_size
    if taken != held:
        raise MapError(f"{path}: {width}x{height} ids of {how} take {taken:,} bytes, and it has {held:,}")
    pixels = np.fromfile(path, f"<u{how.bits // 8}").reshape(height, width, how.least)
    return how.numbers(pixels, path), {}


def _exr(path: Path, how: Packing | None, size: tuple[int, int] | None) -> Ids:
    del size
    try:
        import OpenEXR
    except ImportError:
        raise MapError(f"{path}: to read it, install hsr-lab[exr]") from None
    try:
        with OpenEXR.File(str(path), separate_channels=True) as file:
            facts = dict(file.header())  # which closing the file empties
            held = {name: np.asarray(channel.pixels) for name, channel in file.channels().items()}
    except Exception as error:  # whatever a damaged file makes it raise
        raise MapError(f"{path}: not an EXR that can be read ({told_briefly(error)})") from error
    if key := next((key for key in facts if re.fullmatch("cryptomatte/.*/manifest", key)), None):
        return _cryptomatte(path, held, facts[key.replace("manifest", "name")], facts[key])
    name = next(iter(held)) if len(held) == 1 else how.channels.upper() if how else ""
    if name not in held:
        raise MapError(f"{path}: say which of its channels {', '.join(held)} holds ids, such as ids r32")
    return held[name], {}


def _cryptomatte(path: Path, held: Mapping[str, Array], layer: str, manifest: str) -> Ids:
    """Take the id of the first rank, a hash in the bits of a float, where it covers the pixel alone."""
    try:
        hashed, cover, other = (held[f"{layer}00.{letter}"] for letter in "RGA")
        names = {name: int(text, 16) for name, text in json.loads(manifest).items()}
    except (KeyError, ValueError, AttributeError) as error:
        raise MapError(f"{path}: its Cryptomatte is not whole ({told_briefly(error)})") from None
    blended = (other > 0) | ((cover > 0) & (cover < 1))
    refuse(blended, cover, str(path), "covers a part of the pixel; render one sample a pixel, no filter")
    ids = np.ascontiguousarray(hashed, np.float32).view(np.uint32)
    return np.where(cover > 0, ids, np.uint32(0)), names


READERS: Mapping[str, Callable[[Path, Packing | None, tuple[int, int] | None], Ids]] = {
    ".png": _png,
    ".exr": _exr,
    ".npy": _npy,
    ".npz": _npz,
    ".raw": _raw,
}
"""By the endings of files."""


# ---------------------------------------------------------------- which face an id is


def number_of(text: str) -> int:
    """Read an id: ``12``, ``0x0c`` or the colour ``#00000c``.

    Raises
    ------
    ValueError
        If it is none.
    """
    return int(text[1:], 16) if text.startswith("#") else int(text, 0)


Pairs = list[tuple[str, str]]
"""Ids and faces, as a file tells them."""


def _table(pairs: Pairs, named: Mapping[str, int], view: View | None, source: Path) -> dict[int, int]:
    """Return the face of every id, both of which may be told by names."""
    if not pairs:
        raise MapError(f"{source}: it tells no faces; write lines ID,FACE")
    words = [face for _, face in pairs if not face.isdecimal()]
    if words and view is None:
        raise MapError(f"{source}: {words[0]!r} is a name; say of which scene, or write numbers of faces")
    known = {name_in(view.manifest, k): k for k in range(view.faces)} if words and view else {}
    table: dict[int, int] = {}
    for told, face in pairs:
        if face in words and face not in known:
            raise MapError(f"{source}: {face!r} is no face of the scene; {nearest(face, known)}".rstrip("; "))
        try:
            number = named[told] if told in named else number_of(told)
        except ValueError:
            raise MapError(f"{source}: {told!r} is no id; write 12, 0x0c or #00000c") from None
        owner = known[face] if face in known else int(face)
        if table.setdefault(number, owner) != owner:
            raise MapError(f"{source}: two faces, {table[number]} and {owner}, share the id {told}")
    return table


def _pairs(source: Path) -> Pairs:
    """Read ids and faces from JSON or CSV, which may have a head."""
    try:
        text = source.read_text(encoding="utf-8-sig")
        if source.suffix.lower() == ".json":
            pairs = json.loads(text, object_pairs_hook=list)
        else:
            pairs = [[cell.strip() for cell in row] for row in csv.reader(text.splitlines()) if row]
            pairs = pairs[1:] if pairs and pairs[0][:1] == ["id"] else pairs
        return [(str(told), str(face)) for told, face in pairs]
    except (OSError, ValueError, TypeError, csv.Error, RecursionError) as error:
        raise MapError(f"{source}: no ids and faces ({told_briefly(error)})") from None


def _looked_up(number: Array, table: Mapping[int, int], method: str, source: Path) -> Array:
    """Put faces in the place of ids."""
    ids = np.array(sorted(table), dtype=np.int64)
    place = np.searchsorted(ids, number).clip(max=len(ids) - 1)
    refuse(ids[place] != number, number, method, f"is no face in {source.name}; antialiasing blends ids")
    return np.asarray(np.array([table[one] for one in ids.tolist()])[place])


def _of(view: View, shown: VisibilityMap) -> VisibilityMap:
    """Say that a map of faces shows a view."""
    check_size(shown.face, view, shown.method)
    why = f"is no face: they run from 0 to {view.faces - 1}"
    refuse(shown.face >= view.faces, shown.face, shown.method, why)
    return replace(shown, manifest=view.manifest, hashes=view.hashes)

"""The answer of every method: which face owns each sample, and how deep it is."""

from __future__ import annotations

import json
import time
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from io import BytesIO
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import is_zipfile

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.base.errors import MapError, told_briefly
from hsr.base.files import digest_of, write_whole

BACKGROUND = -1
"""The face id of a sample that no face owns."""

FORMAT = 1
"""The version of the map file."""

NO_DEPTH = {"stored": "nothing"}
"""The note ``depth_format`` of a map that tells no depths."""

READ = "read"
"""The note of a map that was read for a command: the options that say so."""

TOLD = ("method", "work", "notes", "manifest", "hashes")
"""What the file tells beside the arrays: fields of :class:`VisibilityMap`."""


class Admissible(NamedTuple):
    """The tied samples of a view, and all faces that may own each.

    A tie is a sample where the limits of the answer from different directions differ, or where
    surfaces coincide. A method that shows any admissible face there is not wrong.

    Attributes
    ----------
    sample : (n,) int64
        Numbers ``row * W + column`` of the tied samples, ascending.
    start : (n + 1,) int64
    face : (m,) int32
        Those of ``sample[k]`` are ``face[start[k]:start[k + 1]]``, ascending; -1 is the background.
    """

    sample: Array
    start: Array
    face: Ints

    def faces(self, sample: int) -> frozenset[int]:
        """Return the faces that may own a sample; none if it is not tied."""
        k = int(np.searchsorted(self.sample, sample))
        if k == len(self.sample) or self.sample[k] != sample:
            return frozenset()
        return frozenset(self.face[self.start[k] : self.start[k + 1]].tolist())


@dataclass(frozen=True, eq=False)
class VisibilityMap:
    """Which face owns each sample of one view, as one method sees it.

    Attributes
    ----------
    face : (H, W) int32
        Face id of the owner of each sample, ``-1`` for the background. Row 0 is the top row.
    depth : (H, W) float64
        Depth of the owner in scene units along the view axis, ``+inf`` for the background. NaN for
        all faces of a map that tells no depths, which has the note ``NO_DEPTH``.
    method : str
        The name under which the method is registered.
    work : dict of str to int
        What the method counted: faces, spans, rays, nodes and the like.
    seconds : dict of str to float
        Wall time by stage: ``prepare`` (and ``build``, ``read`` where a method has them), ``render``.
    notes : dict of str to Any
        What a person should know beside the numbers: the driver, whether culling was sufficient;
        ``depth_format``, see :func:`depth_format`. JSON values only.
    manifest : list of dict
        One entry an object: ``name``, ``shape``, ``first`` (its first face id), ``count``, and
        ``faces`` (their names; absent for meshes, whose faces are the triangles as read).
    hashes : dict of str to str
        SHA-256 of the ``scene``, the ``camera`` and the ``size`` that were rendered.
    admissible : Admissible or None
        Who may own the tied samples, from a method that knows.
    """

    face: Ints
    depth: Floats
    method: str
    work: dict[str, int] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    notes: dict[str, Any] = field(default_factory=dict)
    manifest: list[dict[str, Any]] = field(default_factory=list)
    hashes: dict[str, str] = field(default_factory=dict)
    admissible: Admissible | None = None

    def __post_init__(self) -> None:
        if self.face.ndim != 2 or self.face.shape != self.depth.shape:
            raise MapError(f"face {self.face.shape} and depth {self.depth.shape} must be one (H, W) grid")

    @property
    def height(self) -> int:
        """Number of rows."""
        return int(self.face.shape[0])

    @property
    def width(self) -> int:
        """Number of columns."""
        return int(self.face.shape[1])

    @property
    def tells_depth(self) -> bool:
        """Whether the map holds depths, and not faces alone."""
        return bool(self.notes.get("depth_format") != NO_DEPTH)

    @cached_property
    def digest(self) -> str:
        """The SHA-256 of faces and depths."""
        return digest_of([self.face.tobytes(), self.depth.tobytes()])

    def admits(self, face: Ints) -> Bools:
        """Tell where another map shows an owner that this one does not contradict.

        Parameters
        ----------
        face : (H, W) int32
            The faces another method shows.

        Returns
        -------
        (H, W) bool
            Whether they are the owners here or, at a tie, others who may own it.

        Examples
        --------
        >>> import numpy as np
        >>> import hsr
        >>> scene = hsr.load("scenes/coplanar.toml")
        >>> truth = hsr.render(scene, "exact", size=(8, 6))
        >>> other = hsr.render(scene, "painter", size=(8, 6))
        >>> print((other.face != truth.face).sum(), (~truth.admits(other.face)).sum())
        1 0
        """
        fine: Bools = (face == self.face).ravel()
        if self.admissible is not None:
            tied = np.repeat(self.admissible.sample, np.diff(self.admissible.start))
            fine[tied[face.ravel()[tied] == self.admissible.face]] = True
        return fine.reshape(face.shape)

    def name_of(self, face: int) -> str:
        """Return what a person calls a face: ``cube.top``, ``bunny#18211`` or ``background``.

        Examples
        --------
        >>> import hsr
        >>> map = hsr.render(hsr.load("scenes/cube.toml"), size=(10, 8))
        >>> map.name_of(4), map.name_of(-1)
        ('cube.front', 'background')
        """
        return name_in(self.manifest, face)

    def _repr_html_(self) -> str:
        """Show the map in a notebook."""
        from hsr.pictures.notebook import map_figure  # Pillow and its like are for pictures only

        return map_figure(self.method, self.face, self.depth)

    def save(self, path: str | Path) -> None:
        """Write the map as ``.npz``: the same answer gives the same bytes.

        Times are left out for that reason; everything else is read back by :func:`load_map`.

        Raises
        ------
        MapError
            If the file cannot be written.

        Examples
        --------
        >>> import hsr
        >>> hsr.render(hsr.load("scenes/cube.toml"), size=(10, 8)).save("cube.npz")
        >>> hsr.load_map("cube.npz").method
        'zbuffer'
        """
        write_whole(path, self.encoded(), "the map", MapError)

    def encoded(self) -> bytes:
        """Return what :meth:`save` writes."""
        meta = {"hsr": FORMAT} | {key: getattr(self, key) for key in TOLD}
        text = json.dumps(meta, sort_keys=True, separators=(",", ":"))
        file = BytesIO()
        np.savez_compressed(file, meta=np.array(text, dtype=np.str_), **self._arrays())  # type: ignore[arg-type]
        return file.getvalue()

    def _arrays(self) -> dict[str, Array]:
        """Return the arrays of the file by name."""
        arrays: dict[str, Array] = {"face": self.face, "depth": self.depth}
        if self.admissible is not None:
            arrays |= {f"tie_{name}": array for name, array in self.admissible._asdict().items()}
        return arrays


def name_in(manifest: Sequence[Mapping[str, Any]], face: int) -> str:
    """Return what a person calls a face of the objects of a manifest; see ``VisibilityMap.name_of``."""
    place = bisect_right(manifest, face, key=itemgetter("first")) - 1
    if place >= 0 and face - manifest[place]["first"] < manifest[place]["count"]:
        return face_name(manifest[place], face - manifest[place]["first"])
    return "background" if face == BACKGROUND else f"unknown face {face}"


def face_name(entry: Mapping[str, Any], offset: int) -> str:
    """Name the face at ``offset`` within one object's manifest entry."""
    names = entry.get("faces")
    if not names:
        return f"{entry['name']}#{offset}"
    return str(entry["name"]) if len(names) == 1 else f"{entry['name']}.{names[offset]}"


def load_map(path: str | Path) -> VisibilityMap:
    """Read a map that :meth:`VisibilityMap.save` wrote.

    Raises
    ------
    MapError
        If the file is missing, or is not a map of this version.

    Examples
    --------
    >>> import hsr
    >>> hsr.render(hsr.load("scenes/cube.toml"), size=(10, 8)).save("cube.npz")
    >>> print(hsr.load_map("cube.npz").face[1])
    [-1  4  0  0  0  0  0  0 -1 -1]
    """
    from hsr.problem.map_file import check_facts, ties_of  # pydantic takes long to import

    held = arrays_in(path)
    try:
        face, depth, meta = (held[name] for name in ("face", "depth", "meta"))
        facts = json.loads(str(meta))
        if not isinstance(facts, dict) or facts.get("hsr") != FORMAT:
            raise MapError(f"not a visibility map of version {FORMAT}")
        if face.dtype != np.int32 or depth.dtype != np.float64:
            raise MapError(f"face must be int32 and depth float64, not {face.dtype}, {depth.dtype}")
        if not face.size:
            raise MapError("it has no samples")
        ties = ties_of(held, face.size)
        shown = np.concatenate([face.ravel(), *ties[2:]])
        check_facts(facts, shown, BACKGROUND)
        told, known = {name: facts[name] for name in TOLD}, Admissible(*ties) if ties else None
        return VisibilityMap(
            np.ascontiguousarray(face), np.ascontiguousarray(depth), **told, admissible=known
        )
    except KeyError as error:
        raise MapError(f"{path}: not a visibility map (it has no {error})") from None
    except (MapError, ValueError, RecursionError) as error:
        raise MapError(f"{path}: {told_briefly(error)}; render it again") from None


def arrays_in(path: str | Path) -> dict[str, Array]:
    """Read the arrays of an ``.npz`` file; never a Python object."""
    with reading(path), Path(path).open("rb") as file:
        if not is_zipfile(file):
            raise MapError(f"{path}: not a visibility map (no .npz file)")
        file.seek(0)
        with np.load(file, allow_pickle=False) as arrays:
            return dict(arrays)


@contextmanager
def reading(path: str | Path) -> Iterator[None]:
    """Turn what NumPy raises of a file into one line."""
    try:
        yield
    except FileNotFoundError:
        raise MapError(f"{path}: no such file; write one with 'hsr render SCENE -o {path}'") from None
    except MapError:
        raise
    except Exception as error:  # on a damaged file zipfile, zlib and NumPy raise almost anything
        why = "it holds Python objects, which are not read" if "pickle" in str(error) else told_briefly(error)
        raise MapError(f"{path}: not a visibility map ({why})") from error


def depth_format(
    stored: str, step: float, near: float, far: float, perspective: bool = True
) -> dict[str, Any]:
    """Describe how a method stored its depths, for the note ``depth_format`` of its map.

    Parameters
    ----------
    stored : {"window", "linear", "distance"}
        ``window``: affine on the screen, 0 at near and 1 at far; ``linear``: with the distance, 0 at near
        and 1 at far; ``distance``: along the view axis.
    step : float
        Distance of neighbouring values: of 1 (window, linear), or relative to the depth (distance).
    near, far : float
        Of the view; far may be infinite, then it is noted as None.
    perspective : bool
        Of the view: whether window depth runs with the inverse of the distance, or with it.
    """
    known = far if far < float("inf") else None
    return {"stored": stored, "step": step, "near": near, "far": known, "perspective": perspective}


class Clock:
    """Wall time by named stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Add the time of the ``with`` block to ``stage``."""
        start = time.perf_counter()
        yield
        self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start

"""Where two visibility maps differ, sample by sample, and in what way.

Maps are compared by face id and by depth, never by colour: two faces may well be painted alike.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from hsr.base.arrays import Array, Bools, Floats, Pixels
from hsr.base.errors import MapError
from hsr.pictures.maps import class_picture
from hsr.pictures.palette import CLASS_COLOURS
from hsr.problem.map import BACKGROUND, VisibilityMap, depth_format

LISTED_JSON = 50
"""How many clusters the JSON form lists; the count is always that of all."""

FLOAT64 = depth_format("distance", 2.0**-52, 0.0, math.inf)
"""How a map without the note ``depth_format`` holds its depths."""

NO_FACE = BACKGROUND - 1
"""What surrounds a map: equal to no face and not to the background."""


class SampleClass(IntEnum):
    """How a sample of map a compares with the same sample of map b, the reference."""

    SAME = 0
    MISSING = 1
    EXTRA = 2
    WRONG_FACE = 3
    DEPTH_ONLY = 4
    TIE = 5

    @property
    def label(self) -> str:
        """The name as people read it: ``wrong face``."""
        return self.name.lower().replace("_", " ")


OTHER_OWNER = (SampleClass.WRONG_FACE, SampleClass.MISSING, SampleClass.EXTRA)
"""The classes that count as a difference; depth alone and ties are reported, not judged."""

DIFFERENT = tuple(kind.label for kind in (*OTHER_OWNER, SampleClass.DEPTH_ONLY, SampleClass.TIE))
"""Names of all classes but *same*."""


class Cluster(NamedTuple):
    """Differing samples that hang together, over sides or corners.

    Attributes
    ----------
    size : int
        Number of samples.
    box : tuple of 4 int
        ``(row0, column0, row1, column1)``; row0 and column0 belong to it, row1 and column1 do not.
    kind : SampleClass
        The commonest class of its samples.
    sample : tuple of 2 int
        ``(row, column)`` of its first sample in reading order.
    shown, expected : int
        Face ids of a and of b at that sample.
    """

    size: int
    box: tuple[int, int, int, int]
    kind: SampleClass
    sample: tuple[int, int]
    shown: int
    expected: int


class DepthError(NamedTuple):
    """How far the depths lie apart where both maps show the same face, in scene units.

    Attributes
    ----------
    samples : int
        Number of samples at which both maps show the same face, at finite depths; the other figures
        are 0 without any.
    max, mean, rms : float
        Of the absolute difference.
    where : tuple of 2 int or None
        ``(row, column)`` of the largest difference.
    """

    samples: int = 0
    max: float = 0.0
    mean: float = 0.0
    rms: float = 0.0
    where: tuple[int, int] | None = None


class Verdict(NamedTuple):
    """Who is right at the samples where a and b show different owners."""

    a_right: int
    b_right: int
    neither: int


@dataclass(frozen=True, eq=False)
class Difference:
    """Map a judged against map b, the reference.

    Attributes
    ----------
    a, b : VisibilityMap
    classes : (H, W) uint8
        A :class:`SampleClass` per sample; row 0 is the top row.
    depth : DepthError
    truth : VisibilityMap or None
        Tells which of the two is right where they differ.
    """

    a: VisibilityMap
    b: VisibilityMap
    classes: Pixels
    depth: DepthError
    truth: VisibilityMap | None = None

    @cached_property
    def counts(self) -> dict[str, int]:
        """Number of samples of each class, by its name."""
        number = np.bincount(self.classes.ravel(), minlength=len(SampleClass))
        return {kind.label: int(number[kind]) for kind in SampleClass}

    @property
    def total(self) -> int:
        """Number of samples."""
        return int(self.classes.size)

    @cached_property
    def differs(self) -> Bools:
        """Where (H, W) another owner is shown: missing, extra or wrong face."""
        return np.isin(self.classes, OTHER_OWNER)

    @property
    def different(self) -> int:
        """Number of samples at which another owner is shown."""
        return int(np.count_nonzero(self.differs))

    @property
    def same(self) -> bool:
        """Whether both maps show the same owner everywhere. Depths are not judged."""
        return self.different == 0

    @cached_property
    def clusters(self) -> tuple[Cluster, ...]:
        """Connected samples of another owner, the largest first."""
        return self.clusters_of(self.differs)

    @property
    def largest(self) -> int:
        """Number of samples in the largest cluster."""
        return self.clusters[0].size if self.clusters else 0

    @cached_property
    def near(self) -> int:
        """Differing samples whose face b shows at one of the eight neighbours: off by one pixel."""
        around = sliding_window_view(np.pad(self.b.face, 1, constant_values=NO_FACE), (3, 3))
        face = self.a.face[self.differs]
        return int((around[self.differs] == face[:, None, None]).any(axis=(1, 2)).sum())

    @cached_property
    def verdict(self) -> Verdict | None:
        """Given the truth: which of the two is right where they differ."""
        if self.truth is None:
            return None
        a, b = (int((self.differs & (map.face == self.truth.face)).sum()) for map in (self.a, self.b))
        return Verdict(a, b, self.different - a - b)

    def clusters_of(self, mask: Bools) -> tuple[Cluster, ...]:
        """Find the groups of samples of a mask (H, W) that hang together, over sides or corners.

        Returns
        -------
        tuple of Cluster
            Largest first, equal ones in reading order.
        """
        samples = np.flatnonzero(mask)
        if not len(samples):
            return ()
        # Both are slow to import, and most maps that are compared do not differ.
        from scipy.ndimage import find_objects
        from skimage.measure import label

        labels = label(mask, connectivity=2)
        number = labels.ravel()[samples] - 1
        _, first, size = np.unique(number, return_index=True, return_counts=True)
        kinds = number * len(SampleClass) + self.classes.ravel()[samples]
        tally = np.bincount(kinds, minlength=len(size) * len(SampleClass)).reshape(len(size), -1)
        box = ((y.start, x.start, y.stop, x.stop) for y, x in find_objects(labels))
        kind = map(SampleClass, tally.argmax(axis=1).tolist())
        sample = (divmod(one, self.a.width) for one in samples[first].tolist())
        shown, expected = (map.face.ravel()[samples[first]].tolist() for map in (self.a, self.b))
        found = map(Cluster, size.tolist(), box, kind, sample, shown, expected)
        return tuple(sorted(found, key=lambda cluster: -cluster.size))

    def summary(self, clusters: int | None = 5) -> str:
        """Return the figures in one line, and a line for each of the largest clusters.

        Parameters
        ----------
        clusters : int or None
            How many clusters to name at most; all of them for None.

        Examples
        --------
        >>> import numpy as np
        >>> import hsr
        >>> from hsr.testing import from_ids
        >>> mine = from_ids(np.array([[0, 0, 1], [0, 2, 1]]), method="mine")
        >>> theirs = from_ids(np.array([[0, 0, 1], [0, 1, 1]]), method="theirs")
        >>> print(hsr.compare(mine, theirs).summary())
        mine vs theirs  3x2  1 differ (1 wrong face), largest cluster 1, 0 off by one pixel
          1 wrong face  column 1, row 1  shows unknown face 2, expected unknown face 1
        """
        named = self.clusters[:clusters]
        lines = [self._headline(), *(f"  {self.describe(cluster)}" for cluster in named)]
        if len(named) < len(self.clusters):
            lines.append(f"  and {len(self.clusters) - len(named)} more clusters")
        if self.verdict is not None:
            a, b, neither = self.verdict
            lines.append(f"  right there: {self.a.method} {a}, {self.b.method} {b}, neither {neither}")
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        """Show the difference in a notebook."""
        from hsr.pictures.notebook import figure  # Pillow and its like are for pictures only

        return figure(self.picture(), f"where {self.a.method} differs from {self.b.method}", str(self))

    def picture(self) -> Pixels:
        """Paint where another owner is shown, small: a wrong face before what is missing or extra.

        Returns
        -------
        (h, w, 4) uint8
            See :func:`hsr.pictures.maps.class_picture`.
        """
        colours = {int(kind): CLASS_COLOURS[kind.label] for kind in OTHER_OWNER}
        return class_picture(self.classes, self.b.face != BACKGROUND, colours)

    def _headline(self) -> str:
        size, counts = f"{self.a.width}x{self.a.height}", self.counts
        told = {kind: f"{counts[kind.label]} {kind.label}" for kind in SampleClass if counts[kind.label]}
        text = f"{self.a.method} vs {self.b.method}  {size}  {self.different} differ"
        if not self.same:
            parts = ", ".join(told[kind] for kind in OTHER_OWNER if kind in told)
            text += f" ({parts}), largest cluster {self.largest}, {self.near} off by one pixel"
        beside = (SampleClass.DEPTH_ONLY, SampleClass.TIE)
        return text + "".join(f"; {told[kind]}" for kind in beside if kind in told)

    def describe(self, cluster: Cluster) -> str:
        """Say in one line where a cluster is and which faces are concerned."""
        row0, column0, row1, column1 = cluster.box
        where = f"{span('column', column0, column1)}, {span('row', row0, row1)}"
        faces = f"shows {self.a.name_of(cluster.shown)}, expected {self.b.name_of(cluster.expected)}"
        return f"{cluster.size} {cluster.kind.label}  {where}  {faces}"

    def to_json(self) -> dict[str, Any]:
        """Return all figures as JSON values; clusters up to the first 50."""
        verdict = self.verdict
        return {
            "a": self.a.method,
            "b": self.b.method,
            "size": [self.a.width, self.a.height],
            "total": self.total,
            "different": self.different,
            "same": self.same,
            "near": self.near,
            "counts": self.counts,
            "cluster_count": len(self.clusters),
            "largest_cluster": self.largest,
            "clusters": [self._cluster_json(cluster) for cluster in self.clusters[:LISTED_JSON]],
            "depth": self.depth._asdict() | {"where": self.depth.where and _at(*self.depth.where)},
            "truth": verdict and verdict._asdict(),
        }

    def _cluster_json(self, cluster: Cluster) -> dict[str, Any]:
        row0, column0, row1, column1 = cluster.box
        return {
            "size": cluster.size,
            "class": cluster.kind.label,
            "box": {"x": [column0, column1], "y": [row0, row1]},
            "sample": _at(*cluster.sample),
            "shown": self.a.name_of(cluster.shown),
            "expected": self.b.name_of(cluster.expected),
        }


def _at(row: int, column: int) -> dict[str, int]:
    return {"x": column, "y": row}


def span(what: str, start: int, stop: int) -> str:
    """Name the rows or columns from ``start`` to before ``stop``: ``row 4``, ``rows 4..7``."""
    return f"{what} {start}" if stop == start + 1 else f"{what}s {start}..{stop - 1}"


# ---------------------------------------------------------------- comparing


def compare(a: VisibilityMap, b: VisibilityMap, truth: VisibilityMap | None = None) -> Difference:
    """Judge a map against a reference.

    Every sample falls into one class, the first that applies:

    * *tie*: they show different owners, and b knows that either may own the sample;
    * *missing*: b shows a face and a the background;
    * *extra*: a shows a face and b the background;
    * *wrong face*: both show a face, and not the same;
    * *depth only*: both show the same face, at depths further apart than rounding explains; never
      where one of the maps tells no depths;
    * *same*.

    Rounding explains this much. Let a map store depth as a number with spacing ``s`` between
    neighbouring values, which in scene units is ``step(d)`` at depth ``d`` (:func:`depth_step`).
    A scan-line method reaches a sample by at most H steps down an edge and W along a span; each
    addition is off by at most half a spacing, so the stored value is off by at most
    ``(W + H) / 2`` spacings. Both maps may err, in opposite directions, so depths differ beyond
    rounding where ``|d_a - d_b| > (W + H) / 2 * (step_a(d_a) + step_b(d_b))``, strictly.

    Parameters
    ----------
    a : VisibilityMap
        The map that is judged.
    b : VisibilityMap
        The reference.
    truth : VisibilityMap, optional
        Tells which of the two is right where their faces differ.

    Returns
    -------
    Difference

    Raises
    ------
    MapError
        If the maps have different sizes, or show different scenes or by different cameras.

    Examples
    --------
    >>> import hsr
    >>> view = hsr.view(hsr.load("scenes/cyclic.toml"), size=(12, 9))
    >>> difference = hsr.compare(hsr.render(view, "painter"), hsr.render(view, "exact"))
    >>> print(difference.classes)  # 3 is a wrong face, 4 the right one at another depth
    [[0 0 0 0 0 0 0 0 0 0 0 0]
     [0 0 0 0 0 0 0 0 0 0 0 0]
     [0 0 0 0 0 3 0 0 0 0 0 0]
     [0 0 0 0 0 0 0 0 0 0 0 0]
     [0 0 0 0 0 0 4 0 0 0 0 0]
     [0 0 0 0 0 0 0 0 0 4 0 0]
     [0 0 0 0 0 4 0 4 3 0 0 0]
     [0 0 0 0 0 0 0 0 0 0 0 0]
     [0 0 0 0 0 0 0 0 0 0 0 0]]
    >>> difference.different, difference.same
    (2, False)
    """
    _check_comparable(a, b)
    if truth is not None:
        _check_comparable(a, truth)
    return Difference(a, b, *_classify(a, b), truth)


def _check_comparable(a: VisibilityMap, b: VisibilityMap) -> None:
    if a.face.shape != b.face.shape:
        one, other = (f"{map.method} at {map.width}x{map.height}" for map in (a, b))
        raise MapError(f"cannot compare {one} with {other}: render both at one size")
    for what in ("scene", "camera"):
        if what in a.hashes and what in b.hashes and a.hashes[what] != b.hashes[what]:
            pair = f"{a.method} with {b.method}"
            raise MapError(f"cannot compare {pair}: they show different {what}s; render both anew")


def depth_step(map: VisibilityMap, depth: Floats) -> Floats:
    """Distance between neighbouring depths that a map can hold, to first order.

    A window depth under perspective is ``z = (1/near - 1/d) / (1/near - 1/far)``; its derivative by
    d is ``1 / (d^2 (1/near - 1/far))``, so a spacing ``s`` of z is ``s d^2 (1/near - 1/far)`` of d.
    Of a parallel view, and of linear depth, ``z = (d - near) / (far - near)``, and a spacing is
    ``s (far - near)`` everywhere. A stored distance is a float: its spacing is relative, ``s |d|``.

    Parameters
    ----------
    map : VisibilityMap
        Its note ``depth_format`` says how depth is stored; float64 distance without it.
    depth : (n,) float64
        Scene units along the view axis.

    Returns
    -------
    (n,) float64
        Scene units.
    """
    form = map.notes.get("depth_format", FLOAT64)
    step, near = float(form["step"]), float(form["near"])
    far = math.inf if form["far"] is None else float(form["far"])
    if form["stored"] == "distance":
        return np.asarray(step * np.abs(depth), dtype=np.float64)
    if form["stored"] == "window" and form["perspective"]:
        return step * depth**2 * (1.0 / near - 1.0 / far)
    return np.full_like(depth, step * (far - near))


def agreed_depths(a: VisibilityMap, b: VisibilityMap) -> tuple[Array, Floats, Floats]:
    """Return the samples (n,) at which two maps show the same face, and how deep each shows it."""
    samples = np.flatnonzero((a.face == b.face) & (a.face != BACKGROUND))
    return samples, a.depth.ravel()[samples], b.depth.ravel()[samples]


def _classify(a: VisibilityMap, b: VisibilityMap) -> tuple[Pixels, DepthError]:
    other = a.face != b.face
    classes = np.full(other.shape, SampleClass.SAME, dtype=np.uint8)
    classes[other] = SampleClass.WRONG_FACE
    classes[other & (a.face == BACKGROUND)] = SampleClass.MISSING
    classes[other & (b.face == BACKGROUND)] = SampleClass.EXTRA
    classes[other & b.admits(a.face)] = SampleClass.TIE
    if not (a.tells_depth and b.tells_depth):
        return classes, DepthError()
    samples, depth_a, depth_b = agreed_depths(a, b)
    with np.errstate(invalid="ignore", over="ignore"):  # a face at infinite depth: no number, so no gap
        gap = np.abs(depth_a - depth_b)
        allowed = (a.width + a.height) / 2.0 * (depth_step(a, depth_a) + depth_step(b, depth_b))
    known = np.isfinite(gap)
    classes.ravel()[samples[~known | (gap > allowed)]] = SampleClass.DEPTH_ONLY
    return classes, _depth_error(gap[known], samples[known], a.width)


def _depth_error(gap: Floats, samples: Array, width: int) -> DepthError:
    if not len(gap):
        return DepthError()
    worst = int(gap.argmax())
    most = float(gap[worst])
    share = gap / (most or 1.0)  # squares of what is at most 1 are finite
    rms = most * math.sqrt(float(np.square(share).mean()))
    where = divmod(int(samples[worst]), width)
    return DepthError(len(gap), most, most * float(share.mean()), rms, where)

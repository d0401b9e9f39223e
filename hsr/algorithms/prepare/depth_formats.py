"""The formats of a depth buffer: what of depth is interpolated, what is stored of it, what that is worth.

What is interpolated must be affine on the screen: with d the depth along the view axis, under perspective
anything ``a / d + b``. Here all of them grow away from the eye, so that one test serves them all.

===========  ==========================================  =================================================
Kind         Interpolated                                 Stored
===========  ==========================================  =================================================
window       z, 0 at near and 1 at far                    z, as a float or as one of ``2**N`` levels
reversed     z - 1, by a formula that loses no digits     the same, as a float: dense where z - 1 is near 0
reciprocal   -1 / d                                       the same, as a float
linear       -1 / d                                       (d - near) / (far - near), as a level; d is not
                                                          affine on the screen, and needs a division a
                                                          fragment
===========  ==========================================  =================================================

Floats have a sign, so storing ``z - 1`` with *less* is storing ``1 - z``, 1 at near and 0 at far, with
*greater*: the reversed buffer with a clip range of [0, 1] (Lapidous & Jiao, *Optimal Depth Buffer for
Low-Cost Graphics Hardware*, 1999). Storing 1/w with *greater* likewise; linear depth is the W buffer (Blinn,
*W Pleasure, W Fun*, IEEE Computer Graphics and Applications 18, 1998).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.errors import MethodError
from hsr.kernels.depth_buffer import LESS, Form
from hsr.kernels.projection import to_depth
from hsr.problem.map import BACKGROUND, depth_format
from hsr.problem.view import View

Real = type[np.floating[Any]]


class Format(NamedTuple):
    """A depth format by itself.

    Attributes
    ----------
    kind : {"window", "reversed", "reciprocal", "linear"}
    held : type
        Of the numbers in the buffer.
    bits : int
        Of the integers that are used, ``0 .. 2**bits - 1``; 0 for floats.
    """

    kind: str
    held: type[Any]
    bits: int = 0


FORMATS = {
    "float64": Format("window", np.float64),
    "d16": Format("window", np.uint16, 16),
    "d24": Format("window", np.uint32, 24),
    "d32f": Format("window", np.float32),
    "d32f-reversed": Format("reversed", np.float32),
    "w16": Format("linear", np.uint16, 16),
    "w24": Format("linear", np.uint32, 24),
    "1/w": Format("reciprocal", np.float32),
}


@dataclass(frozen=True)
class Depths:
    """A depth format in one view.

    Attributes
    ----------
    kind, held, bits
        See :class:`Format`; in a parallel view, where z is linear itself, linear depth is window depth.
    guard : int or None
        If depth is stepped in whole numbers, of how many bits more than the level has; else None.
    near, far : float
        In scene units; far may be infinite, but not for linear depth.
    perspective : bool
    """

    kind: str
    held: type[Any]
    bits: int
    guard: int | None
    near: float
    far: float
    perspective: bool

    @property
    def levels(self) -> int:
        """The greatest level; 0 for floats."""
        return (1 << self.bits) - 1

    def interpolated(self, window: Floats, d: Floats) -> Floats:
        """Return what of depths is interpolated.

        Parameters
        ----------
        window, d : (n,) float64
            Window depths, and depths along the view axis in scene units.

        Returns
        -------
        (n,) float64
            In a buffer with guard bits in units of their last; never rounded to whole numbers here.
        """
        if self.kind == "window":
            return window if self.guard is None else window * float(self.levels << self.guard)
        if self.kind == "reversed" and not self.perspective:
            return (d - self.far) / (self.far - self.near)
        with np.errstate(divide="ignore"):  # what lies in the plane of the eye has been clipped away
            if self.kind == "reversed":
                return (self.near / self.far - self.near / d) / (1.0 - self.near / self.far)
            return -1.0 / d

    def form(self, test: int) -> Form | None:
        """Tell the kernel what to store, and by which test."""
        if not self.bits:
            return unrounded(test)
        if self.guard is not None:
            return Form(test, self.levels, 2.0**-self.guard, whole=True)
        if self.kind == "window":
            return Form(test, self.levels, float(self.levels), 0.5)
        scale = self.levels / (self.far - self.near)
        return Form(test, self.levels, scale, 0.5 - self.near * scale, -1.0 / self.far)

    def distance(self, stored: Array, face: Ints) -> Floats:
        """Return the depths (H, W) in scene units that a buffer holds, ``+inf`` in the background.

        What rounding has carried past near or far is taken back to it. Without a far plane nothing is
        farther than what the last number before infinity stands for.
        """
        drawn = face != BACKGROUND
        if self.kind == "window":
            window = np.where(drawn, stored / float(self.levels), np.inf) if self.bits else stored
            return to_depth(window, self.perspective, (self.near, self.far))
        depth = np.full(face.shape, np.inf)
        depth[drawn] = self._distance(stored[drawn].astype(np.float64))
        return depth

    def _distance(self, stored: Floats) -> Floats:
        if self.kind == "linear":
            return self.near + stored * ((self.far - self.near) / self.levels)
        if not self.perspective:
            return np.clip(self.far + stored * (self.far - self.near), self.near, self.far)
        per_unit = 1.0 if self.kind == "reciprocal" else 1.0 / self.near - 1.0 / self.far
        at_far = 0.0 if self.kind == "reciprocal" else 1.0 / self.far
        least = float(np.finfo(self.held).smallest_subnormal)
        return np.clip(1.0 / (np.maximum(-stored, least) * per_unit + at_far), self.near, self.far)

    def note(self, real: Real) -> dict[str, Any]:
        """Describe the buffer, filled by arithmetic of some type: its note ``depth_format``."""
        stored, step = "window", 1.0 / self.levels if self.bits else _spacing(real, self.held)
        if self.kind == "linear":
            stored = "linear"
        elif self.kind != "window" and self.perspective:
            # Numbers like 1 / d have spacings of at most eps / d, and those are eps d of d.
            stored, step = "distance", float(np.finfo(self.held).eps)
        return depth_format(stored, step, self.near, self.far, self.perspective)


def _spacing(real: Real, held: type[Any]) -> float:
    """Return the widest spacing below 1 of the numbers that are computed and held."""
    return max(float(np.finfo(real).epsneg), float(np.finfo(held).epsneg))


def unrounded(test: int, whole: bool = False) -> Form | None:
    """Tell the kernel to store what is stepped, perhaps in whole numbers, as it is, and by which test."""
    return Form(test, whole=whole) if whole or test != LESS else None


def depths_of(name: str, guard: int | None, view: View, deepest: float) -> Depths:
    """Return a depth format as it is in a view.

    Parameters
    ----------
    name : str
        Of :data:`FORMATS`.
    guard : int or None
        See :class:`Depths`.
    view : View
    deepest : float
        Greatest depth of all that is drawn: if the view has no far plane, linear depth ends one level
        after it, since what is stored as the greatest level cannot be seen.

    Raises
    ------
    MethodError
        If the view is parallel and the format is 1/w.
    """
    kind, held, bits = FORMATS[name]
    far = view.far
    if kind == "reciprocal" and not view.perspective:
        raise MethodError(f"{name} is the same everywhere in a parallel view; choose another depth_format")
    if kind == "linear" and not view.perspective:
        kind = "window"
    elif kind == "linear" and far == np.inf:
        levels = (1 << bits) - 1
        far = view.near + (deepest - view.near or view.near) * (levels / (levels - 1))
    return Depths(kind, held, bits, guard, view.near, far, view.perspective)

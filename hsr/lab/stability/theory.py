"""Closed forms: what a depth buffer resolves, and how far triangles must lie apart.

Depths d are eye distances along the view axis, from ``near`` to ``far``; ``q = 1 / (2**N - 1)`` is the step
of an N-bit buffer. Each resolution is ``dz``, the separation along the axis that is always told apart, by the
spacing of stored numbers divided by the derivative of what is stored (E. Lapidous, G. Jiao, *Optimal Depth
Buffer for Low-Cost Graphics Hardware*, 1999; N. Reed, *Depth Precision Visualized*, 2015).
"""

from __future__ import annotations

import math

U32 = 2.0**-24
"""Unit roundoff of float32."""

U64 = 2.0**-53
"""Unit roundoff of float64."""


def window(d: float, near: float, far: float) -> float:
    """Return window depth ``(1 - near / d) / (1 - near / far)``."""
    return (1.0 - near / d) / (1.0 - near / far)


def integers(bits: int, d: float, near: float, far: float) -> float:
    """Resolve window depth in ``2**bits`` levels: ``k d^2 / (1 - k d)``, ``k = q (far - near) / (far near)``.

    That is the exact distance to the next level; without a far plane ``q d^2 / near`` to first order.
    """
    k = (1.0 / near - 1.0 / far) / (2.0**bits - 1.0)
    return k * d * d / (1.0 - k * d) if k * d < 1.0 else math.inf


def spacing(value: float, mantissa: int = 23, least: int = -149) -> float:
    """Return the distance of neighbouring floats at a positive value; ``2**least`` below the normal ones."""
    return 2.0 ** max(math.frexp(value)[1] - 1 - mantissa, least)


def float_window(d: float, near: float, far: float) -> float:
    """Resolve window depth as float32: near 1 no better than 24 bits."""
    return spacing(window(d, near, far)) * d * d * (1.0 / near - 1.0 / far)


def float_reversed(d: float, near: float, far: float, mantissa: int = 23, least: int = -149) -> float:
    """Resolve ``(near / d - near / far) / (1 - near / far)`` as a float."""
    return spacing(1.0 - window(d, near, far), mantissa, least) * d * d * (1.0 / near - 1.0 / far)


def reversed_through_ndc(d: float, near: float, far: float) -> float:
    """Resolve reversed depth w that went through [-1, 1] as float32, and is kept as float32.

    Two roundings: ``2 w - 1`` moves by half its spacing at most, so of the difference of two of them all but
    one spacing is left, of that of their halves all but half a spacing. What is left must exceed the spacing
    of w, as which the sum with 1/2 is rounded: together ``spacing(w) + spacing(|2 w - 1|) / 2``. Up to
    w = 1/4 the sum is exact (P. Sterbenz, *Floating-Point Computation*, 1974), and ``2**-25`` is all.
    """
    w = 1.0 - window(d, near, far)
    step = 0.5 * spacing(abs(2.0 * w - 1.0)) + (spacing(w) if w > 0.25 else 0.0)
    return step * d * d * (1.0 / near - 1.0 / far)


def linear(bits: int, _: float, near: float, far: float) -> float:
    """Resolve linear depth in ``2**bits`` levels: ``q (far - near)`` everywhere (Blinn's W buffer)."""
    return (far - near) / (2.0**bits - 1.0)


def reciprocal(d: float, *_: float) -> float:
    """Resolve ``1 / d`` as float32: its spacing times d squared."""
    return spacing(1.0 / d) * d * d


def logarithmic(bits: int, d: float, near: float, far: float) -> float:
    """Resolve ``ln(d / near) / ln(far / near)`` in ``2**bits`` levels: ``q d ln(far / near)``."""
    return d * math.log(far / near) / (2.0**bits - 1.0)


def separation(dz: float, d: float, tan_alpha: float, bits: int, footprint: float) -> float:
    """Return how far parallel triangles of any orientation must lie apart to be told apart.

    ``sqrt(dz^2 + (sqrt(2) 2^-b p + dz tan(alpha))^2)``, with p the width of a pixel at that depth and alpha
    the angle of the ray to the view axis, after K. Akeley and J. Su, *Minimum Triangle Separation for
    Correct Z-Buffer Occlusion* (Graphics Hardware 2006). Two planes S apart with unit normal N lie
    ``S cos(alpha) / (N . r)`` apart along the axis where the ray r meets them. Snapping moves each by at
    most ``sqrt(2) 2^-(b+1) p |N_xy|``. Require the rest to be dz, and take the worst N.

    Parameters
    ----------
    dz : float
        Resolution of the depth format there.
    d, footprint : float
        Depth, and width p of a pixel at depth 1.
    tan_alpha : float
    bits : int
        Fraction bits b of snapped corners.
    """
    snap = math.sqrt(2.0) * 2.0**-bits * footprint * d
    return math.hypot(dz, snap + dz * tan_alpha)

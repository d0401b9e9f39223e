"""Exact decisions for the samples that a certified method could not decide in float64.

A certified method proves what it can by bounds on its rounding errors and hands over the rest: samples,
and the pieces of faces that may own each. Here they are decided on the numbers of the view as they stand,
in integers of any length, without rounding:

- A planar piece covers a sample by the signs of its homogeneous edge functions (M. Olano, T. Greer,
  *Triangle Scan Conversion using 2D Homogeneous Coordinates*, 1997), which need no clipping: only what lies
  in front of the eye counts by itself. Near and far are two more half-planes on the face. Along a line of
  sight, pieces are ordered by a function that is affine on the screen: depth in a parallel view, -1 / w under
  perspective. See :mod:`hsr.certify.facets`.
- A sphere, the side of a cylinder, its base and its cap are met where a quadratic vanishes along the line of
  sight; two such roots are compared by squaring. See :mod:`hsr.certify.curved`.

Every sign is that of the limit at (x + e, y + d), to the right and then down, with d positive and smaller
than every power of e (as in H. Edelsbrunner, E. P. Muecke, *Simulation of Simplicity*, ACM Transactions on
Graphics 9(1), 1990). So a sample on an edge belongs to exactly one of the two faces beside it, the one to the
right or else below, and only surfaces that coincide in a whole neighbourhood tie: there the lowest face id
owns. Near and far are closed.
"""

from hsr.certify.decision import Resolved, facets_at, first_pieces, resolve, sights_at

__all__ = ["Resolved", "facets_at", "first_pieces", "resolve", "sights_at"]

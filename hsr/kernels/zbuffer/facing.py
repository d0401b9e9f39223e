"""Clusters of triangles that certainly all turn away from the eye, or all towards it.

Of the normals of a cluster a box is kept, and the products of what is in it with the lines of sight to the
box around the cluster are bounded: if all have one sign, its triangles all show the same side (hierarchical
back-face computation by intervals; Shirmun & Abi-Ezzi, "The Cone of Normals Technique for Fast Processing of
Curved Patches", Computer Graphics Forum 12(3), 1993). Such a cluster need not be looked into where that side
is culled.

A triangle shows its front if the determinant of its corners' clip coordinates (x, y, d) is positive, under
perspective; (x, y, 1) in a parallel view. With the rows x, y and d of the matrix, their offsets t, and the
normal n = (b - a) x (c - a), it is

    n . (det a + q),   det = x . (y x d),   q = t_x (y x d) + t_y (d x x) + t_d (x x y)

under perspective: a seen from the eye, -q / det. In a parallel view det is 0 and q = x x y.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.jit import jit, parallel_jit, prange
from hsr.kernels.culling import CULL_BACK, CULL_FRONT
from hsr.kernels.zbuffer.setup import CLUSTER, U

MODEST = 2.0**200
"""Entries of matrices above this leave all sides uncertain: products of three stay far from overflow."""

LEAST = 2.0**-400
"""More than underflow can bring into a product of three such entries, and of that with a coordinate."""

Vector = tuple[float, float, float]


@parallel_jit
def normal_boxes(vertices: Floats, corner: Ints, slack: Floats, low: Floats, high: Floats) -> None:
    """Find the boxes around the normals of clusters, scaled to length 1.

    Parameters
    ----------
    vertices : (3, V) float64
    corner : (n, 3) int32
    slack : (3,) float64
        By how much the vertices may be off.
    low, high : (3, clusters) float64
        Receive the corners; infinite where some normal is not certain.
    """
    s = max(max(slack[0], slack[1]), slack[2])
    for k in prange(low.shape[1]):
        for axis in range(3):
            low[axis, k], high[axis, k] = np.inf, -np.inf
        for i in range(k * CLUSTER, min((k + 1) * CLUSTER, len(corner))):
            one = side_of(vertices, corner[i, 0], corner[i, 1])
            other = side_of(vertices, corner[i, 0], corner[i, 2])
            normal, _ = cross(one, other)

            # With sides of at most u and v in any coordinate and s the slack, a coordinate of the normal, a
            # difference of two products of differences, is off by at most 4 s (u + v) + 8 s^2 and by
            # roundings of 8 U u v. Both are doubled. By what it is scaled makes no difference to any sign.
            length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
            u, v = greatest(one), greatest(other)
            error = 8.0 * s * (u + v) + 16.0 * s * s + 16.0 * U * u * v
            scale = 1.0 / length if LEAST < length < 1.0 / LEAST else np.inf
            for axis in range(3):
                n, off = (normal[axis] * scale, error * scale + 4.0 * U) if scale < np.inf else (0.0, np.inf)
                low[axis, k], high[axis, k] = min(low[axis, k], n - off), max(high[axis, k], n + off)


@jit
def side_of(vertices: Floats, a: int, b: int) -> Vector:
    """Return the vector from one vertex to another."""
    return vertices[0, b] - vertices[0, a], vertices[1, b] - vertices[1, a], vertices[2, b] - vertices[2, a]


@jit
def greatest(a: Vector) -> float:
    """Return the greatest magnitude of the coordinates of a vector."""
    return max(max(abs(a[0]), abs(a[1])), abs(a[2]))


@jit
def cross(a: Vector, b: Vector) -> tuple[Vector, Vector]:
    """Return the cross product, and the sums of the magnitudes of what it sums."""
    yz, zy, zx, xz, xy, yx = a[1] * b[2], a[2] * b[1], a[2] * b[0], a[0] * b[2], a[0] * b[1], a[1] * b[0]
    size = abs(yz) + abs(zy), abs(zx) + abs(xz), abs(xy) + abs(yx)
    return (yz - zy, zx - xz, xy - yx), size


@jit
def determinant_of(perspective: bool, rows: Floats) -> tuple[Floats, Floats]:
    """Return what makes the determinant of a triangle from its normal and a corner.

    Parameters
    ----------
    perspective : bool
    rows : (3, 4) float64
        To clip space (x, y, d), see :func:`hsr.kernels.projection.clip_rows`.

    Returns
    -------
    form : (4,) float64
        q and det.
    error : (4,) float64
        Bounds of their errors.
    """
    form, size = np.zeros(4), np.zeros(4)
    x, y, d = three_of(rows, 0), three_of(rows, 1), three_of(rows, 2)
    if not perspective:
        add(form, size, 1.0, x, y)
    else:
        add(form, size, rows[0, 3], y, d)
        add(form, size, rows[1, 3], d, x)
        add(form, size, rows[2, 3], x, y)
        across, across_size = cross(y, d)
        for k in range(3):
            form[3] += x[k] * across[k]
            size[3] += abs(x[k]) * across_size[k]

    # The rows were divided once, and depth is taken for w: each entry is off by at most 4 U of itself. A
    # product of three is off by at most 12 U more, and by three roundings; six of them are summed. All less
    # than 32 U of the sum of the magnitudes.
    return form, (32.0 * U if np.abs(rows).max() < MODEST else np.inf) * size + LEAST


@jit
def add(form: Floats, size: Floats, factor: float, a: Vector, b: Vector) -> None:
    """Add a multiple of a cross product to q."""
    product, product_size = cross(a, b)
    for k in range(3):
        form[k] += factor * product[k]
        size[k] += abs(factor) * product_size[k]


@jit
def three_of(rows: Floats, k: int) -> Vector:
    """Return the first three entries of a row."""
    return rows[k, 0], rows[k, 1], rows[k, 2]


@jit
def leave_out(
    boxes: tuple[Floats, Floats],
    normals: tuple[Floats, Floats],
    cull: Array,
    slack: Floats,
    form: tuple[Floats, Floats],
    extent: Floats,
) -> None:
    """Empty the extents of clusters of which every triangle is certainly culled.

    Parameters
    ----------
    boxes : (low, high)
        Opposite corners (3, n) of the boxes around the clusters.
    normals : (low, high)
        Likewise around their normals.
    cull : (n,) int8
        What all triangles of each cull; 0 if they differ.
    slack : (3,) float64
        By how much points may be off.
    form : (form, error)
        See :func:`determinant_of`.
    extent : (n, 5) float64
        First and end column, first and end line, and least key depth of the clusters.
    """
    (along, off), det = form, form[0][3]
    for k in range(len(cull)):
        least, most = 0.0, 0.0
        # Sum up, axis by axis, between what the determinants of the cluster's triangles lie.
        for axis in range(3):
            low, high = boxes[0][axis, k], boxes[1][axis, k]
            size = max(abs(low), abs(high)) + slack[axis]
            error = abs(det) * slack[axis] + off[3] * size + off[axis]
            error += 4.0 * U * (abs(det) * size + abs(along[axis]))
            one, other = det * low + along[axis], det * high + along[axis]
            near, far = min(one, other) - error, max(one, other) + error
            n, m = normals[0][axis, k], normals[1][axis, k]
            # Each product and each sum is rounded once.
            rounding = 8.0 * U * max(abs(n), abs(m)) * max(abs(near), abs(far))
            least += min(min(n * near, n * far), min(m * near, m * far)) - rounding
            most += max(max(n * near, n * far), max(m * near, m * far)) + rounding

        # Empty the extent if all have the sign of what is culled.
        if (cull[k] == CULL_BACK and most < 0.0) or (cull[k] == CULL_FRONT and least > 0.0):
            extent[k, 1] = extent[k, 0]

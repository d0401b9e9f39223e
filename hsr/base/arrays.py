"""Names for the array types that signatures mention, and what NumPy lacks to walk a list of lists."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Bools = NDArray[np.bool_]
Pixels = NDArray[np.uint8]
Array = NDArray[Any]


def ranges(first: Array, end: Array) -> tuple[Array, Array]:
    """Count from each of ``first`` (n,) up to before its ``end``, if that is more.

    Returns
    -------
    which, number : (m,) int64
        Which range each number is of, and the number.

    Examples
    --------
    >>> import numpy as np
    >>> from hsr.base.arrays import ranges
    >>> which, number = ranges(np.array([3, 5, 0]), np.array([5, 4, 1]))
    >>> print(which, number)
    [0 0 2] [3 4 0]
    """
    count = np.maximum(end - first, 0)
    which = np.repeat(np.arange(len(count)), count)
    return which, np.arange(len(which)) + np.repeat(first - (np.cumsum(count) - count), count)

"""Names for the array types that signatures mention."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Bools = NDArray[np.bool_]
Pixels = NDArray[np.uint8]
Array = NDArray[Any]

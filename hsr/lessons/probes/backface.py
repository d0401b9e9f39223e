"""Back-face detection, and the painting of what is left."""

from __future__ import annotations

from typing import Any

import numpy as np

from hsr.algorithms.scanline import Options
from hsr.kernels import culling
from hsr.kernels.strips import _scan_convert
from hsr.lessons.probes import Look, Names, Probe
from hsr.lessons.probes import scanline as painting
from hsr.problem.view import View


def probe(view: View, _options: Any) -> Probe:
    """Watch the signs of the normals, then scan conversion without a depth test."""

    def clear(names: Names) -> None:
        if "facing" in names:
            names["facing"].fill(np.nan)

    paint = painting.probe(view, Options())
    return paint._replace(
        shown={
            culling.facing_by_normal: ("i", "a", "b", "c", "p", "facing[i]"),
            culling.newell: ("a", "b", "c"),
            **paint.shown,
        },
        buffers={culling.facing_by_normal: Look("i", before=clear), **paint.buffers},
        until=_scan_convert,
    )

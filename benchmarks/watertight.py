"""How many rays escape from closed meshes through their vertices and edges, by the test with triangles.

    python benchmarks/watertight.py > reports/watertight.md

Each test gets the same 20,000 rays a row, from inside a tessellated sphere and cylinder. Embree is asked
through embreex with its robust flag, on the same float32 numbers as our tests in float32.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hsr.lab.watertight import AIMS, SEGMENTS, aimed, escapes
from hsr.scene.shapes import generic, tessellated

RAYS, SEED = 20_000, 0


def embree_misses(mesh: str, aim: str) -> int | None:
    """Count the rays that Embree loses; None if embreex is not installed."""
    try:
        from embreex import mesh_construction, rtcore_scene
    except ImportError:
        return None
    polygons = tessellated(generic(mesh), SEGMENTS).polygons
    assert polygons is not None, "a tessellated shape has polygons"
    origins, targets = aimed(polygons, aim, RAYS, np.random.default_rng(SEED))
    o, target = origins.astype(np.float32), targets.astype(np.float32)
    scene: Any = rtcore_scene.EmbreeScene(robust=True)
    corners = polygons.vertices[polygons.triangle_vertex].astype(np.float32)
    mesh_construction.TriangleMesh(scene, corners)
    return int((scene.run(o, target - o) < 0).sum())


def main() -> None:
    """Print the table as Markdown."""
    found = escapes(RAYS, SEED)
    ways = list(dict.fromkeys((row.test, row.arithmetic) for row in found))
    print(f"# Rays that escape\n\nOf {RAYS:,} rays a figure; written by `benchmarks/watertight.py`.\n")
    print(
        f"| mesh | aimed at | {' | '.join(f'{test}, {arithmetic}' for test, arithmetic in ways)} | embree |"
    )
    print(f"|---|---|{'---:|' * (len(ways) + 1)}")
    for mesh in dict.fromkeys(row.mesh for row in found):
        for aim in AIMS:
            misses = [f"{row.misses:,}" for row in found if (row.mesh, row.aim) == (mesh, aim)]
            lost = embree_misses(mesh, aim)
            print(f"| {mesh} | {aim} | {' | '.join(misses)} | {'absent' if lost is None else f'{lost:,}'} |")


if __name__ == "__main__":
    main()

"""Time the ray caster beside Embree's own API: python benchmarks/raycast_speed.py SCENE [--size N]

A round runs every method once, so that all of them see the same state of the machine; the medians
over the rounds are compared. Each time is that of shapes never seen before: rounding, building and
casting. The faces are compared before anything is timed.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from statistics import median

import hsr

METHODS = ("raycast", "raycast-single", "embree")


def main() -> None:
    options = arguments()
    view = hsr.view(hsr.load(options.scene), (options.size, options.size))
    expected = hsr.render(view, "raycast")
    for method in METHODS:
        answer = hsr.render(view, method)
        print(f"{method:15} shows another face in {(answer.face != expected.face).sum()} samples")

    times: dict[str, list[dict[str, float]]] = {method: [] for method in METHODS}
    for _ in range(options.rounds):
        for method in METHODS:
            times[method].append(hsr.render(with_new_shapes(view), method).seconds)
    whole = {method: median(sum(seconds.values()) for seconds in rounds) for method, rounds in times.items()}
    for method, rounds in times.items():
        stages = ", ".join(f"{stage} {1e3 * median(s[stage] for s in rounds):.1f}" for stage in rounds[0])
        ratio = whole["embree"] / whole[method]
        print(f"{method:15} {1e3 * whole[method]:8.1f} ms ({stages}); embree takes {ratio:.1f} times that")


def with_new_shapes(view: hsr.View) -> hsr.View:
    """Return the view with copies of its shapes, for which nothing is built yet."""
    copies = {placement.shape: replace(placement.shape) for placement in view.placements}
    placements = tuple(replace(placement, shape=copies[placement.shape]) for placement in view.placements)
    return replace(view, placements=placements)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Time the ray caster beside Embree's own API.")
    parser.add_argument("scene", type=Path, help="scene file")
    parser.add_argument("--size", type=int, default=1024, help="image width and height (1024)")
    parser.add_argument("--rounds", type=int, default=9, help="how often each method runs (9)")
    return parser.parse_args()


if __name__ == "__main__":
    main()

"""The page of a test run: every check, failed first, with pictures and what to decide."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from hsr.difference.classes import compare
from hsr.output import write_whole
from hsr.report.album import Album, gather_pair, gather_pictures
from hsr.report.page import part, style, templates
from hsr.shading import face_picture
from hsr.visibility import load_map


def write_page(
    checks: Iterable[tuple[str, Mapping[str, Any]]], run: str, unused: Sequence[str], path: Path
) -> None:
    """Write the page of a test run as one HTML file that needs no network.

    Parameters
    ----------
    checks : iterable of (str, mapping)
        Name of the test, and the check as the results tell it; files are seen from the folder of ``path``.
    run : str
        Tells the run from others, for the decisions that are made on the page.
    unused : sequence of str
        Baselines that no test used.
    path : Path

    Raises
    ------
    HsrError
        If a map cannot be read, or the page cannot be written.
    """
    album = Album()
    scenes: list[dict[str, Any]] = []
    shown = []
    for test, check in checks:
        place, thumbs = None, []
        if check["shown"]:
            place = len(scenes)
            scenes.append(_pictures(check, path.parent, album))
            thumbs = _thumbs(scenes[-1])
        shown.append({**check, "test": test, "scene": place, "thumbs": thumbs})
    text = (
        templates()
        .get_template("checks.html")
        .render(
            title="Visibility checks",
            checks=shown,
            failed=[check for check in shown if not check["passed"]],
            passed=[check for check in shown if check["passed"]],
            run=run,
            unused=unused,
            lab={"pictures": album.uris, "scenes": scenes},
            style=style("checks.css"),
            script=part("checks.js"),
            decisions=part("decisions.js"),
        )
    )
    write_whole(path, text, "the page")


def _pictures(check: Mapping[str, Any], folder: Path, album: Album) -> dict[str, Any]:
    """Gather what a failed check shows: two maps, two pictures, or one map without a baseline."""
    files = {what: folder / check[what] for what in ("expected", "shown") if check[what]}
    if check["weaker"]:
        pictures = {what: np.asarray(Image.open(file)) for what, file in files.items()}
        return gather_pictures(check["key"], pictures, album)
    maps = {what: load_map(file) for what, file in files.items()}
    if len(maps) == 1:
        return gather_pictures(check["key"], {"shown": face_picture(maps["shown"])}, album)
    return gather_pair(check["key"], check["name"], compare(maps["shown"], maps["expected"]), album)


def _thumbs(scene: Mapping[str, Any]) -> list[tuple[int, str, str]]:
    """Return which pictures stand beside a verdict: place, kind and name."""
    return [
        (place, kind, method["name"])
        for place, method in enumerate(scene["methods"])
        for kind in method["layers"]
        if kind != "depth"
    ]

"""The page of a test run: every check, failed first, with what to inspect and what to decide."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from pydantic import TypeAdapter

from hsr.base.arrays import Pixels
from hsr.base.errors import HsrError, told_briefly
from hsr.base.files import write_whole
from hsr.pages.frame import page, style
from hsr.pages.inspector import inspected, inspection
from hsr.pages.shading import shade
from hsr.pages.stories import Shown
from hsr.pictures.maps import face_picture
from hsr.pictures.png import data_uri

HISTORIES = 40
"""How many samples of a failed check have their history in the page."""


@dataclass
class Kept:
    """What the page keeps of the maps of a failed check.

    Attributes
    ----------
    scene : dict
        For the inspector.
    thumbs : list of (str, str, str)
        Small pictures that lead to it: the name of the map, what it shows, and its data URI. The first is
        what the inspector calls the picture.
    beside : list of (str, str)
        Pictures that lead nowhere: what each is, and its data URI.
    """

    scene: dict[str, Any]
    thumbs: list[tuple[str, str, str]]
    beside: list[tuple[str, str]]


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

    Raises
    ------
    HsrError
        If the page cannot be written.
    """
    shown: list[dict[str, Any]] = []
    data: list[dict[str, Any]] = []
    for test, check in checks:
        found = {**check, "test": test, "thumbs": [], "pictures": _pictures(check, path.parent)}
        if check["inspection"]:
            held = _kept(path.parent / check["inspection"])
            found |= {"thumbs": held.thumbs, "pictures": held.beside, "scene": len(data)}
            data.append(held.scene)
        shown.append(found)
    sheet, scripts = style("inspector.css", "checks.css"), ["viewer.js", "decisions.js"]
    causes = sorted({cause for check in shown for cause in check["counts"]})
    told = {"checks": shown, "causes": causes, "run": run, "unused": unused, **inspected(data)}
    text = page("checks", path, "Visibility checks", sheet, scripts if data else scripts[1:], **told)
    write_whole(path, text, "the page")


def kept(shown: Shown, linked: Sequence[tuple[int, int]] = ()) -> dict[str, Any]:
    """Gather what the page keeps of the maps of a failed check, for :func:`write_page`.

    Parameters
    ----------
    shown : Shown
        By the key of the check.
    linked : sequence of (row, column)
        Samples that the page or a message leads to.

    Returns
    -------
    dict
        JSON values: the fields of :class:`Kept`.
    """
    base = shown.reference or next(iter(shown.maps))
    map = shown.maps[base]
    picture = face_picture(map.face) if shown.view is None else shade(map, shown.view)
    thumbs = [(base, "faces" if shown.view is None else "picture", data_uri(picture))]
    thumbs += [(name, "where it differs", data_uri(it.picture())) for name, it in shown.differences.items()]
    told = Kept(inspection(shown, HISTORIES, linked), thumbs, [])
    if (other := shown.beside) is not None:
        told.beside = [(f"expected, {other.width}x{other.height}", data_uri(face_picture(other.face)))]
    return vars(told)


def _kept(file: Path) -> Kept:
    try:
        return TypeAdapter(Kept).validate_json(file.read_bytes())
    except (OSError, ValueError) as error:
        raise HsrError(f"{file}: cannot be shown ({told_briefly(error)}); run the tests again") from None


def _pictures(check: Mapping[str, Any], folder: Path) -> list[tuple[str, str]]:
    """Return the pictures that a weaker check compared: what each is, and its data URI."""
    if not check["weaker"] or not check["shown"] or check["passed"]:
        return []
    return [(what, data_uri(_picture(folder / check[what]))) for what in ("expected", "shown")]


def _picture(file: Path) -> Pixels:
    try:
        return np.asarray(Image.open(file))
    except Exception as error:  # on a damaged file Pillow raises almost anything
        raise HsrError(f"{file}: cannot be shown ({error}); run the tests again") from None

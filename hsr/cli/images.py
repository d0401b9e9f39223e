"""Maps of other programs: how their files hold ids, declared once for every verb that takes some."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from typer import BadParameter, Option

import hsr
from hsr.base.errors import HsrError
from hsr.cli.common import Text, parse_size, with_options
from hsr.problem.map import READ

if TYPE_CHECKING:
    from hsr.problem.map import VisibilityMap

option = partial(Option, rich_help_panel="Maps of other programs")


def ident(text: str) -> int:
    """Read an id, a number or a colour.

    Raises
    ------
    typer.BadParameter
        If it is neither.
    """
    from hsr.testing.images import number_of

    try:
        return number_of(text)
    except ValueError:
        raise BadParameter(f"{text!r}: write a number or #rrggbb") from None


OPTIONS: Mapping[str, Any] = {
    "ids": Annotated[
        Text, option(metavar="rgb24|r32|...", help="Channels of an id, the highest first; bits.")
    ],
    "background": Annotated[Any, option(parser=ident, metavar="ID", help="Of nothing; 0, or -1 if signed.")],
    "faces": Annotated[Path | None, option(help="CSV or JSON: which face each id is, by number or name.")],
    "flip": Annotated[bool | None, option("--flip", help="The first row is the bottom row.")],
    "model": Annotated[Text, option(help="What made it: exact, opengl, float32, float64 or a method.")],
    "subpixel_bits": Annotated[int | None, option(help="Of the model: bits of a pixel that corners keep.")],
    "depth_format": Annotated[Text, option(help="Of the model: what its depth buffer holds.")],
    "fill_rule": Annotated[Text, option(help="Of the model: who owns edges, top-left or bottom-left.")],
}

MODEL = {"model", "subpixel_bits", "depth_format", "fill_rule"}
"""Those that say how a map was made, of our own maps too."""


class Images(NamedTuple):
    """How to read the maps of a verb.

    Attributes
    ----------
    keys : dict
        How files of other programs hold ids; see ``hsr.testing.read_map``.
    made_by : dict
        By which model to look for causes.
    """

    keys: dict[str, Any]
    made_by: dict[str, Any]

    def size(self, told: Text, files: Sequence[str | Path]) -> tuple[int, int]:
        """Return the size that is told, or that of the first map, or else 512x512."""
        from hsr.testing.images import size_of

        if told or not files:
            return parse_size(told or "512x512")
        return size_of(named(files[0])[1], self.keys.get("ids"))

    def read(self, given: str | Path, size: tuple[int, int], view: hsr.View | None = None) -> VisibilityMap:
        """Read a map, [NAME=]FILE, of a view or of no scene that is known; it notes how."""
        from hsr.testing.limits import Limits

        name, file = named(given)
        if name in hsr.methods():
            raise HsrError(
                f"--map {name}=: {name} is a method; call the map otherwise, and say --model {name}"
            )
        shown = hsr.testing.read_map(file, view, size=size, method=name, **self.keys)
        if made_by := Limits(**self.made_by).made_by:  # whatever the map says itself
            shown = hsr.testing.modelled(shown, **made_by)
        told = [
            [f"--{key.replace('_', '-')}", str(value)] for key, value in (self.keys | self.made_by).items()
        ]
        words = [word for words in told for word in words if word != "True"]
        return replace(shown, notes=shown.notes | {READ: shlex.join(["--map", str(given), *words])})


def named(given: str | Path) -> tuple[str, Path]:
    """Split [NAME=]FILE."""
    name, found, file = str(given).partition("=")
    return (name, Path(file)) if found and not Path(given).exists() else ("", Path(given))


def _images(keys: dict[str, Any]) -> Images:
    return Images(
        {key: keys[key] for key in keys.keys() - MODEL}, {key: keys[key] for key in keys.keys() & MODEL}
    )


with_images = with_options("images", OPTIONS, _images)
"""Gives a verb the options of how maps are read in place of its argument ``images``."""

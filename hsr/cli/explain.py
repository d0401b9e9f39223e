"""The command ``hsr explain``: why each method shows what it shows at a sample."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import hsr
from hsr.base.errors import UnavailableError
from hsr.cli import common as cli
from hsr.cli.cameras import Cameras, with_cameras
from hsr.cli.images import Images, with_images


@with_cameras
@with_images
def explain(
    scene: cli.SceneFile,
    sample: cli.Sample,
    method: cli.Methods = None,
    map: cli.NamedMaps = None,
    size: cli.MapSize = None,
    as_json: cli.Json = False,
    *,
    cameras: Cameras,
    images: Images,
) -> None:
    """Tell what lies on one line of sight, and why each method or map shows what it shows.

    Without -a and --map zbuffer, raycast and, where it runs, opengl are asked.

    For example:

        hsr explain solids 319,106
        hsr explain solids 319,106 -a zbuffer -a opengl --eye 2,2,4
        hsr explain solids 319,106 --map mine=ids.png --ids bgr24
    """
    sides = images.size(size, map or ())
    view = hsr.view(cameras.one(hsr.load(scene)), sides)
    column, row = cli.parse_sample(sample, view)
    given = [_modelled(view, images.read(file, sides, view)) for file in map or ()]
    asked = given if given and not method else [*given, *_maps(view, method)]
    told = hsr.history(view, asked, x=column, y=row)
    cli.tell(as_json, "explain", {"scene": str(scene), **told.to_json()}, [str(told)])


def _modelled(view: hsr.View, shown: hsr.VisibilityMap) -> hsr.VisibilityMap:
    """Find by which model the causes of a map are known, unless it tells."""
    from hsr.difference.cause import explained
    from hsr.models.foreign import has_model

    return shown if has_model(shown) else explained(view, shown, hsr.render(view, "exact"))[0]


def _maps(view: hsr.View, asked: Sequence[str] | None) -> list[hsr.VisibilityMap]:
    """Render by the methods asked for, or by the first of each family that runs here."""
    maps = [hsr.render(view, name) for name in asked or ("zbuffer", "raycast")]
    if not asked:
        with suppress(UnavailableError):
            maps.append(hsr.render(view, "opengl"))
    return maps

"""The commands ``hsr diff`` and ``hsr diagnose``: a map judged by another, or by the scene it shows."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

import hsr
from hsr.cli import common as cli
from hsr.cli.cameras import Cameras, with_cameras
from hsr.cli.images import Images, with_images

if TYPE_CHECKING:
    from hsr.testing.judging import Judgement


@with_cameras
@with_images
def diff(
    map: cli.MapFile,
    against: cli.Against,
    size: cli.MapSize = None,
    as_json: cli.Json = False,
    verbose: cli.Verbose = False,
    *,
    cameras: Cameras,
    images: Images,
) -> None:
    """Compare a visibility map with another, or with the truth; exit 1 if any sample shows another face.

    Against a scene wrong samples are put down to causes, by the model that is named, else by the one of
    several that explains most. Where one mistake accounts for what differs, it is named: see 'hsr diagnose'.

    For example:

        hsr diff a.npz b.npz
        hsr diff ids.png teapot --model opengl
        hsr diff ids.npy teapot --background 0xffffffff --flip
        hsr diff ids.raw cube --ids bgr24 --size 640x480 --faces faces.csv
    """
    found = _judged(map, against, size, cameras, images)
    lines = [found.difference.summary(clusters=None if verbose else 5)]
    if found.causes is not None:
        lines += [f"  {count:,} by {cause}" for cause, count in found.counts.items()]
    lines += [f"  {told}" for told in (*found.modelled, *found.diagnoses)]
    _tell("diff", found, [map, against], found.difference.to_json(), as_json, lines)


@with_cameras
@with_images
def diagnose(
    map: cli.MapFile,
    against: cli.Against,
    size: cli.MapSize = None,
    as_json: cli.Json = False,
    *,
    cameras: Cameras,
    images: Images,
) -> None:
    """Name the one mistake that makes a picture wrong; exit 1 if any sample shows another face.

    Shifts, flips, and ids counted otherwise; against a scene also inverted culling, other rules for ties, and
    more. The proof is how many samples are right once the mistake is undone.

    For example:

        hsr diagnose ids.png teapot
    """
    found = _judged(map, against, size, cameras, images)
    none = "nothing differs" if found.difference.same else "no mistake that is known explains it"
    if found.causes is not None and not found.causes.unexplained:
        none = f"rounded as by {', '.join(found.counts)}, no mistake"
    _tell("diagnose", found, [map, against], {}, as_json, [*found.diagnoses] or [none])


def _judged(map: Path, against: Path, size: cli.Text, cameras: Cameras, images: Images) -> Judgement:
    from hsr.testing.judging import Subject, judge
    from hsr.testing.limits import Limits

    sides, view = images.size(size, [map]), None
    if against.suffix.lower() in cli.MAPS:
        expected = images.read(against, sides)
    else:
        view = hsr.view(cameras.one(hsr.load(against)), sides)
        expected = hsr.render(view, "exact")
    shown = images.read(map, sides, view)
    return judge(map.name, shown, expected, Limits(), None if view is None else Subject(view))


def _tell(kind: str, found: Judgement, files: list[Path], more: Any, as_json: bool, lines: list[Any]) -> None:
    told = {"files": [str(file) for file in files], **more, "causes": None, "model": None}
    if found.causes is not None:
        told |= {"causes": found.causes.counts, "model": found.difference.a.notes.get("model")}
    told["diagnoses"] = [one._asdict() for one in found.diagnoses]
    cli.tell(as_json, kind, told, [str(line) for line in lines])
    if not found.difference.same:
        raise typer.Exit(cli.DIFFERS)

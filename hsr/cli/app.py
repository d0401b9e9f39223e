"""The command ``hsr``.

Exit codes: 0 done or same, 1 differs, 2 usage or input, 3 what was asked for by name (OpenGL,
Embree) is missing. Results go to standard output, everything else to standard error.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hsr import __version__
from hsr.base.errors import HsrError, UnavailableError
from hsr.base.files import make_folder, write_whole
from hsr.cli.bench import bench_app
from hsr.cli.console import err, new_table, out, print_json, print_renders, print_studies, progress, say
from hsr.cli.options import ALL, DIFFERS, MISSING, USAGE, Json, Methods, Quiet, check_folder, parse_size
from hsr.cli.stability import stability_app

if TYPE_CHECKING:
    from hsr.difference.study import Study
    from hsr.problem.map import VisibilityMap
    from hsr.problem.view import View

app = typer.Typer(
    help="Which surface does the eye see at each pixel? Every classic method, compared sample by sample.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
scene_app = typer.Typer(help="Check and describe scene files.", no_args_is_help=True)
app.add_typer(scene_app, name="scene")
app.add_typer(bench_app, name="bench")
app.add_typer(stability_app, name="stability")

Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="Also print work counts and clusters.")]
Size = Annotated[str, typer.Option("--size", help="Image size in pixels, WxH or N.")]
Sample = Annotated[str, typer.Argument(metavar="X,Y", help="Column and row, counted from 0 at the top left.")]
CameraName = Annotated[str | None, typer.Option("--camera", help="Camera; the scene's first by default.")]


def main() -> None:
    """Run the command; turn every expected error into one line and an exit code."""
    try:
        app()
    except UnavailableError as error:
        _fail(error, MISSING)
    except HsrError as error:
        _fail(error, USAGE)


def _fail(error: HsrError, code: int) -> None:
    for line in str(error).splitlines():
        err.print(f"hsr: {line}", markup=False, soft_wrap=True)
    sys.exit(code)


def _version(wanted: bool) -> None:
    if wanted:
        out.print(f"hsr {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


# ---------------------------------------------------------------- render


@app.command()
def render(
    scene: Annotated[Path, typer.Argument(help="Scene (TOML, JSON) or mesh file.")],
    method: Methods = None,
    size: Size = "512x512",
    camera: CameraName = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write the map, .npz.")] = None,
    png: Annotated[Path | None, typer.Option("--png", help="Write the shaded picture.")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Render one scene and say what is seen.

    With several methods the files are named after them: map.npz becomes map.zbuffer.npz.
    """
    import hsr
    from hsr.algorithms.registry import method_named

    check_folder(output)
    check_folder(png)
    view = hsr.view(hsr.load(scene), parse_size(size), camera)
    names = method or ["zbuffer"]
    rows = []
    with progress(quiet, len(names)) as step:
        for name in names:
            step(name)
            method_named(name).warm_up(view)
            answer = hsr.render(view, name)
            files = _write_render(view, answer, output, png, several=len(names) > 1)
            rows.append(_summary(answer) | {"files": files})
    if as_json:
        print_json({"hsr": 1, "scene": str(scene), "maps": rows})
    else:
        print_renders(rows, verbose)


def _write_render(
    view: View, answer: VisibilityMap, output: Path | None, png: Path | None, several: bool
) -> list[str]:
    """Write what was asked for; with several methods each file carries its method's name."""
    written = []
    if output is not None:
        path = _named(output, answer.method, several)
        answer.save(path)
        written.append(str(path))
    if png is not None:
        from hsr.pages.shading import save_picture, shade

        path = _named(png, answer.method, several)
        save_picture(shade(answer, view), path)
        written.append(str(path))
    return written


def _named(path: Path, method: str, several: bool) -> Path:
    return path.with_name(f"{path.stem}.{method}{path.suffix}") if several else path


def _summary(answer: VisibilityMap) -> dict[str, Any]:
    import numpy as np

    covered = answer.face >= 0
    return {
        "method": answer.method,
        "size": [answer.width, answer.height],
        "covered": int(covered.sum()),
        "faces_seen": len(np.unique(answer.face[covered])),
        "nearest": float(answer.depth.min()) if covered.any() else None,
        "seconds": answer.seconds,
        "work": answer.work,
        "notes": answer.notes,
    }


# ---------------------------------------------------------------- compare


@app.command()
def compare(
    scenes: Annotated[list[Path], typer.Argument(help="Scenes or mesh files.")],
    method: Methods = None,
    ref: Annotated[str, typer.Option("--ref", help="Reference method.")] = "exact",
    size: Size = "512x512",
    camera: CameraName = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write the report, .html.")] = None,
    fail_on: Annotated[
        str | None, typer.Option("--fail-on", help="Classes of difference, comma separated: then exit 1.")
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Render scenes by many methods and compare every visibility map with the reference.

    Without -a the method each family is called after takes part, and every peer; '-a all' adds all
    variants. Those that test each face at each sample sit out scenes that would keep them busy for minutes,
    unless they are named.
    """
    import hsr
    from hsr.algorithms import registry
    from hsr.difference.classes import DIFFERENT
    from hsr.difference.study import study

    check_folder(output)
    forbidden = _classes(fail_on, DIFFERENT)
    loaded = [(path, hsr.load(path)) for path in scenes]
    asked = [] if method in (None, [ALL]) else list(method or ())
    names = list(hsr.methods()) if method == [ALL] else asked or registry.default_methods()
    studies = []
    with progress(quiet, len(loaded) * (len({*names, ref}) + (output is not None))) as step:
        for path, scene in loaded:
            found = study(
                scene,
                names,
                ref,
                parse_size(size),
                camera,
                name=path.stem,
                patient=bool(asked),
                progress=step,
            )
            studies.append(found)
        _require(studies, {*asked, ref})
        if output is not None:
            from hsr.pages.page import write_report

            write_report(studies, output, progress=step)
    if as_json:
        print_json({"hsr": 1, "studies": [found.to_json() for found in studies]})
    else:
        print_studies(studies, verbose)
        if output is not None:
            say(f"report: {output}")
    if forbidden:
        _require_judged(studies, {*asked, ref})
    if any(_meets(found, forbidden) for found in studies):
        raise typer.Exit(DIFFERS)


def _classes(text: str | None, known: Sequence[str]) -> tuple[str, ...]:
    names = tuple(name.strip() for name in (text or "").split(",") if name.strip())
    for name in names:
        if name not in known:
            raise typer.BadParameter(f"--fail-on: no class {name!r}; there are {', '.join(known)}")
    return names


def _meets(found: Study, forbidden: Sequence[str]) -> bool:
    return any(difference.counts[name] > 0 for difference in found.differences.values() for name in forbidden)


def _require(studies: Sequence[Study], asked: set[str]) -> None:
    """Raise if a method asked for by name is missing here: that is no mere skipped column."""
    for found in studies:
        for name in asked & found.missing:
            raise UnavailableError(found.skipped[name])


def _require_judged(studies: Sequence[Study], asked: set[str]) -> None:
    """Raise if a method asked for by name was skipped: what was not compared must not pass."""
    for found in studies:
        for name in sorted(asked & found.skipped.keys()):
            raise HsrError(f"--fail-on: {found.name}: {name} did not run: {found.skipped[name]}")


# ---------------------------------------------------------------- diff


@app.command()
def diff(
    a: Annotated[Path, typer.Argument(help="Map, .npz.")],
    b: Annotated[Path, typer.Argument(help="Map to judge it against, .npz.")],
    as_json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Compare two visibility maps; exit 1 if any sample shows another face."""
    import hsr

    difference = hsr.compare(hsr.load_map(a), hsr.load_map(b))
    if as_json:
        print_json({"hsr": 1, "files": [str(a), str(b)], **difference.to_json()})
    else:
        say(difference.summary(clusters=None if verbose else 5))
    if not difference.same:
        raise typer.Exit(DIFFERS)


# ---------------------------------------------------------------- accept


@app.command()
def accept(
    decisions: Annotated[Path, typer.Argument(help="File that the page of a test run wrote, .json.")],
    results: Annotated[Path, typer.Option("--results", help="Folder of the run's results.")] = Path(
        ".hsr-results"
    ),
) -> None:
    """Replace baselines of tests as decided in the page of a test run; run it in the project's root."""
    from hsr.testing.accepting import apply

    for line in apply(decisions, results, Path()):
        say(line)


# ---------------------------------------------------------------- explain, shrink

NEGATIVE = {"ignore_unknown_options": True}
"""So that the sample -1,3 is outside the image, and not an unknown option."""


@app.command(context_settings=NEGATIVE)
def explain(
    scene: Annotated[Path, typer.Argument(help="Scene or mesh file.")],
    sample: Sample,
    method: Methods = None,
    map: Annotated[list[Path] | None, typer.Option("--map", help="Map to explain, .npz, repeatable.")] = None,
    size: Size = "512x512",
    camera: CameraName = None,
    as_json: Json = False,
) -> None:
    """Tell what lies on one line of sight, and why each method or map shows what it shows.

    Without -a and --map zbuffer, raycast and, where it runs, opengl are asked.
    """
    import hsr
    from hsr.difference.history import history

    view = hsr.view(hsr.load(scene), parse_size(size), camera)
    column, row = _sample(sample, view)
    given = [hsr.load_map(file) for file in map or ()]
    asked = given if given and not method else [*given, *_maps(view, method)]
    told = history(view, row, column, asked)
    if as_json:
        print_json({"hsr": 1, "scene": str(scene), **told.to_json()})
    else:
        say(str(told))


def _maps(view: View, asked: Sequence[str] | None) -> list[VisibilityMap]:
    """Render by the methods asked for, or by the first of each family that runs here."""
    import hsr

    if asked:
        return [hsr.render(view, name) for name in asked]
    maps = [hsr.render(view, name) for name in ("zbuffer", "raycast")]
    with suppress(UnavailableError):
        maps.append(hsr.render(view, "opengl"))
    return maps


@app.command(context_settings=NEGATIVE)
def shrink(
    scene: Annotated[Path, typer.Argument(help="Scene or mesh file.")],
    sample: Sample,
    a: Annotated[str, typer.Option("-a", help="One method.")],
    b: Annotated[str, typer.Option("-b", help="The other.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Scene to write, .toml; standard output by default.")
    ] = None,
    size: Size = "512x512",
    camera: CameraName = None,
    as_json: Json = False,
) -> None:
    """Find the smallest scene in which two methods still disagree at a sample."""
    import hsr
    from hsr.difference.shrink import shrink as smallest
    from hsr.scene.writing import to_toml, write_scene

    loaded = hsr.load(scene)
    column, row = _sample(sample, hsr.view(loaded, parse_size(size), camera))
    found = smallest(loaded, row, column, a, b, parse_size(size), camera)
    if output is not None:
        write_scene(found.scene, output)
    if as_json:
        facts = {"faces": len(found.faces), "shown": dict(zip((a, b), found.shown, strict=True))}
        print_json({"hsr": 1, "sample": [column, row], **facts, "scene": to_toml(found.scene)})
        return
    if output is None:
        print(to_toml(found.scene), end="")
        return
    kept = "1 face" if len(found.faces) == 1 else f"{len(found.faces)} faces"
    shown = f"{a} shows {found.shown[0]}, {b} {found.shown[1]}"
    say(f"wrote {output}: {kept} left; {shown}")


def _sample(text: str, view: View) -> tuple[int, int]:
    """Read X,Y: column and row of a sample of the image."""
    from hsr.difference.nearby import check_sample

    x, _, y = text.partition(",")
    try:
        column, row = int(x), int(y)
    except ValueError:
        raise HsrError(f"sample {text!r}: write COLUMN,ROW, such as 311,204") from None
    check_sample(view, row, column)
    return column, row


# ---------------------------------------------------------------- lesson, gallery


@app.command()
def lesson(
    topic: Annotated[str | None, typer.Argument(help="What it is about; an unknown one lists all.")] = None,
    scene: Annotated[Path | None, typer.Argument(help="Scene in place of the lesson's own.")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Page to write, .html; with --all a folder.")
    ] = None,
    course: Annotated[bool, typer.Option("--all", help="All lessons, and a page that lists them.")] = False,
) -> None:
    """Write a lesson: the real algorithm on a small picture, step by step, as one HTML page."""
    import hsr
    from hsr.lessons.topics import topic_named, topics
    from hsr.pages.lesson import write_course, write_lesson

    if course == (topic is not None):
        raise HsrError(f"name a topic or say --all; the topics are {', '.join(topics())}")
    if output is None:
        raise HsrError("say where to write by -o: a page.html for one topic, a folder for --all")
    if topic is None:
        write_course(topics(), make_folder(output))
    else:
        chosen = topic_named(topic)
        check_folder(output)
        write_lesson(chosen, output, None if scene is None else hsr.load(scene))
    say(f"wrote {output}")


@app.command()
def gallery(
    scenes: Annotated[list[Path], typer.Argument(help="Scene files.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write.")],
    size: Size = "256x256",
    turn: Annotated[
        list[str] | None, typer.Option("--turn", help="Scene, by its name, to show turning; repeatable.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write a page of scenes: what each looks like, what it shows, which methods are right on it."""
    import hsr
    from hsr.pages.gallery import write_gallery

    loaded = {path.stem: hsr.load(path) for path in scenes}
    for name in turn or ():
        if name not in loaded:
            raise HsrError(f"--turn {name}: no such scene is given; there are {', '.join(loaded)}")
    with progress(quiet, len(loaded)) as step:
        write_gallery(loaded, make_folder(output), parse_size(size), turn or (), step)
    say(f"wrote {output}")


# ---------------------------------------------------------------- algos, doctor


@app.command()
def algos(as_json: Json = False) -> None:
    """List the methods."""
    from hsr.algorithms.registry import methods

    known = methods().values()
    if as_json:
        rows = [{"name": m.name, "about": m.about, "curved": m.curved, "needs": m.needs} for m in known]
        print_json({"hsr": 1, "methods": rows})
        return
    table = new_table("method", "curved shapes", "needs", "what it does", right=())
    for known_method in known:
        curved = "exact" if known_method.curved else "tessellated"
        table.add_row(known_method.name, curved, known_method.needs or "-", known_method.about)
    out.print(table)


@app.command()
def doctor(as_json: Json = False) -> None:
    """Try every OpenGL backend and optional library, and say what to install."""
    from hsr.cli.doctor import diagnose, lines

    found = diagnose()
    if as_json:
        print_json(found)
        return
    for line in lines(found):
        say(line)


# ---------------------------------------------------------------- scene


@scene_app.command()
def check(
    files: Annotated[list[Path], typer.Argument(help="Scene or mesh files.")],
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Check scene files; all errors of all files at once, exit 2 if there are any."""
    import hsr
    from hsr.base.errors import SceneError

    problems: dict[str, list[str]] = {}
    for file in files:
        try:
            hsr.load(file)
            problems[str(file)] = []
        except SceneError as error:
            problems[str(file)] = list(error.problems)
    if as_json:
        print_json({"hsr": 1, "problems": problems})
    elif not quiet:
        for name, found in problems.items():
            say("\n".join(found) if found else f"{name}: ok")
    if any(problems.values()):
        raise typer.Exit(USAGE)


@scene_app.command()
def info(
    file: Annotated[Path, typer.Argument(help="Scene or mesh file.")],
    size: Size = "512x512",
    as_json: Json = False,
) -> None:
    """Say what is in a scene: objects, faces, bounds, cameras, where culling would be lossless."""
    import hsr
    from hsr.scene.info import describe, lines

    found = describe(hsr.load(file), parse_size(size))
    if as_json:
        print_json(found)
        return
    for line in lines(found):
        say(line)


@scene_app.command()
def schema(
    file: Annotated[Path | None, typer.Argument(help="File to write; standard output by default.")] = None,
) -> None:
    """Print the JSON Schema of scene files, for editors."""
    from hsr.scene.info import schema as scene_schema

    text = json.dumps(scene_schema(), indent=2)
    if file is None:
        print(text)
        return
    write_whole(file, text + "\n", "the schema")


if __name__ == "__main__":
    main()

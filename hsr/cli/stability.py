"""The command ``hsr stability``: hard cases, theory beside measurement."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Exit, Option, Typer

from hsr.base.errors import HsrError
from hsr.base.files import make_folder
from hsr.cli import common as cli
from hsr.cli.scene import tell_export

stability_app = Typer(
    cls=cli.RunByDefault,
    help="Run hard cases: where theory says methods break, and where they do. 'run' need not be named.",
)


@stability_app.command()
def run(
    family: Annotated[cli.Texts, Argument(help="Families; all by default.")] = None,
    method: Annotated[
        cli.Texts,
        Option("--method", "-a", help="Method or variant, repeatable; those of each family by default."),
    ] = None,
    output: Annotated[Path | None, cli.output("Folder for a page, charts and figures.")] = None,
    quick: Annotated[bool, Option("--quick", help="Small pictures, short sweeps: a minute.")] = False,
    only_list: Annotated[bool, Option("--list", help="Say which families there are, and run none.")] = False,
    as_json: cli.Json = False,
    quiet: cli.Quiet = False,
) -> None:
    """Judge methods on families of hard cases; exit 1 if any row contradicts its theory.

    For example:

        hsr stability --list
        hsr stability cyclic-overlap -o hard
    """
    from hsr.lab.stability.cases import families, family_named
    from hsr.lab.stability.judge import contradictions, judge
    from hsr.lab.stability.summary import closing, table

    chosen = [family_named(name) for name in dict.fromkeys(family or families())]
    if only_list:
        keys = ("name", "group", "parameter")
        found = [{key: getattr(one, key) for key in keys} for one in chosen]
        cli.print_list(as_json, "families", found, least=["group"])
        raise Exit
    asked = {this.name: [name for name in method or () if this.knows(name)] for this in chosen}
    for name in method or ():
        if not any(name in names for names in asked.values()):
            raise HsrError(f"no method or variant is named {name!r}; 'hsr algos' lists the methods")
    if output is not None:
        make_folder(output)
    judged = [this for this in chosen if asked[this.name] or not method]
    with cli.progress(quiet, sum(len(this.values(quick)) for this in judged)) as step:
        results = [judge(this, quick, asked[this.name], step) for this in judged]
    if output is not None:
        from hsr.pages.stability import write_folder

        write_folder(results, output)
    if as_json:
        cli.print_json("stability", {"families": [result.to_json() for result in results]})
    else:
        least = ("mostly by", "unexplained of traced", "predicted", "measured")
        cli.print_table(*table(results), least=least)
        cli.say(*closing(results))
        if output is not None:
            cli.say(f"report: {output / 'index.html'}")
    if any(contradictions(results)):
        raise Exit(cli.DIFFERS)


Name = Annotated[str, Argument(help="Family.")]
At = Annotated[float | None, Option(help="Value of its parameter; the hardest of its sweep.")]
Side = Annotated[int, Option(min=8, max=1024, help="Side of the picture, in samples.")]


@stability_app.command()
def export(family: Name, output: cli.ExportFolder, at: At = None, side: Side = 64) -> None:
    """Write a hard case for other programs, as 'hsr scene export' writes scenes.

    Its coordinates are rounded to float32, which may make another case of it: the truth is that of what is
    written.

    For example:

        hsr stability export needle --at 0.125 -o needle
    """
    from hsr.lab.stability.cases import family_named

    chosen = family_named(family)
    at = chosen.sweep[-1] if at is None else at
    tell_export(chosen.view(at, side), output, f"{family}, {chosen.parameter} {at:g}")


@stability_app.command()
def scene(family: Name, at: At = None, output: cli.SceneOutput = None, side: Side = 64) -> None:
    """Write the scene of a family at a value of its parameter, for every other command.

    For example:

        hsr stability scene needle --at 0.125 -o needle.toml
    """
    from hsr.lab.stability.cases import family_named
    from hsr.scene.writing import to_toml, write_scene

    chosen = family_named(family)
    at = chosen.sweep[-1] if at is None else at
    found = chosen.scene_at(at, side)
    if output is None:
        print(to_toml(found), end="")
        return
    write_scene(found, output)
    width, height = chosen.size(at, side)
    cli.say(f"wrote {output}; render it with --size {width}x{height}")

"""The command ``hsr lesson``: an algorithm played step by step, as a page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

import hsr
from hsr.base.errors import HsrError
from hsr.base.files import make_folder
from hsr.cli import common as cli
from hsr.cli.cameras import Cameras, with_cameras


@with_cameras
def lesson(
    topic: Annotated[str | None, Argument(help="What it is about; an unknown one lists all.")] = None,
    scene: Annotated[Path | None, Argument(help="Scene in place of the lesson's own.")] = None,
    output: Annotated[Path | None, Option("--output", "-o", help="Page, .html; with --all a folder.")] = None,
    course: Annotated[bool, Option("--all", help="All lessons, and a page that lists them.")] = False,
    *,
    cameras: Cameras,
) -> None:
    """Write a lesson: the real algorithm on a small picture, step by step, as one HTML page.

    For example:

        hsr lesson depth-buffer -o lesson.html
        hsr lesson --all -o course
    """
    from hsr.lessons.topics import topic_named, topics
    from hsr.pages.lesson import write_course, write_lesson

    if course == (topic is not None):
        raise HsrError(f"name a topic or say --all; the topics are {', '.join(topics())}")
    if output is None:
        raise HsrError("say where to write by -o: a page.html for one topic, a folder for --all")
    chosen = None if topic is None else topic_named(topic)
    cli.check_output(output, *((".html",) if chosen else ()))
    if chosen is None:
        write_course(topics(), make_folder(output))
    else:
        write_lesson(chosen, output, None if scene is None else cameras.one(hsr.load(scene)))
    cli.say(f"wrote {output}")

"""What notebooks show of scenes, and the inspector within them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from hsr.lab.named import load
from hsr.problem.view import Scene

__all__ = ["Report", "Scene", "load", "report"]

SIZE = (192, 144)
"""Width and height of the picture of a scene, in pixels."""

FRAME = Markup(
    '<iframe srcdoc="{}" title="{}" sandbox="allow-scripts allow-popups" loading="lazy" '
    'style="width: 100%; height: 48em; border: 1px solid #8888"></iframe>'
)


@dataclass(frozen=True)
class Report:
    """The inspector of samples as a page: a notebook shows it, and it can be written.

    Attributes
    ----------
    html : str
        The whole page, which needs no network.
    """

    html: str

    def save(self, path: str | Path) -> None:
        """Write the page.

        Raises
        ------
        HsrError
            If the file cannot be written.
        """
        from hsr.base.files import write_whole

        write_whole(path, self.html, "the report")

    def _repr_html_(self) -> str:
        # Addresses within the page are its own, not the notebook's.
        page = self.html.replace("<head>", '<head><base href="about:srcdoc">', 1)
        return FRAME.format(page, "the inspector of samples")


def report(
    scene: Scene,
    methods: Sequence[str] = ("zbuffer", "scanline", "raycast", "opengl"),
    size: tuple[int, int] = (256, 256),
    camera: str | None = None,
    reference: str = "exact",
) -> Report:
    """Compare methods on a scene, and show every sample: any two maps side by side, causes, histories.

    Parameters
    ----------
    scene : Scene
    methods : sequence of str
        Names that ``hsr algos`` lists; what cannot run here is named and left out.
    size : (width, height)
        In pixels.
    camera : str, optional
        Name of the camera; the scene's first by default.
    reference : str
        The method to judge by.

    Returns
    -------
    Report
        A notebook shows it; ``report(...).save("report.html")`` writes it.

    Raises
    ------
    MethodError, ViewError
        If there is no such method or camera.

    Examples
    --------
    >>> import hsr
    >>> hsr.report(hsr.load("scenes/cyclic.toml"), ["painter"], size=(12, 9)).save("report.html")
    """
    from hsr.difference.study import explained, study
    from hsr.pages.report import report_page

    return Report(report_page([explained(study(scene, methods, reference, size, camera))]))


def scene_figure(scene: Scene) -> str:
    """Show a scene in a notebook: its picture from its first camera, and what is in it."""
    from hsr.algorithms.registry import render
    from hsr.pages.shading import shade
    from hsr.pictures.notebook import figure
    from hsr.problem.view import view

    seen = view(scene, size=SIZE)
    cameras = ", ".join(camera.name for camera in scene.camera)
    told = (scene.title, scene.about, f"{len(scene.object)} objects", f"cameras: {cameras}")
    return figure(shade(render(seen, "exact"), seen), "the scene", "\n".join(filter(None, told)))


# A scene is a description and knows nothing of what is made of it.
Scene._repr_html_ = scene_figure

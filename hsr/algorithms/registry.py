"""The methods by name, and the one function that runs any of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points, version
from importlib.util import find_spec
from typing import Any

from hsr.base.errors import HsrError, MethodError, named, nearest
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View, view
from hsr.scene.model import Camera, Scene

ENTRY_POINTS = "hsr.algorithms"
"""Entry-point group in which other packages register a :class:`Method`."""

WARM_UP = 8
"""Side in pixels of the picture a method draws before it is timed."""


GROWTHS = ("", "fragments", "hierarchy")
"""Laws of cost that a row may name."""

RESOLVES = ("depth", "order", "nothing")
"""By what a method may tell which of two faces is in front."""


@dataclass(frozen=True)
class Method:
    """A named variant of an algorithm; all that is known of it anywhere stands here.

    Attributes
    ----------
    name : str
    about : str
        One line for people.
    module : str
        Module with a frozen dataclass ``Options`` and a function
        ``render(view: View, options: Options) -> VisibilityMap``; imported when first used.
    settings : mapping
        The options that make this variant; those not named keep their defaults.
    curved : bool
        Whether spheres and cylinders are exact; otherwise they are tessellated.
    needs : str
        What the machine must have: ``"opengl"``, ``"embree"`` or nothing.
    exhaustive : bool
        Whether it may test every face at every sample, which large scenes make slow.
    certified : bool
        Whether every sign that it decides by is proven: it is held to the exact map at every sample.
    pipeline : str
        Module with a ``PIPELINE``, the models that name the causes of its wrong samples; see
        :mod:`hsr.models.stages`.
    probe : str
        Module with a function ``probe(view, options)``, what a lesson watches; see :mod:`hsr.lessons.probes`.
    growth : str
        Its law of cost: ``"fragments"`` if it sets up every face and visits every fragment, ``"hierarchy"``
        if it enters a hierarchy once a pixel, or nothing is known.
    resolves : str
        What tells which of two faces is in front: their ``"depth"`` at every sample, an ``"order"`` of whole
        faces, or ``"nothing"``, so that no two that face the eye may overlap on the screen.
    asked_only : bool
        Whether it is run only when asked for by name.
    broken : str
        Why it cannot be used, of a method of another package; else empty.
    """

    name: str
    about: str
    module: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    curved: bool = False
    needs: str = ""
    exhaustive: bool = False
    certified: bool = False
    pipeline: str = ""
    probe: str = ""
    growth: str = ""
    resolves: str = "depth"
    asked_only: bool = False
    broken: str = ""

    def __post_init__(self) -> None:
        for name, known in (("growth", GROWTHS), ("resolves", RESOLVES)):
            if getattr(self, name) not in known:
                raise MethodError(f"{self.name}: {name} {getattr(self, name)!r} is none of {known}")

    def options(self, **overrides: Any) -> Any:
        """Return the options of this variant, with some of them replaced.

        Raises
        ------
        MethodError
            If an option does not exist or its value is refused.
        """
        defaults = _part(self.module, "Options")
        known = [option.name for option in fields(defaults)]
        for name in overrides:
            if name not in known:
                told = f"{nearest(name, known)}it has {', '.join(known) or 'none'}"
                raise MethodError(f"{self.name} has no option {name!r}; {told}")
        return defaults(**{**self.settings, **overrides})

    def render(self, view: View, **overrides: Any) -> VisibilityMap:
        """Run the method on a view; see :func:`render`."""
        if self.broken:
            raise MethodError(f"{self.name}: {self.broken}")
        options = self.options(**overrides)
        try:
            answer: VisibilityMap = _part(self.module, "render")(view, options)
        except Exception as error:
            if self.ours or isinstance(error, HsrError):
                raise
            raise MethodError(f"{self.name}: it broke down: {_told(error).rstrip(': ')}") from error
        size = (view.height, view.width)
        if not isinstance(answer, VisibilityMap) or not answer.face.shape == answer.depth.shape == size:
            raise MethodError(f"{self.name}: its answer is no map of {view.width}x{view.height} samples")
        return replace(answer, method=self.name, manifest=view.manifest, hashes=view.hashes)

    def warm_up(self, view: View) -> None:
        """Render a tiny picture of the same objects, so that compiling is not timed later."""
        # What is prepared of the objects is not compiling: it stays to be timed.
        self.render(replace(view, width=WARM_UP, height=WARM_UP, placements=tuple(view.placements)))
        from hsr.base.jit import note_compiled  # takes long to load, and is loaded by now

        note_compiled(self.name)

    @property
    def ours(self) -> bool:
        """Whether it is of this package."""
        return self.module.startswith("hsr.")

    def load_pipeline(self) -> Any:
        """Return the models of the method, None if its row names none."""
        return _part(self.pipeline, "PIPELINE") if self.pipeline else None

    def load_probe(self) -> Any:
        """Return what makes the probe of a run, None if the row names none."""
        return _part(self.probe, "probe") if self.probe else None


def _part(module: str, name: str) -> Any:
    """Import what a row names."""
    try:
        return getattr(import_module(module), name)
    except AttributeError as error:
        raise MethodError(f"{module} has no {name}, which the row of a method names") from error


Rows = Mapping[str, tuple[str, Mapping[str, Any]]]
"""Variants of a method by the rest of their names: what each is, and its settings on top of the method's."""


def _variants(of: Method, rows: Rows, told: str = "{}", **changed: Any) -> Iterator[Method]:
    """Make variants of a method, not certified; ``told`` is what people read of all of them."""
    for name, (about, settings) in rows.items():
        whole, settings = f"{of.name}-{name}", {**of.settings, **settings}
        yield replace(of, name=whole, about=told.format(about), settings=settings, certified=False, **changed)


SCANLINE = Method(
    "scanline",
    "depth buffer, incremental scan conversion, float64",
    "hsr.algorithms.scanline",
    pipeline="hsr.models.scanline",
    probe="hsr.lessons.probes.scanline",
    growth="fragments",
)

ZBUFFER = Method(
    "zbuffer",
    "depth buffer, half-space tests with hierarchical z, certified",
    "hsr.algorithms.zbuffer",
    certified=True,
    pipeline="hsr.models.certified",
    probe="hsr.lessons.probes.zbuffer",
    growth="fragments",
)

RAYCAST = Method(
    "raycast",
    "ray casting, coherent tiles of rays, certified",
    "hsr.algorithms.raycast",
    curved=True,
    certified=True,
    pipeline="hsr.models.raycast",
    probe="hsr.lessons.probes.raycast",
    growth="hierarchy",
)

EMBREE = Method(
    "embree",
    "Embree through embreex's own API",
    "hsr.algorithms.embree",
    needs="embree",
    pipeline="hsr.models.embree.pipeline",
    growth="hierarchy",
)

PLAIN: Rows = {"plain": ("the same without certification: rounding decides", {"certified": False})}

FLOAT32 = {"arithmetic": "float32", "depth_format": "d32f"}
FIXED = {"arithmetic": "fixed", "guard_bits": 12, "depth_format": "d24"}

SCAN_CONVERSIONS: Rows = {
    "direct": ("plane and edges evaluated at every sample, float64", {"stepping": "direct"}),
    "float32": ("incremental, float32", FLOAT32),
    "float32-direct": ("evaluated at every sample, float32", {**FLOAT32, "stepping": "direct"}),
    "fixed": ("incremental, 24-bit depth with 12 guard bits", FIXED),
    "d16": ("depths stored in 16 bits", {"depth_format": "d16"}),
    "d24": ("depths stored in 24 bits", {"depth_format": "d24"}),
    "d32f-reversed": ("depths stored as float32, 1 at near and 0 at far", {"depth_format": "d32f-reversed"}),
    "w16": ("linear depths stored in 16 bits", {"depth_format": "w16"}),
    "snap-4": ("corners on a grid of 1/16 pixel", {"subpixel_bits": 4}),
    "snap-8": ("corners on a grid of 1/256 pixel", {"subpixel_bits": 8}),
    "bottom-left": ("bottom edges own their samples, not top edges", {"fill_rule": "bottom-left"}),
    "less-equal": ("of equal depths the last drawn is kept", {"depth_test": "less-equal"}),
}

SINGLE = {"acceleration": "hierarchy"}
EDGES, TRUMBORE, WOOP = ({**SINGLE, "test": test} for test in ("edge-planes", "moller-trumbore", "woop"))

LISTS: Rows = {
    "extents": ("over the object list, an extent around every object", {"acceleration": "extents"}),
    "list": ("as the textbook has it: every ray against the whole object list", {"acceleration": "none"}),
}

SINGLE_RAYS: Rows = {
    "edge-planes": ("triangles by the planes through eye and edges", EDGES),
    "moller-trumbore": ("triangles by Möller and Trumbore's test", TRUMBORE),
    "woop": ("triangles by Woop's watertight test", WOOP),
    "float32": ("edge planes in float32", {**EDGES, "arithmetic": "float32"}),
    "moller-trumbore-float32": (
        "Möller and Trumbore's test in float32",
        {**TRUMBORE, "arithmetic": "float32"},
    ),
    "woop-float32": ("Woop's watertight test in float32", {**WOOP, "arithmetic": "float32"}),
    "naive-slabs": ("extents without care for rounding", {**SINGLE, "slabs": "naive"}),
}

PACKETS: Rows = {"packets": ("packets of 4 x 4 coherent rays on all threads", {"interface": "packets"})}

BUILT_IN = (
    Method("exact", "exact arithmetic: the truth, and every tie", "hsr.algorithms.exact", curved=True),
    Method(
        "backface",
        "back-face culling alone: what is left, in file order",
        "hsr.algorithms.backface",
        pipeline="hsr.models.backface",
        probe="hsr.lessons.probes.backface",
        growth="fragments",
        resolves="nothing",
    ),
    Method(
        "painter",
        "polygons painted back to front by their farthest corner",
        "hsr.algorithms.painter",
        pipeline="hsr.models.painter",
        resolves="order",
    ),
    SCANLINE,
    *_variants(SCANLINE, SCAN_CONVERSIONS, "scan conversion, {}"),
    ZBUFFER,
    *_variants(ZBUFFER, PLAIN, pipeline="hsr.models.zbuffer"),
    RAYCAST,
    *_variants(RAYCAST, PLAIN),
    *_variants(
        RAYCAST, {"single": ("one ray at a time through extents and hierarchies", SINGLE)}, "ray casting, {}"
    ),
    *_variants(RAYCAST, LISTS, "ray casting {}", exhaustive=True),
    *_variants(RAYCAST, SINGLE_RAYS, "ray casting, single rays, {}"),
    Method(
        "opengl",
        "headless OpenGL: OSMesa, else EGL",
        "hsr.algorithms.opengl",
        needs="opengl",
        pipeline="hsr.models.llvmpipe.pipeline",
        growth="fragments",
    ),
    EMBREE,
    *_variants(EMBREE, PACKETS, "Embree's library, {}"),
    *_variants(
        EMBREE,
        {"single": ("Embree's library, one ray at a time on all threads", {"interface": "single"})},
        asked_only=True,
    ),
)


@cache
def methods() -> dict[str, Method]:
    """Return all methods by name: the built-in ones, then those other packages register.

    Examples
    --------
    >>> import hsr
    >>> hsr.methods()["raycast"].curved  # spheres and cylinders as they are
    True
    >>> hsr.methods()["scanline-float32-direct"].about
    'scan conversion, evaluated at every sample, float32'
    """
    found = {method.name: method for method in BUILT_IN}
    for entry in entry_points(group=ENTRY_POINTS):
        method = _registered(entry)
        found.setdefault(method.name, method)
    return found


def _registered(entry: EntryPoint) -> Method:
    """Return the method of another package, or one that says why there is none."""
    try:
        method = entry.load()
        why = f"entry point {entry.value} must be an hsr.Method, not {type(method).__name__}"
    except Exception as error:
        method, why = None, f"entry point {entry.value} cannot be loaded: {_told(error)}"
    return method if isinstance(method, Method) else Method(entry.name, why, entry.value, broken=why)


def _told(error: Exception) -> str:
    """Write in one line what another package raised."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def method_named(name: str) -> Method:
    """Return one method.

    Raises
    ------
    MethodError
        If no method has that name.
    """
    return named(name, methods(), "no method is named", MethodError)


def default_methods() -> list[str]:
    """Name the methods worth a row unasked.

    Returns
    -------
    list of str
        The method that a family is called after, every peer from outside (it needs something of the
        machine), and what tests every face at every sample. Left out are variants, such as ``scanline-d16``,
        and what is run only when asked for.
    """
    return [
        name
        for name, method in methods().items()
        if ("-" not in name or method.needs or method.exhaustive or method.broken) and not method.asked_only
    ]


def driver_of(method: Method) -> str:
    """Name the program beside this package by which a method works, and its version; empty if none.

    Raises
    ------
    UnavailableError
        If it is missing.
    """
    if method.needs == "opengl":
        from hsr.gl.backends import shared_context

        context = shared_context()
        return f"{context.backend} {context.renderer} {context.version}"
    return f"embreex {version('embreex')}" if method.needs == "embree" and find_spec("embreex") else ""


def certified_methods() -> tuple[str, ...]:
    """Name the methods that show the truth wherever they are asked."""
    return tuple(name for name, method in methods().items() if method.certified)


def render(
    scene: Scene | View,
    method: str = "zbuffer",
    size: tuple[int, int] | None = None,
    camera: str | Camera | None = None,
    **options: Any,
) -> VisibilityMap:
    """Decide which face owns each sample, by the named method.

    Parameters
    ----------
    scene : Scene or View
    method : str
        A name that ``hsr algos`` lists.
    size : (width, height), optional
        Image size in pixels, 512 x 512 by default; only with a scene.
    camera : str, Perspective, Orthographic or MatrixCamera, optional
        Name of one of the scene's, or any other, the scene's first by default; only with a scene.
    **options
        Options of the method in place of its defaults.

    Returns
    -------
    VisibilityMap

    Raises
    ------
    MethodError
        If the method or an option does not exist, size or camera are given with a view, or what is given is
        neither a scene nor a view.
    ViewError
        If the view cannot be made.
    UnavailableError
        If the method needs what this machine lacks.

    Examples
    --------
    >>> import hsr
    >>> map = hsr.render(hsr.load("scenes/cube.toml"), "zbuffer", size=(10, 8))
    >>> print(map.face)
    [[-1 -1 -1 -1  0 -1 -1 -1 -1 -1]
     [-1  4  0  0  0  0  0  0 -1 -1]
     [-1 -1  4  4  4  4  2  2 -1 -1]
     [-1 -1  4  4  4  4  2  2 -1 -1]
     [-1 -1  4  4  4  4  2  2 -1 -1]
     [-1 -1  4  4  4  4  2  2 -1 -1]
     [-1 -1 -1 -1  4  4  2 -1 -1 -1]
     [-1 -1 -1 -1 -1 -1 -1 -1 -1 -1]]
    >>> print(map.depth[1].round(2))
    [ inf 4.47 4.18 4.18 4.18 4.18 4.18 4.18  inf  inf]
    """
    chosen = method_named(method)
    if not isinstance(scene, Scene | View):
        raise MethodError(
            f"render takes a scene or a view, not {type(scene).__name__}; read a file by hsr.load"
        )
    if isinstance(scene, View):
        if size is not None or camera is not None:
            raise MethodError("a view has its size and camera; give them only with a scene")
        return chosen.render(scene, **options)
    return chosen.render(view(scene, size or (512, 512), camera), **options)

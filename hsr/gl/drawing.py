"""A view in OpenGL: its triangles uploaded once a scene, drawn, and read back as face ids and depths.

The triangles are drawn in order of their faces, with float32 vertices and matrix, one sample a
pixel, into two attachments: R32I for the number of the triangle + 1, cleared to 0, and a depth
buffer (:mod:`hsr.gl.depth`), cleared to far and compared by ``GL_LESS``, reversed by
``GL_GREATER``, so that of two equal stored depths the lower face wins. Who owns a sample on an edge
is the driver's rule: OpenGL only promises one owner for an edge two triangles share.
"""

from __future__ import annotations

from contextlib import AbstractContextManager

import moderngl
import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.errors import MethodError
from hsr.gl.context import Context
from hsr.gl.depth import D24, DepthBuffer, clip_range, depth_texture
from hsr.problem.geometry import CULL, WorldPolygons, as_float32
from hsr.problem.map import BACKGROUND
from hsr.problem.view import View


class Triangles:
    """The triangles of a geometry without curved shapes in the memory of OpenGL, for all its views.

    Given back when a drawing is made after they are no longer needed: the context collects them.

    Attributes
    ----------
    array : moderngl.VertexArray
    face_of : (n + 1,) int32
        Face of each triangle, after that of the background.
    runs : list of (int, int, int)
        Where culling changes: what to cull, first triangle, number of triangles.
    vertices : int
    """

    def __init__(self, context: Context, polygons: WorldPolygons) -> None:
        vertices = as_float32(polygons.vertices, "opengl")
        with context.gl as gl:
            corner = gl.buffer(np.ascontiguousarray(polygons.triangle_vertex))
            content = [(gl.buffer(vertices), "3f", "vertex")]
            self.array = gl.vertex_array(context.program, content, index_buffer=corner)
        self.face_of = np.append(np.int32(BACKGROUND), polygons.triangle_face)
        self.runs = _runs(polygons.cull[polygons.triangle_polygon])
        self.vertices = len(vertices)


class Drawing(AbstractContextManager["Drawing"]):
    """One view in the memory of OpenGL.

    A triangle is numbered by ``gl_PrimitiveID`` and named after its face when read, so that vertices
    stay shared and a mesh costs what it costs any OpenGL program.

    Parameters
    ----------
    context : Context
    view : View
        Curved shapes are tessellated.
    buffer : DepthBuffer

    Raises
    ------
    MethodError
        If the image is larger than the driver draws, or a coordinate is beyond float32.
    UnavailableError
        If the buffer needs more than the driver's OpenGL.
    """

    def __init__(self, context: Context, view: View, buffer: DepthBuffer = D24) -> None:
        size, most = (view.width, view.height), context.max_side
        if max(size) > most:
            told = "opengl: this driver draws at most {} samples a side, not {}x{}; choose a smaller size"
            raise MethodError(told.format(most, *size))
        geometry = view.tessellated().geometry
        self._triangles = geometry.once(("opengl", context), lambda: Triangles(context, geometry.polygons))
        matrix = as_float32(buffer.clip_from_world(view), "opengl")
        self.view, self._context, self._buffer = view, context, buffer
        self.vertices, self.triangles = self._triangles.vertices, len(self._triangles.face_of) - 1
        self._matrix = tuple(matrix.T.ravel())  # OpenGL's matrices are column after column
        with context.gl as gl:
            textures = gl.texture(size, components=1, dtype="i4"), depth_texture(context, size, buffer)
            try:
                self._frame = gl.framebuffer(*textures)
            except moderngl.Error as error:
                told = "opengl: the driver has no room for {}x{} samples; choose a smaller size"
                raise MethodError(told.format(*size)) from error

    def draw(self) -> None:
        """Clear, draw every triangle, and wait until all is drawn."""
        with self._context.gl as gl, clip_range(self._context, self._buffer):
            self._frame.use()
            # Of an integer attachment moderngl sets the bits of 0.0, which are 0.
            self._frame.clear(depth=self._buffer.cleared_to)
            program = self._context.program
            program["clip_from_world"] = self._matrix
            gl.depth_func = ">" if self._buffer.reversed else "<"
            for cull, first, count in self._triangles.runs:
                _set_culling(gl, cull)
                program["first"] = first
                self._triangles.array.render(vertices=3 * count, first=3 * first)
            gl.finish()

    def read(self) -> tuple[Ints, Floats]:
        """Return what was drawn.

        OpenGL's row 0 is the bottom row; the rows are turned over here, and only here.

        Returns
        -------
        face : (H, W) int32
            -1 where nothing was drawn.
        depth : (H, W) float64
            Along the view axis, ``+inf`` where nothing was drawn.
        """
        shape = (self.view.height, self.view.width)
        bits, kind = self._buffer.bits, "u4" if self._buffer.bits else "f4"
        triangle, stored = np.empty(shape, np.int32), np.empty(shape, kind)
        with self._context.gl:
            self._frame.read_into(triangle, components=1, attachment=0, dtype="i4")
            self._frame.read_into(stored, components=1, attachment=-1, dtype=kind)
        face = self._triangles.face_of[triangle[::-1]]
        drawn = face != BACKGROUND
        depth = np.full(shape, np.inf)
        window = stored[::-1][drawn]
        if bits:  # OpenGL returns the stored integers as 32 bits, their upper bits repeated below
            window = (window >> (32 - bits)) * self._buffer.step
        depth[drawn] = depth_of_window(self.view, window.astype(np.float64), self._buffer.reversed)
        return face, depth

    def __exit__(self, *exception: object) -> None:
        """Give the memory back to OpenGL."""
        with self._context.gl as gl:
            gl.screen.use()  # a deleted frame must not stay bound
            del self._frame
            gl.gc()


def depth_of_window(view: View, window: Floats, reversed: bool = False) -> Floats:
    """Carry stored depths back to depths along the view axis.

    OpenGL stores z / w, moved from [-1, 1] to [0, 1]: affine in 1 / depth under perspective,
    affine in depth for a parallel view (Foley, van Dam et al., *Computer Graphics: Principles and
    Practice*, the canonical view volumes).

    Parameters
    ----------
    view : View
        Its far may be infinite.
    window : float64 array
        0 at near, 1 at far; below 1 if far is infinite.
    reversed : bool
        Whether it is 1 at near and 0 at far.

    Returns
    -------
    float64 array of the same shape
    """
    at_0, at_1 = (view.far, view.near) if reversed else (view.near, view.far)
    if view.perspective:
        return 1.0 / ((1.0 - window) / at_0 + window / at_1)
    return (1.0 - window) * at_0 + window * at_1


def _runs(cull: Array) -> list[tuple[int, int, int]]:
    """Cut the triangles where culling changes: what to cull, first triangle, number of triangles."""
    starts = np.append(0, np.flatnonzero(np.diff(cull)) + 1)
    counts = np.diff(np.append(starts, len(cull)))
    return [(int(cull[k]), int(k), int(count)) for k, count in zip(starts, counts, strict=True)]


def _set_culling(gl: moderngl.Context, cull: int) -> None:
    """Cull the back or the front: a front runs counter-clockwise, as OpenGL and the view both have it."""
    gl.enable_only(moderngl.DEPTH_TEST | (moderngl.NOTHING if cull == CULL["none"] else moderngl.CULL_FACE))
    gl.cull_face = "front" if cull == CULL["front"] else "back"

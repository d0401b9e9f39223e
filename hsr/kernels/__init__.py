"""Numba kernels: numbers and arrays in and out, nothing of scenes or files.

Read first the textbook's algorithms, each alone in its file: :mod:`.culling`, :mod:`.scanline`, :mod:`.rays`
with :mod:`.hits`. Beside them stand their variants, and in ``zbuffer`` and ``raytiles`` the certified ones.

Glossary
--------
sample
    The centre of a pixel; row r, column c is at (c + 0.5, r + 0.5), rows running down.
depth
    Distance from the eye along the view axis, in scene units.
window depth, z
    What is affine on the screen and grows with depth: 0 at the near plane, 1 at the far plane.
nearness
    What is affine on the screen and grows toward the eye: 1 / depth under perspective, else -depth.
key
    What the depth buffer of ``zbuffer`` and ``raytiles`` holds of a sample: a key depth in the upper bits,
    the number of a piece in the lower. The least key is the nearest.
key depth
    Nearness brought to a number that grows away from the eye, within one power of two.
face, triangle, piece
    A face is what a map names; its triangles are the fan about its first corner; a piece is what a key
    names, a triangle or a face of a round solid.
polygon table
    What scan conversion computes once a polygon.
scan line, span
    A row of samples; those of one between two sides of a polygon. Of a ray: its interval within a solid.
fragment
    A sample of a span with the depth of the polygon there, before the depth test.
strip, tile
    Scan lines for one thread; a rectangle of samples, whose keys an array holds.
extent, node, leaf
    A box around an object; around what is below it in a hierarchy; a node with boxes or triangles below it.
cluster
    Neighbouring triangles that are set up side by side.
uncertain, doubt
    What rounding may have turned; its note, to be decided exactly (:mod:`hsr.certify`).
"""

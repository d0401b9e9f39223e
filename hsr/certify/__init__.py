"""Exact decisions for the samples that a certified method could not decide in float64, and the whole proof.

**Theorem.** At every sample the face that a certified method shows, or the background, is the oracle's
(:func:`hsr.exact.oracle.truth`): the owner in the limit from the right and below, the lowest face of
several that coincide. ``zbuffer`` says so of ``view.tessellated()``, ``raycast`` of the view with its
curved shapes as they are. Their rows have the field ``certified``, and ``tests/proof.py`` holds them to it.
Depths are no part of the theorem.

Assumptions
-----------
- float64 is that of IEEE 754: sums, products, quotients and square roots are rounded to nearest, underflow
  is gradual, and nothing is fused, reordered or kept in wider registers. The one decorator of kernels sees
  to the compiler's part, see :mod:`hsr.base.jit`.
- The numbers of a view are finite (a far plane may be infinite), its camera is invertible, and depth grows
  along its lines of sight, from less than near at the eye if there is one.
- World points are exact products. What a kernel gets of them was rounded, and the bound of that comes
  along: the slack of a mesh, and of the box around it.
- Python's integers and FLINT's polynomials are exact; Numba and LLVM compile what is written.

Structure
---------
Fix a sample. A *piece* is a triangle of a face, or a quadric or end of a round solid. In the limit each
piece covers the sample or does not, and those that do have depths in an order. Four statements make the
theorem.

1. *Coverage is proven or uncertain.* A number that must be positive inside is computed with a bound of its
   error. Above the bound the piece covers the sample and its neighbourhood, below minus the bound it does
   not meet it, and between them the piece is a *doubt*. Edges are those of projected corners if all corners
   are proven ahead of the eye, to within ``PRECISE`` pixels; otherwise they are the homogeneous edges, from
   exact integers rounded once. See :func:`hsr.kernels.zbuffer.fill.fill`,
   :func:`hsr.kernels.zbuffer.fill.note`, :func:`hsr.kernels.zbuffer.fill.suspect` and
   :func:`hsr.kernels.raytiles.curved.meet_quadric`.
2. *Depth is proven or uncertain.* A piece that is proven to cover a sample enters the keys, and of two such
   pieces the one with the lesser key is nearer if the keys differ by more than a gap. If they do not, both
   are doubts: the one is written down, the other either stays in the keys, and is added in the end, or
   gives way to a piece that is proven nearer. See :func:`hsr.kernels.zbuffer.fill.settle`.
3. *What is left out is proven to be hidden or outside.* Clusters and triangles that certainly turn the side
   that is culled (:func:`hsr.kernels.zbuffer.facing.leave_out`,
   :func:`hsr.kernels.zbuffer.setup.set_up`); what lies beside a tile, between samples, or beyond near
   or far; columns of a scan line outside an edge (:func:`hsr.kernels.zbuffer.fill.span_of`); nodes,
   objects and clusters behind all that their cells show (:func:`hsr.kernels.zbuffer.fill.is_hidden`,
   :func:`hsr.kernels.zbuffer.fill.is_behind`): what cells show only gets nearer. A doubt is forgotten if
   something proven to cover the sample is proven nearer.
4. *Uncertain samples are decided exactly.* So the owner of a sample with doubts is among its doubts, or it
   is the background. :func:`hsr.certify.decision.resolve` asks all of them, without rounding. Where doubts
   have no room they are counted all the same, and the tile is done again with room for all.

By 1 and 3, at a sample without doubts the keys hold the nearest of all pieces that cover it, and by 2 it is
the only one of that depth: so it owns the sample. At a sample with doubts 4 does. Neither the order of
pieces nor the number of threads enters the argument.

How the rest is decided
-----------------------
On the numbers of the view as they stand, in integers of any length:

- A planar piece covers a sample by the signs of its homogeneous edge functions (M. Olano, T. Greer,
  *Triangle Scan Conversion using 2D Homogeneous Coordinates*, 1997), which need no clipping: only what lies
  in front of the eye counts by itself. Near and far are two more half-planes on the face. Along a line of
  sight, pieces are ordered by a function that is affine on the screen: depth in a parallel view, -1 / w
  under perspective. See :mod:`hsr.certify.facets`.
- A quadric and its ends are met where a polynomial vanishes along the line of sight; two such roots are
  compared by squaring. See :mod:`hsr.certify.curved`.

Every sign is that of the limit at (x + e, y + d), to the right and then down, with d positive and smaller
than every power of e (as in H. Edelsbrunner, E. P. Muecke, *Simulation of Simplicity*, ACM Transactions on
Graphics 9(1), 1990). So a sample on an edge belongs to exactly one of the two faces beside it, the one to
the right or else below, and only surfaces that coincide in a whole neighbourhood tie: there the lowest face
id owns. Near and far are closed. It shares no code with the oracle; a third decision, by brute force in
fractions, judges both: ``test_owners_by_brute_force`` in ``tests/certify/test_decision.py``.

The bounds
----------
U is 2^-53. Each is derived beside the line that uses it; here is what is bounded, by what, and the test that
compares it with exact fractions. A test *has teeth* if it fails when the constant is weakened; for each it is
said what was tried.

:func:`hsr.kernels.zbuffer.setup.eye_around`
    Clip coordinates: 16 U of the sum of the magnitudes of the terms of a row of the matrix, and the slack
    of the mesh times its entries.
    Test: ``test_projected_vertices_are_within_their_error`` in
    ``tests/kernels/zbuffer/test_setup.py``.
    No teeth: 16 U may be 1 U, for the bounds of rounding add up to far more than roundings do.
:func:`hsr.kernels.zbuffer.setup.projected`
    A corner on the screen: W ((error_x + |x / d| error_d) / d + 4 U (|x / d| + 1)), likewise down; anywhere
    unless d > 2 error_d.
    Test: ``test_projected_vertices_are_within_their_error`` in
    ``tests/kernels/zbuffer/test_setup.py``.
    Test: ``test_what_overflows_may_be_anywhere`` in ``tests/kernels/zbuffer/test_setup.py``.
    Fails for an eighth of the whole, and without the first term; the term 4 U has no teeth.
:func:`hsr.kernels.zbuffer.setup.nearness_error`
    Nearness n of a corner: n (2 n error_d + 2 U) under perspective, error_d else.
    Test: ``test_projected_vertices_are_within_their_error`` in
    ``tests/kernels/zbuffer/test_setup.py``.
    Fails for 0; no teeth for a sixteenth.
:func:`hsr.kernels.zbuffer.setup.set_up`
    Edge functions and twice the area: 4 t (w + h + 20) + 32 U (w + 18) (h + 2), for corners off by t and a
    box of w by h.
    Test: ``test_edge_functions_and_depths_are_within_their_bounds`` in
    ``tests/kernels/zbuffer/test_setup.py``.
    Fails without the term of t; no teeth for an eighth of the whole, nor without the term of U.
:func:`hsr.kernels.zbuffer.setup.set_up`
    Key depth wherever the triangle is: slack of its corners + t (|z_x| + |z_y|) + 128 U (1 + w h / |area|
    (w |z_x| + h |z_y|)).
    Test: ``test_edge_functions_and_depths_are_within_their_bounds`` in
    ``tests/kernels/zbuffer/test_setup.py``.
    Fails without the second term and without the third; no teeth for a 64th of the third, nor without the
    first.
:func:`hsr.kernels.zbuffer.setup.set_up`
    Least and greatest key depth of the corners: their slack and 8 U (1 + |z|).
    No test compares it.
:func:`hsr.kernels.zbuffer.setup.samples_between`
    Samples between two places, each off by an error: nothing more, for rounding is monotone and halves are
    float64.
    No test of its own; that of the extents of nodes passes without the error.
:func:`hsr.kernels.zbuffer.fill.gap_of`
    Keys whose depths may be equal differ by at most 2^64 tie + 2 (cut-off bits) + 2; a tie is at least
    2^-36 of the range of depth, and a key depth less certain than a tie is a doubt wherever its piece may
    be.
    Test: ``test_the_gap_of_depths_covers_what_keys_cut_off`` in
    ``tests/kernels/zbuffer/test_fill.py``.
    Test: ``test_depths_within_their_errors_are_doubts_about_both`` in
    ``tests/kernels/zbuffer/test_fill.py``.
    The first fails without what is cut off.
:func:`hsr.kernels.zbuffer.fill.limits_of`
    Near and far count as edges, scaled so that an error of a tie is the bound of an edge.
    Test: ``test_a_depth_at_near_or_far_is_a_doubt`` in ``tests/kernels/zbuffer/test_fill.py``.
    No teeth: the test asks at near and far themselves.
:func:`hsr.kernels.zbuffer.fill.span_of`
    Columns inside an edge: one sample more at either end.
    Test: ``test_spans_leave_out_only_what_is_outside`` in ``tests/kernels/zbuffer/test_fill.py``.
    No teeth: the sample may go at the beginning, where cutting off the fraction leaves room.
:func:`hsr.kernels.zbuffer.facing.normal_boxes`
    A coordinate of a normal: 8 s (u + v) + 16 s^2 + 16 U u v, for corners off by s and sides of at most u
    and v.
    Test: ``test_normals_are_as_uncertain_as_the_corners`` in ``tests/kernels/zbuffer/test_facing.py``.
    Test: ``test_what_is_left_out_is_culled`` in ``tests/kernels/zbuffer/test_facing.py``.
    The first fails without the terms of s; the last term has no teeth.
:func:`hsr.kernels.zbuffer.facing.determinant_of`
    What the products with normals are taken of: 32 U of the sum of the magnitudes.
    Test: ``test_what_is_left_out_is_culled`` in ``tests/kernels/zbuffer/test_facing.py``.
    No teeth: 32 U may be 0.
:func:`hsr.kernels.zbuffer.facing.leave_out`
    The line of sight to a corner of the box: |det| s and the errors above, 4 U (|det| |p| + |q|); the
    products with normals: 8 U of each.
    Test: ``test_what_is_within_an_error_stays`` in ``tests/kernels/zbuffer/test_facing.py``.
    Test: ``test_what_is_left_out_is_culled`` in ``tests/kernels/zbuffer/test_facing.py``.
    The first fails without the term of s; those of U have no teeth.
:func:`hsr.kernels.zbuffer.setup.reach_box`
    What a box may cover, and its least key depth: those of its eight corners, see ``projected``.
    Test: ``test_the_extent_of_a_node_holds_all_certain_triangles_below_it`` in
    ``tests/kernels/raytiles/test_casting.py``.
    Not weakened so far; the test looks at the extents of nodes, which are joined from those of triangles.
:func:`hsr.kernels.raytiles.casting.may_show`
    Objects behind all that their cells show, by more than a gap.
    Test: ``test_an_object_may_show_unless_all_its_cells_show_something_nearer`` in
    ``tests/kernels/raytiles/test_casting.py``.
    Not weakened so far.
:func:`hsr.kernels.raytiles.curved.affine`
    L, M, R, P and Q: ``FEW`` = 8 U of the sum of the magnitudes of their terms, of coefficients that were
    rounded once (:func:`hsr.algorithms.prepare.quadrics.quadrics_of`).
    Test: ``test_coefficients_give_their_functions_within_the_bound`` in
    ``tests/kernels/raytiles/test_curved.py``.
    Fails if 8 is 2.
:func:`hsr.kernels.raytiles.curved.quotient`
    A quotient: 2 (error of a + |a / b| error of b) / |b| + 2 U |a / b|, if b is off by at most half of
    itself.
    Test: ``test_quotients_are_within_their_bounds`` in ``tests/kernels/raytiles/test_curved.py``.
    Fails if 2 is 1.
:func:`hsr.kernels.raytiles.curved.meet_quadric`
    The root of R: 2 r_error / max(root, sqrt(r_error)) + 2 U root.
    Test: ``test_roots_near_the_outline_are_within_their_bounds`` in
    ``tests/kernels/raytiles/test_curved.py``.
    Fails if the first 2 is a quarter.
:func:`hsr.kernels.raytiles.curved.meet_end`
    The polynomial in the plane of an end: (2 |K v| + 2 size_l + |K| dv) dv + ``FEW`` of its terms.
    Test: ``test_certain_hits_are_what_is_seen_and_within_their_bounds`` in
    ``tests/kernels/raytiles/test_curved.py``.
    No teeth: without any bound the test still passes.
:func:`hsr.kernels.raytiles.curved.key_hit`
    The key depth of a hit: the error of v, that of nearness, and 8 U (|Z0| + |v|); at least a tie.
    Test: ``test_certain_hits_are_what_is_seen_and_within_their_bounds`` in
    ``tests/kernels/raytiles/test_curved.py``.
    No teeth for any of the three: a tie is more than they are in all views that are tried.
:func:`hsr.algorithms.prepare.behind_eye.crossing_tables`
    Exact edges rounded once: ``ROUNDED`` = 16 U; key depth: that of nearness, 8 U of the values, and 64 U
    (1 + |z_x| W + |z_y| H).
    Test: ``test_key_depths_are_within_their_bound`` in ``tests/algorithms/prepare/test_behind_eye.py``.
    Fails without the two in the middle; ``ROUNDED`` and the 64 U have no teeth.
:func:`hsr.algorithms.prepare.behind_eye.boxes`
    Samples that a triangle around the eye may cover: 2 (error + 2 error_d) + 64 U of its size, over the
    least depth, and a sample more on each side.
    No test compares it.

What is weak
------------
- Most terms of rounding are so generous that no test notices if they go: roundings rarely conspire, and the
  terms of what corners are off by, or a tie, are greater in all views that the tests try. They rest on
  their derivations. Proofs by an interval prover (Gappa) and searches for the worst case, which are no part
  of this package, found those that they looked at true, except as follows.
- ``nearness_error`` is proven by machine up to error_d = 0.49 d. In the last few units in the last place
  before d = 2 error_d, from where on a corner counts as behind the eye, its factor 2 leaves nothing for the
  roundings of the bound itself.
- ``meet_end`` counts 8 roundings for its M and has room for 8.
- :func:`hsr.kernels.boxes.box_entry` pads by two units in the last place, which cannot make up for three
  roundings on either side: there are rays that meet an edge of a box exactly and miss it by this test. No
  certified method asks it.
"""

from hsr.certify.decision import Resolved, facets_at, first_pieces, resolve, sights_at

__all__ = ["Resolved", "facets_at", "first_pieces", "resolve", "sights_at"]

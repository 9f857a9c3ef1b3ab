"""The energy of one frozen round as a function of a vector, for your own optimiser."""

import typing

import numpy

from burin import _burin
from burin._options import Options, as_options
from burin._refine import select_pairs


class Energy:
    """E(x), photometric error plus smoothness, with visibility, masks and pairs frozen at `vertices`.

    x has one entry for each vertex that some pair sees, its move along its normal in pixel footprints
    (options.motion.type = "free": three each, in the coordinates' directions). x = 0 is the mesh as
    given. energy(x) returns (E, gradient), which scipy.optimize.minimize(..., jac=True) takes.

    With cameras=True six entries for each view that some pair has follow, in the order of the views: a
    rotation vector w in the camera's frame, radians, and a move dc of its centre along the world's axes in
    pixel footprints, R = Exp(w) R_0 and c = c_0 + dc, where X_cam = R (X - c). Gradient and Gauss-Newton
    matrix are by all entries: one footprint of a vertex, one radian, one footprint of a centre. E does not
    know the world's place, turn and size: the matrix has seven directions of no curvature in the photometric
    part.
    """

    def __init__(self, scene, vertices, faces, pairs=None,
                 options: typing.Optional[Options] = None, level=0, cameras=False):
        """pairs: of views, default those of select_pairs(). level: of the image pyramid, 0 = full size.
        cameras: are unknowns too."""
        options = as_options(options)
        vertices, faces = numpy.asarray(vertices), numpy.asarray(faces)
        if pairs is None:
            pairs = select_pairs(scene, vertices, faces, options).pairs
        self._native = _burin.Energy(scene, vertices, faces, pairs, options._native, level,
                                      bool(cameras))
        self.pairs = pairs

    def __call__(self, x):
        """(E, gradient) at x."""
        return self._native.evaluate(x)

    @property
    def unknowns(self):
        """Length of x."""
        return self._native.unknowns

    @property
    def footprint(self):
        """Scene units of 1 in x."""
        return self._native.footprint

    @property
    def vertex_of_unknown(self):
        """The vertex that each entry of x moves; -1 for those of cameras."""
        return self._native.vertex_of_unknown

    @property
    def camera_of_unknown(self):
        """The view whose camera each entry of x moves; -1 for those of vertices."""
        return self._native.camera_of_unknown

    @property
    def normals(self):
        """(V, 3), unit normals of the frozen mesh, 0 where there is none."""
        return self._native.normals

    def zero(self):
        """x of the mesh as given."""
        return numpy.zeros(self.unknowns)

    def gauss_newton(self, x):
        """(E, gradient, H): H is the Gauss-Newton matrix, (data, columns, row starts) of full rows, as
        scipy.sparse.csr_matrix takes it."""
        energy, gradient, data, columns, starts = self._native.linearize(x)
        return energy, gradient, (data, columns, starts)

    def terms(self, x):
        """E by term, and their "total"."""
        return self._native.terms(x)

    def vertices_at(self, x):
        """(V, 3), the mesh at x."""
        return self._native.vertices_at(x)

    def cameras_at(self, x):
        """(R, t) of all views at x in the scene's world, (N, 3, 3) and (N, 3): X_cam = R X + t."""
        return self._native.cameras_at(x)

    def kept_taps(self, view):
        """(H, W) integers: how many taps the occlusion mask of each pixel's window keeps; 0 where the
        view sees no facet."""
        return self._native.kept_taps(view)

    def solve(self, strategy):
        """What burin's own strategy makes of the same energy from x = 0: a dict with x, energy,
        iterations, evaluations, termination. Strategies: burin.strategies()."""
        return self._native.solve(strategy)

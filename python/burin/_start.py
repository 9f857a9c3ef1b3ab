"""A mesh to start from."""

import dataclasses

import numpy

from burin import _burin


@dataclasses.dataclass
class Start:
    """What mesh() returns."""

    vertices: numpy.ndarray  # (V, 3), the scene's unit
    faces: numpy.ndarray  # (F, 3)
    sights: numpy.ndarray  # (V,), the views that see the point
    lines: list  # what `burin mesh` says on its way


def mesh(scene, threads=0, **options):
    """A mesh to start from, made of the scene itself as `burin mesh` makes it (docs/mesh.md): a Start.

    options: those of `burin mesh` without "start.", as mesh(scene, points="sparse", min_views=2).
    threads: 0 is all cores; the mesh does not depend on it. Ctrl-C ends it with KeyboardInterrupt.
    """
    return Start(*_burin.mesh(scene, {name: str(value) for name, value in options.items()}, threads))

"""Whole runs on arrays."""

import dataclasses
import typing
import warnings

import numpy

from burin import _burin
from burin._options import Options, as_options


@dataclasses.dataclass
class Refinement:
    """What refine() returns."""

    vertices: numpy.ndarray  # (V, 3), the scene's unit
    faces: numpy.ndarray  # (F, 3)
    quality: dict  # per vertex: pairs, zncc, displacement_px, sd_px, cosine, step_px (docs/surface.md)
    cameras: dict  # names; intrinsics (V, 3, 3), rotations (V, 3, 3) and translations (V, 3) of the views used, refined (docs/cameras.md)
    summary: dict  # as summary.json has it
    # With surface.trim: the mesh before anything was cut away; vertices, faces, quality, and `cut`, by facet the reason
    # or "none". None where nothing was to be trimmed.
    whole: typing.Optional[dict] = None


@dataclasses.dataclass
class Selection:
    """Camera pairs (reference, second), indices of views."""

    pairs: list
    held_back: list  # the best pairs left out: refine() judges its levels by them
    warnings: list  # views without a partner, and why


def load_scene(path, images="", masks=""):
    """A scene in any format that burin reads (docs/formats.md), with its photographs.

    images: folder of the photographs, where it is not the scene's own. masks: folder of image masks.
    Warns (UserWarning) of cameras that are unlikely, and of sparse points that do not reproject.
    """
    scene = _burin.load_scene(path, images, masks)
    for doubt in _burin.doubts_about(scene):
        warnings.warn(doubt, stacklevel=2)
    return scene


def write_mesh(path, vertices, faces):
    """Writes a mesh as PLY, OBJ or OFF, by the extension."""
    _burin.write_mesh(path, numpy.asarray(vertices), numpy.asarray(faces))


def check(scene, vertices, faces, options: typing.Optional[Options] = None):
    """Whether cameras, photographs and mesh fit each other, as `burin check --json` says: a dict.

    verdict: good, doubtful, wrong or cannot tell; E, A, px: figures of the scene and of its views
    (docs/verdict.md).
    """
    vertices, faces = numpy.asarray(vertices), numpy.asarray(faces)
    return _burin.check(scene, vertices, faces, as_options(options)._native)


def refine(scene, vertices, faces, options: typing.Optional[Options] = None, callback=None):
    """The mesh that agrees better with the photographs, as `burin refine` finds it: a Refinement.

    vertices: (V, 3) floats; faces: (F, 3) integers, counter-clockwise from outside. callback, where
    given, is called after every iteration with a dict (level, round, iteration, energy, done, ...);
    when it returns False, the refinement ends with the mesh so far. Ctrl-C ends it with
    KeyboardInterrupt. Other Python threads run meanwhile. What cannot be right (check()) is not refined,
    views that do not fit are left out, each with a RuntimeWarning: options.verdict, options.scene.
    """
    vertices, faces = numpy.asarray(vertices), numpy.asarray(faces)
    return Refinement(
        **_burin.refine(scene, vertices, faces, as_options(options)._native, callback))


def select_pairs(scene, vertices, faces, options: typing.Optional[Options] = None):
    """The camera pairs that refine() would use: a Selection."""
    vertices, faces = numpy.asarray(vertices), numpy.asarray(faces)
    return Selection(**_burin.select_pairs(scene, vertices, faces, as_options(options)._native))

"""Refinement of triangle meshes against calibrated photographs.

    scene = burin.load_scene("SCENE")
    vertices, faces = burin.read_mesh("init.ply")
    options = burin.Options()
    options.level.finest = 1
    result = burin.refine(scene, vertices, faces, options)
    burin.write_mesh("refined.ply", result.vertices, result.faces)

Conventions as in C++ (core/scene/camera.h): X_cam = R X + t, x right, y down, z forward; the first pixel's
centre is at (0.5, 0.5); lengths in the scene's unit unless a name says otherwise. Wrong input raises
InputError, a ValueError.
"""

from burin._burin import InputError, MemoryLimitError, Scene, read_mesh, strategies
from burin._energy import Energy
from burin._options import Options
from burin._refine import Refinement, Selection, check, load_scene, refine, select_pairs, write_mesh
from burin._start import Start, mesh

__all__ = [
    "Energy",
    "InputError",
    "MemoryLimitError",
    "Options",
    "Refinement",
    "Scene",
    "Selection",
    "Start",
    "check",
    "load_scene",
    "mesh",
    "read_mesh",
    "refine",
    "select_pairs",
    "strategies",
    "write_mesh",
]

"""burin.mesh against the program."""

import subprocess

import numpy
import pytest

import burin
from test_burin import PROGRAM


@pytest.fixture(autouse=True)
def with_cgal(scene):
    try:
        burin.mesh(scene, points="sparse", min_views=2, min_part_facets=1)
    except burin.InputError as error:
        if "without CGAL" not in str(error):
            raise
        pytest.skip(str(error))


@pytest.mark.parametrize("points", ["sparse", "dense"])
def test_mesh_is_the_program(folder, scene, tmp_path, points):
    subprocess.run([PROGRAM, "mesh", folder, "--output", tmp_path / "start.ply", "--points", points,
                    "--start.min_views", "2", "--start.min_part_facets", "10"],
                   check=True, capture_output=True)
    start = burin.mesh(scene, threads=1, points=points, min_views=2, min_part_facets=10)
    vertices, faces = burin.read_mesh(tmp_path / "start.ply")
    assert numpy.array_equal(start.faces, faces)
    assert numpy.array_equal(start.vertices, vertices)
    assert len(start.sights) == len(vertices) and start.sights.min() >= 2
    assert any("sparse points" in line for line in start.lines)
    assert len(burin.refine(scene, start.vertices, start.faces,
                            burin.Options({"level.min_side_px": 30, "solver.max_iterations": 1})).vertices)


def test_mesh_names_what_is_wrong(scene):
    with pytest.raises(burin.InputError, match="start.point: there is no such option"):
        burin.mesh(scene, point="sparse")
    with pytest.raises(burin.InputError, match="start.points"):
        burin.mesh(scene, points="none")
    with pytest.raises(burin.InputError, match="start.min_views"):
        burin.mesh(scene, points="sparse", min_views=100)
    bare = burin.Scene(["a", "b"], [scene.image(0), scene.image(1)], [scene.intrinsics(0)] * 2,
                       [scene.rotation(0), scene.rotation(1)], [scene.translation(0), scene.translation(1)])
    with pytest.raises(burin.InputError, match="no sparse points"):
        burin.mesh(bare)

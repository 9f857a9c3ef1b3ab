"""burin.Energy: derivatives by vertices and by cameras, against the energy itself."""

import threading

import numpy
import pytest
import scipy.sparse
import scipy.sparse.linalg
import scipy.spatial.transform

import burin


def test_threads_may_share_an_energy(scene, mesh):
    energy = burin.Energy(scene, *mesh, level=1)
    points = [numpy.random.default_rng(k).normal(0, 0.5, energy.unknowns) for k in range(4)]
    alone = [energy(x) for x in points]
    wrong = []

    def evaluate(k):
        for _ in range(20):
            value, gradient = energy(points[k])
            if value != alone[k][0] or (gradient != alone[k][1]).any():
                wrong.append(k)

    threads = [threading.Thread(target=evaluate, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


@pytest.mark.parametrize("motion", ["normal", "free"])
def test_the_gradient_is_that_of_the_energy(scene, mesh, motion):
    options = burin.Options({"motion.type": motion, "photo.double_precision": True})
    energy = burin.Energy(scene, *mesh, options=options, level=1)
    assert energy.unknowns == len(energy.vertex_of_unknown)
    random = numpy.random.default_rng(1)
    x = 0.1 * random.standard_normal(energy.unknowns)
    value, gradient = energy(x)
    assert value == pytest.approx(energy.terms(x)["total"])
    for _ in range(5):
        direction = random.standard_normal(energy.unknowns)
        step = 1e-5
        slope = (energy(x + step * direction)[0] - energy(x - step * direction)[0]) / (2 * step)
        assert slope == pytest.approx(gradient @ direction, rel=2e-3)
    with pytest.raises(burin.InputError, match="entries"):
        energy(x[1:])


def test_the_gauss_newton_matrix_is_symmetric_and_not_negative(scene, mesh):
    energy = burin.Energy(scene, *mesh, level=1)
    value, gradient, parts = energy.gauss_newton(energy.zero())
    assert value == pytest.approx(energy(energy.zero())[0])
    assert numpy.allclose(gradient, energy(energy.zero())[1])
    matrix = scipy.sparse.csr_matrix(parts, shape=(energy.unknowns, energy.unknowns))
    assert abs(matrix - matrix.T).max() < 1e-9 * abs(matrix).max()
    x = numpy.random.default_rng(2).standard_normal(energy.unknowns)
    assert x @ (matrix @ x) > 0


@pytest.mark.parametrize("motion", ["normal", "free"])
def test_derivatives_by_cameras_are_those_of_the_energy(scene, mesh, motion):
    options = burin.Options({"motion.type": motion, "photo.double_precision": True})
    energy = burin.Energy(scene, *mesh, options=options, level=1, cameras=True)
    surface = burin.Energy(scene, *mesh, options=options, level=1)
    vertices, views = energy.vertex_of_unknown, energy.camera_of_unknown
    first = surface.unknowns
    assert energy.unknowns == first + 6 * len(scene)
    assert list(views[first:]) == [view for view in range(len(scene)) for _ in range(6)]
    assert (vertices[first:] == -1).all() and (views[:first] == -1).all()
    zero = energy.zero()
    assert energy(zero)[0] == pytest.approx(surface(surface.zero())[0], rel=1e-12)
    assert numpy.allclose(energy(zero)[1][:first], surface(surface.zero())[1], rtol=1e-9)
    random = numpy.random.default_rng(3)
    unit = numpy.ones(energy.unknowns)  # a pixel of each kind
    for view in range(len(scene)):
        begin = first + 6 * view
        unit[begin:begin + 3] = 1 / scene.intrinsics(view)[0, 0]
    # At cameras that have moved too: turned by some pixels, where d Exp(w) is not dw.
    for point in (zero, unit * 0.3 * random.standard_normal(energy.unknowns)):
        value, gradient = energy(point)
        for k in [*range(first, energy.unknowns), None]:
            direction = unit * (random.standard_normal(energy.unknowns) if k is None
                                else numpy.arange(energy.unknowns) == k)
            step = 1e-5
            slope = (energy(point + step * direction)[0] - energy(point - step * direction)[0]) / (2 * step)
            assert slope == pytest.approx(gradient @ direction, rel=1e-4, abs=1e-6 * numpy.abs(unit * gradient).max())


def test_a_camera_is_where_its_entries_say(scene, mesh):
    energy = burin.Energy(scene, *mesh, level=1, cameras=True)
    x = energy.zero()
    rotations, translations = energy.cameras_at(x)
    for view in range(len(scene)):
        assert numpy.allclose(rotations[view], scene.rotation(view))
        assert numpy.allclose(translations[view], scene.translation(view))
    first = int(numpy.flatnonzero(energy.camera_of_unknown == 1)[0])
    turn, move = numpy.array([0.02, -0.5, 0.3]), numpy.array([1.0, -2.0, 3.0])
    x[first:first + 3], x[first + 3:first + 6] = turn, move
    moved, shifted = energy.cameras_at(x)
    expected = scipy.spatial.transform.Rotation.from_rotvec(turn).as_matrix() @ scene.rotation(1)
    assert numpy.allclose(moved[1], expected)
    centre = -scene.rotation(1).T @ scene.translation(1) + energy.footprint * move
    assert numpy.allclose(shifted[1], -expected @ centre)
    assert numpy.array_equal(moved[0], rotations[0]) and numpy.array_equal(shifted[0], translations[0])


def test_the_matrix_couples_surface_and_cameras(scene, mesh):
    options = burin.Options({"photo.double_precision": True})
    energy = burin.Energy(scene, *mesh, options=options, level=1, cameras=True)
    x = energy.zero()
    first = int(numpy.flatnonzero(energy.camera_of_unknown >= 0)[0])
    x[first:first + 3] = 1e-3, -2e-3, 1e-3
    value, gradient, parts = energy.gauss_newton(x)
    assert value == pytest.approx(energy(x)[0])
    assert numpy.allclose(gradient, energy(x)[1])
    matrix = scipy.sparse.csr_matrix(parts, shape=(energy.unknowns, energy.unknowns))
    scale = scipy.sparse.diags(1 / numpy.sqrt(matrix.diagonal()))
    scaled = (scale @ matrix @ scale).toarray()
    assert numpy.abs(scaled - scaled.T).max() < 1e-9
    assert numpy.abs(scaled[:first, first:]).max() > 0.01
    assert numpy.linalg.eigvalsh(scaled).min() > -1e-9
    # A damped step in both lowers the energy more than the same in the surface alone.
    start, gradient, parts = energy.gauss_newton(energy.zero())
    matrix = scipy.sparse.csr_matrix(parts, shape=(energy.unknowns, energy.unknowns))
    damped = (matrix + 1e-2 * scipy.sparse.diags(matrix.diagonal())).tocsc()
    both = energy(scipy.sparse.linalg.spsolve(damped, -gradient))[0]
    alone = energy.zero()
    alone[:first] = scipy.sparse.linalg.spsolve(damped[:first, :first], -gradient[:first])
    assert both < energy(alone)[0] < start
    solution = energy.solve("lm_pcg")
    assert solution["energy"] == pytest.approx(energy(solution["x"])[0], rel=1e-5)
    assert numpy.abs(solution["x"][first:]).max() > 0


def test_vertices_and_masks(scene, mesh):
    energy = burin.Energy(scene, *mesh, level=1)
    assert numpy.allclose(energy.vertices_at(energy.zero()), mesh[0])
    x = energy.zero()
    x[7] = 2
    moved = energy.vertices_at(x) - mesh[0]
    vertex = energy.vertex_of_unknown[7]
    assert numpy.allclose(moved[vertex], 2 * energy.footprint * energy.normals[vertex])
    assert numpy.count_nonzero(numpy.abs(moved).max(axis=1) > 1e-12) == 1
    taps = energy.kept_taps(0)
    assert taps.shape == (60, 80)
    assert taps.max() == 25 and taps.min() >= 0


def test_a_second_order_step_of_ones_own_lowers_the_energy(scene, mesh):
    energy = burin.Energy(scene, *mesh, level=1)
    value, gradient, parts = energy.gauss_newton(energy.zero())
    matrix = scipy.sparse.csr_matrix(parts, shape=(energy.unknowns, energy.unknowns))
    damped = matrix + 1e-2 * scipy.sparse.diags(matrix.diagonal())
    step = scipy.sparse.linalg.spsolve(damped.tocsc(), -gradient)
    assert energy(step)[0] < 0.95 * value

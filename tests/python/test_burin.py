"""The Python package against the program and against itself."""

import copy
import json
import os
import pathlib
import pickle
import shutil
import signal
import struct
import subprocess
import sys
import threading
import time
import warnings

import numpy
import pytest

import burin

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "python" / "examples"
PROGRAM = os.environ["BURIN_PROGRAM"]


SMALL = {"level.min_side_px": 30, "solver.max_iterations": 4}


def test_load_scene_warns_of_unlikely_cameras(folder, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        burin.load_scene(folder)
    low = tmp_path / "low"
    shutil.copytree(folder, low)
    cameras = next(low.rglob("cameras.bin"))
    data = bytearray(cameras.read_bytes())  # a count, then id, model, width, height, fx, fy, cx, cy
    assert struct.unpack_from("<i", data, 12)[0] == 1  # PINHOLE
    struct.pack_into("<d", data, 56, 0.0)
    cameras.write_bytes(data)
    with pytest.warns(UserWarning, match="principal point"):
        burin.load_scene(low)


def test_options_are_those_of_the_command_line():
    options = burin.Options()
    printed = subprocess.run([PROGRAM, "refine", "--print-config"], check=True, capture_output=True,
                             text=True).stdout
    values = {}
    group = ""
    for line in printed.splitlines():
        if line.startswith("["):
            group = line.strip("[]")
        elif "=" in line and not line.startswith("#"):
            name, value = line.split("=", 1)
            values[f"{group}.{name.strip()}"] = json.loads(value.split(" #")[0])
    assert values == options.to_dict()
    assert "Rounds of freezing" in options.help("level.rounds")


def test_options_check_names_types_and_ranges():
    options = burin.Options({"level.rounds": 3})
    assert options.level.rounds == 3
    options.smooth.weight = 1
    assert options["smooth.weight"] == 1.0
    assert burin.Options(options.to_dict()) == options != burin.Options()
    assert copy.deepcopy(options) == options == pickle.loads(pickle.dumps(options))
    assert repr(options) == "Options({'smooth.weight': 1.0, 'level.rounds': 3})"
    with pytest.raises(burin.InputError, match=r"level.rounds = 0: must be"):
        options.level.rounds = 0
    with pytest.raises(TypeError, match="level.rounds: must be a whole number"):
        options.level.rounds = "3"
    with pytest.raises(burin.InputError, match="one of"):
        options.mask.mode = "nothing"
    with pytest.raises(TypeError):
        options.guard.levels = 1
    for wrong in (None, [1], (), object()):
        with pytest.raises(TypeError, match="level.rounds: must be a whole number"):
            options["level.rounds"] = wrong
    with pytest.raises(AttributeError, match="level.turns"):
        options.level.turns = 3
    with pytest.raises(AttributeError, match="turns"):
        options.turns = 3
    with pytest.raises(KeyError):
        options["level.turns"]
    assert options.level.rounds == 3
    assert "rounds" in dir(options.level)


def test_refine_is_the_program(folder, scene, mesh, tmp_path):
    subprocess.run([PROGRAM, "refine", folder, "--mesh", folder / "init.ply", "--output", tmp_path,
                    "--level.min_side_px", "30", "--solver.max_iterations", "4"],
                   check=True, capture_output=True)
    events = []
    result = burin.refine(scene, *mesh, burin.Options(SMALL), callback=events.append)
    vertices, faces = burin.read_mesh(tmp_path / "refined.ply")
    assert numpy.array_equal(result.faces, faces)
    assert numpy.array_equal(result.vertices.astype(numpy.float32), vertices.astype(numpy.float32))
    summary = json.loads((tmp_path / "summary.json").read_text())
    for key in ("pairs", "options", "iterations"):
        assert result.summary[key] == summary[key]
    assert len(events) >= summary["iterations"] > 0 and events[-1]["done"] <= 1
    assert set(result.quality) == {"pairs", "zncc", "displacement_px", "sd_px", "cosine", "step_px"}
    assert len(result.quality["zncc"]) == len(vertices)
    for key, of in (("names", lambda k: scene.names[k]), ("rotations", scene.rotation), ("intrinsics", scene.intrinsics)):
        assert [numpy.array_equal(value, of(k)) for k, value in enumerate(result.cameras[key])] == [True] * len(scene)
    burin.write_mesh(tmp_path / "again.ply", result.vertices, result.faces)
    assert numpy.array_equal(burin.read_mesh(tmp_path / "again.ply")[1], faces)


def test_the_whole_mesh_stands_beside_the_trimmed_one(scene, mesh):
    vertices, faces = mesh
    # A second sheet, hidden behind the first.
    middle = faces[numpy.abs(vertices[faces][:, :, :2]).max((1, 2)) < 0.6]
    faces = numpy.concatenate([faces, middle + len(vertices)])
    vertices = numpy.concatenate([vertices, vertices - [0, 0, 0.3]])
    options = {**SMALL, "mesh.orient": "off"}
    whole = burin.refine(scene, vertices, faces, burin.Options({**options, "surface.trim": "none"}))
    assert whole.whole is None and whole.summary["trim"] is None
    trimmed = burin.refine(scene, vertices, faces, burin.Options({**options, "surface.trim": "unseen"}))
    assert numpy.array_equal(trimmed.whole["vertices"], whole.vertices)
    assert numpy.array_equal(trimmed.whole["faces"], whole.faces)
    for name, values in whole.quality.items():
        assert numpy.array_equal(trimmed.whole["quality"][name], values, equal_nan=True)
    kept = numpy.array(trimmed.whole["cut"]) == "none"
    assert 0 < kept.sum() == len(trimmed.faces) < len(whole.faces)
    # The facets that are left, in their order.
    left = numpy.unique(whole.faces[kept])
    assert numpy.array_equal(left[trimmed.faces], whole.faces[kept])


def test_what_cannot_be_right_is_handed_back(tmp_path):
    subprocess.run(
        [PROGRAM, "synth", "--output", tmp_path, "--text", "--synth.width", "320", "--synth.height", "240",
         "--synth.samples_per_axis", "1", "--synth.truth_point_count", "100"],
        check=True, capture_output=True)
    vertices, faces = burin.read_mesh(tmp_path / "init.ply")
    verdict = burin.check(burin.load_scene(tmp_path), vertices, faces)
    assert verdict["verdict"] == "good" and verdict["E"] > 0.8 and len(verdict["views"]) == 7
    cameras = tmp_path / "sparse" / "cameras.txt"
    cameras.write_text(cameras.read_text().replace("162.24 118.56", "0 0"))
    wrong = burin.load_scene(tmp_path)
    assert burin.check(wrong, vertices, faces)["verdict"] == "wrong"
    with pytest.warns(RuntimeWarning, match="this cannot be right: .*the input mesh is the result"):
        result = burin.refine(wrong, vertices, faces, SMALL)
    assert numpy.array_equal(result.vertices, vertices)
    assert result.summary["verdict"]["verdict"] == "wrong"


def test_a_scene_from_arrays_is_the_scene(scene, mesh):
    views = range(len(scene))
    same = burin.Scene(scene.names, [scene.image(v) for v in views],
                       [scene.intrinsics(v) for v in views], [scene.rotation(v) for v in views],
                       [scene.translation(v) for v in views])
    assert burin.select_pairs(same, *mesh).pairs == burin.select_pairs(scene, *mesh).pairs
    with pytest.raises(burin.InputError, match="same centre"):
        burin.Scene(["a", "b"], [scene.image(0)] * 2, [scene.intrinsics(0)] * 2,
                    [scene.rotation(0)] * 2, [scene.translation(0)] * 2)


def test_the_callback_stops_a_run_and_its_exceptions_come_through(scene, mesh):
    events = []

    def stop(event):
        events.append(event)
        return len(events) < 3

    burin.refine(scene, *mesh, burin.Options(SMALL), callback=stop)
    assert len(events) == 3

    def fail(event):
        raise RuntimeError("mine")

    with pytest.raises(RuntimeError, match="mine"):
        burin.refine(scene, *mesh, burin.Options(SMALL), callback=fail)


def test_other_threads_run_meanwhile(scene, mesh):
    ticks = []
    done = threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.002)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.monotonic()
    burin.refine(scene, *mesh, burin.Options(SMALL))
    end = time.monotonic()
    done.set()
    thread.join()
    assert sum(begin < t < end for t in ticks) > 5


def test_control_c_ends_a_run(folder):
    script = ("import burin, sys\n"
              "scene = burin.load_scene(sys.argv[1])\n"
              "options = burin.Options({'level.rounds': 1000, 'solver.function_tolerance': 0.0})\n"
              "try:\n"
              "    burin.refine(scene, *burin.read_mesh(sys.argv[1] + '/init.ply'), options,\n"
              "                 callback=lambda event: print(event['iteration'], flush=True))\n"
              "except KeyboardInterrupt:\n"
              "    print('interrupted')\n")
    child = subprocess.Popen([sys.executable, "-c", script, str(folder)], stdout=subprocess.PIPE,
                             text=True)
    child.stdout.readline()
    child.send_signal(signal.SIGINT)
    out, _ = child.communicate(timeout=60)
    assert out.endswith("interrupted\n")


def test_wrong_arrays_are_refused(scene, mesh):
    vertices, faces = mesh
    for wrong_vertices, wrong_faces, message in (
            (vertices[:, :2], faces, r"shape \(V, 3\)"),
            (vertices, faces.ravel(), r"shape \(F, 3\)"),
            (vertices, faces + len(vertices), "names vertex"),
            (vertices * numpy.nan, faces, "finite"),
            (vertices + 1e6, faces, "seen|views")):
        with pytest.raises(burin.InputError, match=message):
            burin.refine(scene, wrong_vertices, wrong_faces)
    for vertex_type, face_type, message in (
            (complex, int, "vertices: must be real numbers"), (float, float, "faces: must be whole"),
            (bool, int, "vertices: must be real"), (float, complex, "faces: must be whole")):
        with pytest.raises(burin.InputError, match=message):
            burin.refine(scene, vertices.astype(vertex_type), faces.astype(face_type))
    for wrong in (faces.astype(numpy.int64) + 2**32, faces.astype(numpy.int64) - 1):
        with pytest.raises(burin.InputError, match="names vertex"):
            burin.select_pairs(scene, vertices, wrong)
    assert burin.select_pairs(scene, vertices.tolist(), faces.astype(numpy.uint16), {}).pairs
    for pairs, message in (([(0, 0)], "one view twice"), ([(0, 1), (0, 1)], "appears twice")):
        with pytest.raises(burin.InputError, match=message):
            burin.Energy(scene, vertices, faces, pairs=pairs)
    for level, message in ((-1, "level = -1: must be in"), (2000, "must be in"),
                           (6, "smaller than the window")):
        with pytest.raises(burin.InputError, match=message):
            burin.Energy(scene, vertices, faces, level=level)
    with pytest.raises(burin.InputError, match="no view 9"):
        burin.Energy(scene, vertices, faces, pairs=[(0, 9)])
    with pytest.raises(burin.InputError, match="no such file"):
        burin.load_scene("/nowhere")


def test_wrong_scenes_are_refused(scene):
    def arrays():
        views = range(len(scene))
        return {"names": list(scene.names), "images": [scene.image(v).astype(float) for v in views],
                "intrinsics": [scene.intrinsics(v) for v in views],
                "rotations": [scene.rotation(v) for v in views],
                "translations": [scene.translation(v) for v in views]}

    assert len(burin.Scene(**arrays())) == len(scene)
    for field, value, message in (
            ("images", numpy.full((4, 4), numpy.nan), "finite"), ("images", numpy.ones(4), "shape"),
            ("images", numpy.full((4, 4), 1e38), "within 1e6"),
            ("images", numpy.ones((4, 4), complex), "real numbers"),
            ("names", scene.names[0], "appears twice"), ("names", "", "no name of a file"),
            ("names", "a\nb.png", "control character"),
            ("translations", numpy.full(3, 1e300), "translation = 1e.300")):
        wrong = arrays()
        wrong[field][1] = value
        with pytest.raises(burin.InputError, match=message):
            burin.Scene(**wrong)


def test_runs_at_once_end_as_one_after_the_other(scene, mesh):
    counts = [1, 2, 4, 0]
    alone = burin.refine(scene, *mesh, burin.Options({**SMALL, "run.threads": 1}))
    results = {}

    def refine(count):
        results[count] = burin.refine(scene, *mesh,
                                      burin.Options({**SMALL, "run.threads": count}))

    for at_once in (counts[:2], counts):
        results.clear()
        threads = [threading.Thread(target=refine, args=(count,)) for count in at_once]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for count in at_once:
            assert numpy.array_equal(results[count].vertices, alone.vertices)
            assert numpy.array_equal(results[count].faces, alone.faces)
            if count > 0:
                assert results[count].summary["threads"] == count


def test_the_example_reproduces_burins_lbfgs(folder, capsys):
    sys.path.insert(0, str(EXAMPLES))
    import own_optimiser

    start, results = own_optimiser.main(folder, folder / "init.ply", level=1)
    own = results["burin lbfgs"]
    theirs = results["scipy L-BFGS-B"]
    assert own[1] < 0.8 * start
    assert theirs[1] == pytest.approx(own[1], rel=0.01)
    assert "px RMS from burin lbfgs" in capsys.readouterr().out


def test_the_notebook_runs(folder):
    out = subprocess.run(
        [sys.executable, EXAMPLES / "ablation.py", folder, folder / "init.ply", folder / "truth.ply"],
        check=True, capture_output=True, text=True).stdout
    lines = {line[:20].strip(): float(line[20:].split()[0]) for line in out.splitlines()}
    assert lines["defaults"] < lines["before"]
    assert len(lines) == 6


def test_the_stub_names_what_the_module_has():
    import ast

    from burin import _burin

    tree = ast.parse((EXAMPLES.parent / "burin" / "_burin.pyi").read_text())
    named = {}
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            members = {f.name for f in node.body if isinstance(f, ast.FunctionDef)}
            named[node.name] = {m for m in members if not m.startswith("_")}
        elif isinstance(node, ast.FunctionDef):
            named[node.name] = None
    assert set(named) == {name for name in dir(_burin) if not name.startswith("_")}
    for name in ("Options", "Scene", "Energy"):
        there = {m for m in dir(getattr(_burin, name)) if not m.startswith("_")}
        assert named[name] == there

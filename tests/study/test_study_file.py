"""Study files: axes become variants, and every fault is one line before any job starts."""

import subprocess
import tomllib
from pathlib import Path

import pytest
from conftest import ROOT, TINY, burin_program, study_command, write
from study.burin_program import Burin
from study.errors import StudyError
from study.study_file import read_study
from study.variants import axis_values, combined

SCENE = 'title = "t"\n[scenes.a.synth]\nviews = 4\n'
AXIS = "[axes]\nsmooth.weight = [15, 30]\n"


def test_ranges() -> None:
    assert axis_values({"from": 1, "to": 8, "factor": 2}) == [1, 2, 4, 8]
    assert axis_values({"from": 0, "to": 1, "step": 0.25}) == [0, 0.25, 0.5, 0.75, 1]
    assert axis_values({"from": 0.1, "to": 0.3, "step": 0.1}) == pytest.approx([0.1, 0.2, 0.3])
    assert axis_values({"from": 3, "to": 1, "step": -1}) == [3, 2, 1]


def test_product_zip_and_names() -> None:
    axes = {"a.b": [1, 2], "c.d": [True, False]}
    labels = [label for label, _, _ in combined(axes, "product", [])]
    assert labels == ["a.b=1 c.d=true", "a.b=1 c.d=false", "a.b=2 c.d=true", "a.b=2 c.d=false"]
    assert [label for label, _, _ in combined(axes, "zip", ["x"])] == ["x a.b=1 c.d=true",
                                                                      "x a.b=2 c.d=false"]
    assert [label for label, _, _ in combined({}, "product", ["x", "y"])] == ["x", "y"]


def test_a_variant_overrides_the_base_and_an_axis_both(tmp_path: Path) -> None:
    text = SCENE + AXIS + "[options]\nsmooth.weight = 1\nphoto.window = 7\n[variants]\nv.photo.window = 9\n"
    study = read_study(write(tmp_path, text), Burin(Path(burin_program())))
    assert list(study.variants) == ["v smooth.weight=15", "v smooth.weight=30"]
    variant = study.variants["v smooth.weight=30"]
    assert variant.options == {"smooth.weight": 30, "photo.window": 9}
    assert variant.effective["smooth.type"] == "umbrella"


@pytest.mark.parametrize(("text", "field", "reason"), [
    ("title = \n", "", "line 1"),
    (SCENE.replace("title", "titel") + AXIS, "titel", "did you mean title?"),
    (AXIS + SCENE.replace('title = "t"\n', ""), "title", "missing"),
    ('title = "t"\n' + AXIS, "scenes", "has none"),
    (SCENE, "variants", "there are none"),
    (SCENE + "[axes]\nsmooth.weight = []\n", "axes.smooth.weight", "has no values"),
    (SCENE + "[axes]\nsmooth.weight = 3\n", "axes.smooth.weight", "must be a list"),
    (SCENE + "[axes]\nsmooth.weight = [1, 1]\n", "axes.smooth.weight", "twice"),
    (SCENE + "[axes]\nsmooth.weight = {from = 1, to = 8, step = 0}\n", "axes.smooth.weight", "lead from"),
    (SCENE + "[axes]\nsmooth.weight = {from = 1, to = 8}\n", "axes.smooth.weight", "step and factor"),
    (SCENE + "[axes]\nsmooth.weight = [[1]]\n", "axes.smooth.weight", "must be true, false"),
    (SCENE + "[axes]\nsmooth.wieght = [1]\n", "axes.smooth.wieght", "did you mean smooth.weight?"),
    (SCENE + "[axes]\nsmooth.weight = [1, -1]\n", "axes.smooth.weight", "must be a number in [0, 1e+09]"),
    ('combine = "zip"\n' + SCENE + "[axes]\nsmooth.weight = [1, 2]\nphoto.window = [3]\n", "axes",
     "one length"),
    ('combine = "all"\n' + SCENE + AXIS, "combine", "product or zip"),
    (SCENE + AXIS + "[options]\nsolver.type = 'lgfbs'\n", "options.solver.type", "must be one of"),
    (SCENE + AXIS + "[options]\nphoto.window = 4\n", "options.photo.window", "must be odd"),
    (SCENE + "[variants]\nv.pairs.method = 'file'\n", "variant v", "pairs.file"),
    (SCENE + "[variants]\n'a/b'.smooth.weight = 1\n", "variants.a/b", "a name is"),
    (SCENE + "seed = 3\n" + AXIS, "scenes.a.synth.seed", "set by seeds"),
    (SCENE.replace("views = 4", "views = 4.5") + AXIS, "scenes.a.synth.views", "whole number"),
    ("seeds = [1, 1]\n" + SCENE + AXIS, "seeds", "different whole numbers"),
    ("seeds = [-1]\n" + SCENE + AXIS, "seeds", "whole number in"),
    (SCENE + "[scenes.b]\nfolder = 'nowhere'\n" + AXIS, "scenes.b.folder", "no such folder"),
    (SCENE + "[scenes.b]\nmesh = 'm.ply'\n" + AXIS, "scenes.b.mesh", "with a folder"),
    (SCENE + "[scenes.b]\ncameras = 'm'\n" + AXIS, "scenes.b.cameras", "with a folder"),
    (SCENE + AXIS + "[evaluate]\ntau = '5,x'\n", "evaluate.tau", "refuses"),
    (SCENE + AXIS + "[evaluate]\njson = true\n", "evaluate.json", "not an option"),
])
def test_faults_are_one_line_with_file_field_and_reason(
        tmp_path: Path, text: str, field: str, reason: str) -> None:
    file = write(tmp_path, text)
    output = tmp_path / "results"
    done = subprocess.run(study_command("run", file, output), capture_output=True, text=True, check=False)
    assert done.returncode == 2, done
    assert done.stderr.count("\n") == 1, done.stderr
    place = f"study: error: {file}: {field}: " if field else f"study: error: {file}: "
    assert done.stderr.startswith(place), done.stderr
    assert reason in done.stderr
    assert not output.exists()


def test_a_missing_file_and_half_a_scene_are_refused(tmp_path: Path) -> None:
    for arguments, reason in (([tmp_path / "none.toml", tmp_path / "o"], "cannot be read"),
                              ([write(tmp_path, TINY), tmp_path / "o", "--scene", "x"], "--mesh")):
        done = subprocess.run(study_command("plan", *arguments), capture_output=True, text=True,
                              check=False)
        assert (done.returncode, done.stderr.count("\n")) == (2, 1)
        assert reason in done.stderr


def test_a_folder_given_beside_the_study_is_a_scene(tmp_path: Path) -> None:
    folder = tmp_path / "fountain"
    folder.mkdir()
    for name in ("m.ply", "t.ply"):
        (folder / name).touch()
    given = {"folder": folder, "mesh": folder / "m.ply", "truth": folder / "t.ply",
             "evaluate": {"tau": "5,10,20", "unit": 0.001, "align": "rigid"}}
    burin = Burin(Path(burin_program()))
    for file in sorted((ROOT / "apps/study/studies").glob("*.toml")):
        study = read_study(file, burin, given)
        assert list(study.scenes)[-1] == "fountain"
        assert study.scenes["fountain"].evaluate == {"tau": "5,10,20", "unit": 0.001, "align": "rigid"}
        assert len(study.scenes) > 1
        assert len(study.variants) > 1


def test_the_camera_study_has_two_shapes_two_rigs_and_six_noises() -> None:
    file = ROOT / "apps/study/studies/cameras.toml"
    scenes = [scene["synth"] for scene in tomllib.loads(file.read_text(encoding="utf-8"))["scenes"].values()]
    found = {(scene["scene"], scene["rig"], scene["pose_noise_px"]) for scene in scenes}
    assert len(scenes) == len(found) == 24
    assert {noise for _, _, noise in found} == {0, 0.3, 0.6, 1, 2, 4}
    assert {(shape, rig) for shape, rig, _ in found} == {
        (shape, rig) for shape in ("occluders", "boulder") for rig in ("even", "uneven")}


def test_the_paper_ablation_has_the_columns_of_its_table() -> None:
    file = ROOT / "apps/study/studies/paper_ablation.toml"
    variants = tomllib.loads(file.read_text(encoding="utf-8"))["variants"]
    assert list(variants) == ["PC", "SC", "OC", "SPC", "OPC", "OSC", "OSP", "OSPC", "Proposed"]
    assert all(variants[name]["pairs"]["terms"] == name for name in list(variants)[:-1])
    assert variants["Proposed"] == {"pairs": {"terms": "OSPC"}, "mask": {"mode": "paper"}}

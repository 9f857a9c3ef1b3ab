"""Runs the commands of docs/formats/*.md on one small scene in every format: they give the same mesh."""

import json
import pathlib
import re
import shlex
import shutil
import subprocess

import burin
import numpy
import pytest

from test_docs import DOCS, PROGRAM, blocks

PAGES = sorted(path.stem for path in (DOCS / "formats").glob("*.md"))
QUICK = ["--level.min_side_px", "30", "--solver.max_iterations", "2"]


def text(array):
    return "\n".join(" ".join(repr(float(x)) for x in row) for row in numpy.atleast_2d(array)) + "\n"


class Given:
    """The scene's cameras in the conventions of the formats."""

    def __init__(self, folder):
        self.photographs = folder / "SCENE" / "images"
        scene = burin.load_scene(folder / "SCENE")
        self.names = scene.names
        views = range(len(scene))
        self.k = [scene.intrinsics(v) for v in views]
        self.k_whole = [k - numpy.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]]) for k in self.k]
        self.r = [scene.rotation(v) for v in views]
        self.t = [scene.translation(v) for v in views]
        self.c = [-r.T @ t for r, t in zip(self.r, self.t)]
        self.size = scene.image(0).shape[1::-1]

    def copy_photographs(self, folder, names=None):
        folder.mkdir(parents=True, exist_ok=True)
        for name, new in zip(self.names, names or self.names):
            shutil.copy(self.photographs / name, folder / new)

    def __iter__(self):
        return iter(zip(self.names, self.k, self.k_whole, self.r, self.t, self.c))


def colmap(given, folder):
    shutil.copytree(given.photographs.parent, folder / "WORKSPACE")


def openmvs(given, folder):
    subprocess.run([PROGRAM, "convert", given.photographs.parent, folder / "scene.mvs", "--mesh",
                    folder / "init.ply"], check=True, capture_output=True)


def openmvg(given, folder):
    given.copy_photographs(folder / "photographs")
    root = {"sfm_data_version": "0.3", "root_path": "photographs", "views": [], "intrinsics": [],
            "extrinsics": [], "structure": []}
    for key, (name, _, k, r, _, c) in enumerate(given):
        root["views"].append({"key": key, "value": {"ptr_wrapper": {"data": {
            "filename": name, "id_intrinsic": key, "id_pose": key}}}})
        root["intrinsics"].append({"key": key, "value": {
            "polymorphic_id": 2147483649, "polymorphic_name": "pinhole", "ptr_wrapper": {"data": {
                "width": given.size[0], "height": given.size[1], "focal_length": k[0, 0],
                "principal_point": [k[0, 2], k[1, 2]]}}}})
        root["extrinsics"].append({"key": key,
                                   "value": {"rotation": r.tolist(), "center": c.tolist()}})
    (folder / "sfm_data.json").write_text(json.dumps(root))


def transforms(given, folder):
    given.copy_photographs(folder / "FOLDER/images")
    root = {"w": given.size[0], "h": given.size[1], "camera_model": "OPENCV", "frames": []}
    for name, k, _, r, _, c in given:
        pose = numpy.r_[numpy.c_[r.T @ numpy.diag([1.0, -1.0, -1.0]), c], [[0, 0, 0, 1]]]
        root["frames"].append({"file_path": f"images/{name}", "transform_matrix": pose.tolist(),
                               "fl_x": k[0, 0], "fl_y": k[1, 1], "cx": k[0, 2], "cy": k[1, 2]})
    (folder / "FOLDER/transforms.json").write_text(json.dumps(root))


def opensfm(given, folder):
    given.copy_photographs(folder / "FOLDER/images")
    side = max(given.size)
    root = {"cameras": {}, "shots": {}, "points": {}}
    for name, k, _, r, t, _ in given:
        half = numpy.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / 2
        sine = numpy.linalg.norm(half)
        turn = half / sine * numpy.arctan2(sine, (numpy.trace(r) - 1) / 2)
        root["cameras"][name] = {
            "projection_type": "brown", "width": given.size[0], "height": given.size[1],
            "focal_x": k[0, 0] / side, "focal_y": k[1, 1] / side,
            "c_x": (k[0, 2] - given.size[0] / 2) / side, "c_y": (k[1, 2] - given.size[1] / 2) / side}
        root["shots"][name] = {"camera": name, "rotation": turn.tolist(), "translation": t.tolist()}
    (folder / "FOLDER/reconstruction.json").write_text(json.dumps([root]))


def meshroom(given, folder):
    given.copy_photographs(folder / "FOLDER/images")
    root = {"version": ["1", "2", "6"], "views": [], "intrinsics": [], "poses": []}
    for key, (name, _, k, r, _, c) in enumerate(given):
        key = str(key)
        root["views"].append({"viewId": key, "poseId": key, "intrinsicId": key, "path": f"/there/{name}"})
        root["intrinsics"].append({
            "intrinsicId": key, "type": "pinhole", "width": str(given.size[0]),
            "height": str(given.size[1]), "sensorWidth": str(given.size[0]),
            "focalLength": repr(float(k[0, 0])), "pixelRatio": repr(float(k[1, 1] / k[0, 0])),
            "principalPoint": [repr(float(k[0, 2] - given.size[0] / 2)),
                               repr(float(k[1, 2] - given.size[1] / 2))]})
        root["poses"].append({"poseId": key, "pose": {"transform": {
            "rotation": [repr(float(x)) for x in r.T.flat], "center": [repr(float(x)) for x in c]}}})
    (folder / "FOLDER/cameras.sfm").write_text(json.dumps(root))


def metashape(given, folder):
    given.copy_photographs(folder / "FOLDER/images")
    size = f'<resolution width="{given.size[0]}" height="{given.size[1]}"/>'
    sensors, cameras = "", ""
    for key, (name, k, _, r, _, c) in enumerate(given):
        middle = k[:2, 2] - numpy.array(given.size) / 2
        sensors += (f'<sensor id="{key}" type="frame"><calibration>{size}<f>{k[1, 1]!r}</f>'
                    f'<b1>{k[0, 0] - k[1, 1]!r}</b1><cx>{middle[0]!r}</cx><cy>{middle[1]!r}</cy>'
                    "</calibration></sensor>\n")
        pose = text(numpy.r_[numpy.c_[r.T, c], [[0, 0, 0, 1]]])
        cameras += (f'<camera sensor_id="{key}" label="{pathlib.Path(name).stem}">'
                    f"<transform>{pose}</transform></camera>\n")
    (folder / "FOLDER/cameras.xml").write_text(
        f"<document><chunk><sensors>{sensors}</sensors><cameras>{cameras}</cameras></chunk></document>")


def nvm(given, folder):
    given.copy_photographs(folder)
    k = given.k_whole[0]
    lines = [f"NVM_V3 FixedK {k[0, 0]!r} {k[0, 2]!r} {k[1, 1]!r} {k[1, 2]!r} 0", "",
             str(len(given.names))]
    for name, _, _, r, _, c in given:
        w = 0.5 * numpy.sqrt(1 + numpy.trace(r))
        xyz = numpy.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / (4 * w)
        lines.append(" ".join([name, "1"] + [repr(float(x)) for x in [w, *xyz, *c]] + ["0", "0"]))
    (folder / "NAME.nvm").write_text("\n".join(lines + ["", "0", ""]))


def bundler(given, folder):
    # Two commands of the page, two forms. The principal point can't be said.
    for where, photographs in [("FOLDER/bundle", "FOLDER"), (".", "PHOTOGRAPHS")]:
        given.copy_photographs(folder / photographs)
        (folder / where).mkdir(parents=True, exist_ok=True)
        out = f"# Bundle file v0.3\n{len(given.names)} 0\n"
        for _, k, _, r, t, _ in given:
            turn = numpy.diag([1.0, -1.0, -1.0])
            out += f"{k[0, 0]!r} 0 0\n" + text(turn @ r) + text(turn @ t)
        (folder / where / "bundle.out").write_text(out)
        (folder / where / "list.txt").write_text("\n".join(given.names))
    (folder / "FOLDER/bundle/list.txt").rename(folder / "FOLDER/list.txt")


def middlebury(given, folder):
    given.copy_photographs(folder / "templeSparseRing")
    lines = [str(len(given.names))]
    for name, _, k, r, t, _ in given:
        lines.append(" ".join([name] + [repr(float(x)) for x in [*k.flat, *r.flat, *t]]))
    (folder / "templeSparseRing" / "temple_par.txt").write_text("\n".join(lines))


def strecha(given, folder):
    given.copy_photographs(folder / "PHOTOGRAPHS")
    (folder / "CAMERAS").mkdir()
    for name, _, k, r, _, c in given:
        (folder / "CAMERAS" / f"{name}.camera").write_text(
            text(k) + "0 0 0\n" + text(r.T) + text(c) + text(given.size))


def dtu(given, folder):
    numbers = [f"{v:03}" for v in range(1, 1 + len(given.names))]
    given.copy_photographs(folder / "RECTIFIED/scan1", [f"rect_{n}_3_r5000.png" for n in numbers])
    (folder / "CALIBRATION").mkdir()
    for n, (_, _, k, r, t, _) in zip(numbers, given):
        (folder / "CALIBRATION" / f"pos_{n}.txt").write_text(text(k @ numpy.c_[r, t]))


def mvsnet(given, folder):
    numbers = [f"{v:08}" for v in range(len(given.names))]
    given.copy_photographs(folder / "SCAN/images", [f"{n}.png" for n in numbers])
    (folder / "SCAN/cams").mkdir()
    for n, (_, k, _, r, t, _) in zip(numbers, given):
        (folder / "SCAN/cams" / f"{n}_cam.txt").write_text(
            "extrinsic\n" + text(numpy.r_[numpy.c_[r, t], [[0, 0, 0, 1]]]) + "\nintrinsic\n" +
            text(k) + "\n425 2.5\n")


def neus(given, folder):
    given.copy_photographs(folder / "FOLDER/image")
    arrays = {}
    for i, (_, _, k, r, t, _) in enumerate(given):
        arrays[f"world_mat_{i}"] = numpy.r_[k @ numpy.c_[r, t], [[0, 0, 0, 1]]]
        arrays[f"scale_mat_{i}"] = numpy.diag([2.0, 2.0, 2.0, 1.0])
    numpy.savez(folder / "FOLDER/cameras_sphere.npz", **arrays)


def llff(given, folder):
    # The principal point can't be said.
    given.copy_photographs(folder / "FOLDER/images")
    rows = []
    for _, k, _, r, _, c in given:
        pose = numpy.c_[r[1], r[0], -r[2], c, [given.size[1], given.size[0], k[0, 0]]]
        rows.append(numpy.r_[pose.ravel(), 1, 9])
    numpy.save(folder / "FOLDER/poses_bounds.npy", numpy.array(rows))


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    folder = tmp_path_factory.mktemp("given")
    subprocess.run([PROGRAM, "synth", "--output", folder / "SCENE", "--synth.width", "160",
                    "--synth.height", "120", "--synth.views", "4", "--synth.truth_point_count",
                    "1000"], check=True, capture_output=True)
    (folder / "SCENE/init.ply").rename(folder / "init.ply")
    subprocess.run([PROGRAM, "refine", "SCENE", "--mesh", "init.ply", "--output", "OUT"] + QUICK,
                   check=True, capture_output=True, cwd=folder)
    return folder


@pytest.mark.parametrize("page", PAGES)
def test_commands_of(page, given, tmp_path):
    shutil.copy(given / "init.ply", tmp_path)
    globals()[page](Given(given), tmp_path)
    commands = [shlex.split(line) for block in blocks(f"formats/{page}.md")
                for line in block.splitlines() if line.startswith("burin ")]
    assert commands
    for words in commands:
        is_refinement = words[1] == "refine"
        if is_refinement:
            shutil.rmtree(tmp_path / "OUT", ignore_errors=True)
        done = subprocess.run([PROGRAM] + words[1:] + (QUICK if is_refinement else []),
                              capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        refined = (tmp_path / "OUT/refined.ply").read_bytes()
        if page not in ("bundler", "llff"):
            assert refined == (given / "OUT/refined.ply").read_bytes()


def test_every_format_has_a_page_that_the_table_names():
    source = (DOCS.parent / "core/scene/formats/scene_loader.cc").read_text()
    names = re.findall(r'^    \{"(\w+)",', source, re.MULTILINE)
    assert sorted(name.lower() for name in names) == PAGES
    table = (DOCS / "formats.md").read_text()
    for name in names:
        assert f"| [{name}](formats/{name.lower()}.md) |" in table


def test_headers_named_in_the_pages_exist():
    for page in PAGES:
        text = (DOCS / "formats" / f"{page}.md").read_text()
        for name in re.findall(r"core/scene/formats/\w+\.h", text):
            assert (DOCS.parent / name).exists(), name
        for link in re.findall(r"\]\((\.\./[^)#]+)", text):
            assert (DOCS / "formats" / link).exists(), link

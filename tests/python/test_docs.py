"""Runs the code of docs/python.md and docs/formats.md as it is shown there."""

import os
import pathlib
import re
import shlex
import subprocess
import sys

import burin
import pytest

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
PROGRAM = os.environ["BURIN_PROGRAM"]


def blocks(page):
    """The indented blocks of a page, dedented."""
    text = (DOCS / page).read_text()
    for block in re.findall(r"(?:^(?:    .*)?\n)+", text, re.MULTILINE):
        lines = [line[4:] for line in block.splitlines()]
        if any(lines):
            yield "\n".join(lines).strip()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("docs")
    subprocess.run(
        [PROGRAM, "synth", "--output", path / "SCENE", "--synth.width", "160", "--synth.height",
         "120", "--synth.views", "4", "--synth.truth_point_count", "1000"],
        check=True, capture_output=True)
    (path / "SCENE" / "init.ply").rename(path / "init.ply")
    return path


def test_the_python_page(folder, monkeypatch):
    monkeypatch.chdir(folder)
    code = [block for block in blocks("python.md") if "burin." in block and "python3 -c" not in block]
    assert len(code) == 2
    names = {}
    exec(code[0].replace("callback=print", "callback=None"), names)
    assert pathlib.Path("refined.ply").exists()
    import scipy.optimize

    names["scipy"] = __import__("scipy")
    exec(code[1], names)
    assert names["mesh"].shape == names["vertices"].shape
    assert names["result"].fun < names["energy"](names["energy"].zero())[0]


def test_the_examples_named_in_the_python_page_exist():
    text = (DOCS / "python.md").read_text()
    for name in re.findall(r"python/examples/\w+\.py", text):
        assert (DOCS.parent / name).exists(), name


def test_the_conversions_of_the_formats_page(folder):
    commands = [line.split("#")[0] for block in blocks("formats.md") for line in block.splitlines()
                if line.startswith("burin convert")]
    assert len(commands) == 2
    for command in commands:
        words = shlex.split(command.replace("M.ply", "init.ply"))
        out = subprocess.run([PROGRAM] + words[1:], check=True, capture_output=True, text=True,
                             cwd=folder).stdout
        assert "COLMAP, 4 views" in out
    assert len(burin.load_scene(folder / "OUT_DIR")) == 4
    assert len(burin.load_scene(folder / "OUT.mvs")) == 4
    assert (folder / "OUT_mesh.ply").exists()
    # The mesh beside it is what a refinement starts from.
    subprocess.run([PROGRAM, "refine", "OUT.mvs", "--output", "refined", "--level.min_side_px", "30",
                    "--solver.max_iterations", "1"], check=True, capture_output=True, cwd=folder)
    assert (folder / "refined" / "refined.ply").exists()

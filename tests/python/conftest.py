"""The scene that the tests of the Python package share."""

import os
import subprocess

import pytest

import burin

PROGRAM = os.environ["BURIN_PROGRAM"]


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("scene")
    subprocess.run(
        [PROGRAM, "synth", "--output", path, "--synth.width", "160", "--synth.height", "120",
         "--synth.views", "4", "--synth.truth_point_count", "1000"],
        check=True, capture_output=True)
    return path


@pytest.fixture(scope="session")
def scene(folder):
    return burin.load_scene(folder)


@pytest.fixture(scope="session")
def mesh(folder):
    return burin.read_mesh(folder / "init.ply")

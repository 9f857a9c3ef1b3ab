"""What the tests of studies share: the burin program, a tiny study and a way to run it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "apps"))

# Two variants on one scene of four views of 160x120, and a third that burin refuses.
TINY = """
title = "A tiny study"
description = "For the tests."

[options]
level.rounds = 1
solver.max_iterations = 4

[evaluate]
unit = "footprint"
tau = "0.25,0.5,1"
sample_count = 2000

[scenes.relief]
synth = { width = 160, height = 120, views = 4, truth_point_count = 20000, pose_noise_px = 0.3 }

[variants]
weak.smooth.weight = 15
strong.smooth.weight = 240
"""
REFUSED = "refused.memory.limit_gb = 0.001\n"


def burin_program() -> str:
    """The program under test, which CTest names."""
    return os.environ.get("BURIN_PROGRAM", str(ROOT / "build/release/apps/burin"))


def study_command(command: str, file: Path, output: Path, *more: str) -> list[str]:
    """`apps/study run` or `plan` with the program under test."""
    return [sys.executable, str(ROOT / "apps/study"), command, str(file), "--output", str(output),
            "--burin", burin_program(), *more]


def run_study(file: Path, output: Path, *more: str) -> subprocess.CompletedProcess:
    """Runs a study to its end."""
    return subprocess.run(study_command("run", file, output, *(more or ("--cores", "2"))),
                          capture_output=True, text=True, check=False)


def write(folder: Path, text: str, name: str = "tiny.toml") -> Path:
    """A study file."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, subprocess.CompletedProcess]:
    """The output folder of the tiny study with the refused variant, and how its command ended."""
    folder = tmp_path_factory.mktemp("study")
    output = folder / "results"
    return output, run_study(write(folder, TINY + REFUSED), output)

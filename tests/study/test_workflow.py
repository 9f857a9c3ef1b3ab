"""A tiny study from its file to its tables: failures, repetition, and going on after a kill."""

import csv
import json
import os
import signal
import subprocess
import time
from pathlib import Path

from conftest import REFUSED, TINY, run_study, study_command, write
from study.jobs import Job

Finished = tuple[Path, subprocess.CompletedProcess]


def runs_of(output: Path) -> list[dict]:
    return json.loads((output / "results.json").read_text())["runs"]


def scores(output: Path) -> list[list]:
    """All that must be the same when a study is run again: everything but times and memory."""
    changing = {"refine_seconds", "total_seconds", "memory_mib"}
    return [[row[key] for key in row if key not in changing] for row in runs_of(output)]


def records(output: Path) -> dict[str, int]:
    return {str(path.relative_to(output)): path.stat().st_mtime_ns
            for path in sorted(output.glob("*s/**/*.json")) if path.name in
            ("scene.json", "select.json", "refine.json", "evaluate.json")}


def test_a_variant_that_fails_is_a_row_and_the_exit_code(finished: Finished) -> None:
    output, done = finished
    assert done.returncode == 1, done.stderr
    lines = [line for line in done.stderr.splitlines() if line.startswith("study: ")]
    assert lines[0].startswith("study: failed: runs/relief-seed1/refused: refine: "), done.stderr
    assert "memory.limit_gb" in lines[0]
    assert lines[1] == "study: 1 of 4 rows failed"
    by_name = {row["variant"]: row for row in runs_of(output)}
    assert list(by_name) == ["initial mesh", "weak", "strong", "refused"]
    assert by_name["refused"]["failed"].startswith("refine: ")
    assert by_name["refused"].get("accuracy_mean") is None
    assert by_name["weak"]["failed"] is None
    assert by_name["weak"]["accuracy_mean"] < by_name["initial mesh"]["accuracy_mean"]
    assert (output / "report.html").is_file()


def test_tables_say_the_same(finished: Finished) -> None:
    output, _ = finished
    with open(output / "runs.csv", encoding="utf-8", newline="") as file:
        rows = {row["variant"]: row for row in csv.DictReader(file)}
    for row in runs_of(output):
        if not row["failed"]:
            assert float(rows[row["variant"]]["accuracy_mean"]) == row["accuracy_mean"]
    summary = {row["variant"]: row
               for row in json.loads((output / "results.json").read_text())["summary"]}
    assert summary["refused"]["average_rank"] is None
    names = ("accuracy_mean", "accuracy_median", "completeness_mean", "completeness_median")
    weak = next(row for row in runs_of(output) if row["variant"] == "weak")
    assert abs(summary["weak"]["average_error"] - sum(weak[name] for name in names) / 4) < 1e-12
    assert {summary[name]["average_rank"] for name in ("weak", "strong")} <= {1, 1.25, 1.5, 1.75, 2}


def test_errors_and_ranks_name_the_share_that_matched_and_within_what(finished: Finished) -> None:
    output, _ = finished
    of_run = {row["variant"]: row for row in runs_of(output) if not row["failed"]}
    assert len({row["max_distance"] for row in of_run.values()}) == 1
    evaluated = json.loads((output / "runs/relief-seed1/weak/evaluate.json").read_text())["result"]
    assert of_run["weak"]["max_distance"] == evaluated["max_distance"] / evaluated["unit"]
    with open(output / "ranks.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["measure"] for row in rows] == ["accuracy_mean", "accuracy_median", "completeness_mean",
                                                "completeness_median"]
    for row in rows:
        side = row["measure"].split("_", maxsplit=1)[0]
        assert float(row["max_distance"]) == of_run["weak"]["max_distance"]
        assert {int(float(row[name])) for name in ("weak", "strong")} <= {1, 2}
        for name in ("weak", "strong"):
            assert 0 < float(row[f"{name}: matched"]) == of_run[name][f"{side}_matched"] <= 1
        assert row["refused: matched"] == ""
    summary = json.loads((output / "results.json").read_text())["summary"]
    weak = next(line for line in summary if line["variant"] == "weak")
    both = [of_run["weak"][f"{side}_matched"] for side in ("accuracy", "completeness")]
    assert abs(weak["average_matched"] - sum(both) / 2) < 1e-12


def test_camera_errors_are_columns(finished: Finished) -> None:
    output, _ = finished
    initial, weak = (next(row for row in runs_of(output) if row["variant"] == name)
                     for name in ("initial mesh", "weak"))
    assert 0.1 < initial["cameras_px"] < 1
    assert initial["cameras_px_before"] == weak["cameras_px_before"] == initial["cameras_px"]
    # Photographs that are too small for windows leave them as given: the same cameras, measured on another mesh.
    assert abs(weak["cameras_px"] - weak["cameras_px_before"]) < 0.05
    command = json.loads((output / "runs/relief-seed1/weak/evaluate.json").read_text())["command"]
    assert "--scene runs/relief-seed1/weak/refine/cameras --cameras scenes/relief-seed1/true_cameras" in command
    assert "cameras, px" in (output / "report.html").read_text(encoding="utf-8")


def test_refined_cameras_are_those_that_are_measured(tmp_path: Path) -> None:
    (tmp_path / "study.json").write_text(json.dumps({
        "burin": {"path": "burin"}, "variants": {},
        "instances": {"real": {"folder": "F", "mesh": "M", "truth": "T", "cameras": "C",
                               "evaluate": {}}}}))
    job = Job(tmp_path, "real")
    job.folder = tmp_path / "run"
    assert job.evaluation("m", job.cameras())[-4:] == ["--scene", "F", "--cameras", "C"]
    (job.folder / "refine/cameras").mkdir(parents=True)
    assert job.evaluation("m", job.cameras())[-4:] == ["--scene", str(job.folder / "refine/cameras"),
                                                       "--cameras", "C"]
    job.scene["cameras"] = ""
    assert "--scene" not in job.evaluation("m", job.cameras())


def test_the_same_study_again_does_nothing_and_an_edit_only_what_it_must(finished: Finished) -> None:
    output, _ = finished
    before = records(output)
    assert run_study(write(output.parent, TINY + REFUSED), output).returncode == 1
    assert records(output) == before
    edited = TINY.replace("strong.smooth.weight = 240", "strong.smooth.weight = 120")
    done = run_study(write(output.parent, edited, "edited.toml"), output)
    assert done.returncode == 0, done.stderr
    changed = {path for path, when in records(output).items() if before.get(path) != when}
    assert changed == {f"runs/relief-seed1/strong/{stage}.json"
                       for stage in ("select", "refine", "evaluate")}


def test_killed_it_goes_on_and_gives_the_same_numbers(tmp_path: Path) -> None:
    file = write(tmp_path, TINY)
    output = tmp_path / "results"
    with subprocess.Popen(study_command("run", file, output, "--cores", "1"), start_new_session=True,
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        done: list[str] = []
        while not done and process.poll() is None:  # CTest's time limit ends it on a broken program
            time.sleep(0.05)
            # A job's files may stand before the workflow has noted its end; with one core, what a
            # later job needed is noted.
            done = [path.replace("evaluate", "refine") for path in records(output)
                    if path.endswith("evaluate.json")]
        os.killpg(process.pid, signal.SIGKILL)
    before = records(output)
    assert done and not (output / "report.html").exists()
    finished = run_study(file, output)
    assert finished.returncode == 0, finished.stderr
    after = records(output)
    assert all(after[path] == before[path] for path in done)
    again = tmp_path / "again"
    assert run_study(file, again).returncode == 0
    assert scores(output) == scores(again)


def test_a_run_is_repeated_by_its_script(finished: Finished) -> None:
    output, _ = finished
    folder = output / "runs/relief-seed1/weak"
    mesh = (folder / "refine/refined.ply").read_bytes()
    (folder / "refine/refined.ply").unlink()
    done = subprocess.run([folder / "repeat.sh"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (folder / "refine/refined.ply").read_bytes() == mesh
    result = json.loads((folder / "evaluate.json").read_text())["result"]
    assert json.loads(done.stdout[done.stdout.index("{"):]) == result

"""What a Snakemake job does: it runs one burin command and records it as JSON.

A command that fails is a result too (a row that says so). The record then holds burin's reason, and the job
succeeds. Only a job that is stopped from outside fails; it is done again when the study goes on.
Records: {"stage", "command", "failed": reason or null, "seconds", "memory_mib"}. Paths in commands
are relative to the study's folder.
"""

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from study.burin_program import Options, flags, reason_of
from study.plan import read_json, read_plan, write_if_changed, write_json
from study.study_file import FOOTPRINT

STOPPED = (signal.SIGINT, signal.SIGTERM)


def run_command(command: list[str], log: Path) -> tuple[dict, str]:
    """Runs burin, keeps what it says in `log`; (record, standard output)."""
    log.parent.mkdir(parents=True, exist_ok=True)
    begin = time.monotonic()
    with open(log, "w", encoding="utf-8") as errors:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True)
        assert process.stdout is not None
        out = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    code = process.returncode
    if -code in STOPPED:
        sys.exit(128 - code)
    reason = None
    if code != 0:
        reason = reason_of(log.read_text(encoding="utf-8")) or (
            f"ended by signal {-code}" if code < 0 else f"exit code {code}")
    record = {"command": shlex.join(command[1:]), "failed": reason,
              "seconds": time.monotonic() - begin, "memory_mib": usage.ru_maxrss / 1024}
    return record, out


def level_ends(summary: dict) -> list[dict]:
    """{"level", "seconds"}: when each level of a run ended, since refining began."""
    ends = []
    now = 0.0
    for level in summary["levels"]:
        now += sum(level["seconds"].values())
        now += sum(one["seconds"][part] for one in level["rounds"]
                   for part in ("visibility", "build", "solve"))
        ends.append({"level": level["level"], "seconds": now})
    return ends


class Job:
    """The jobs of one instance of a scene, and of one variant on it."""

    def __init__(self, output: Path, instance: str, variant: str = "", threads: int = 1):
        plan = read_plan(output)
        self.burin = plan["burin"]["path"]
        self.scene = plan["instances"][instance]
        self.options: Options = plan["variants"][variant]["options"] if variant else {}
        self.instance_folder = Path("scenes", instance)
        self.folder = Path("runs", instance, variant) if variant else self.instance_folder
        self.threads = threads

    # Where things are

    def scene_folder(self) -> str:
        return self.scene["folder"] or str(self.instance_folder)

    def mesh(self) -> str:
        return self.scene["mesh"] or str(self.instance_folder / "init.ply")

    def truth(self) -> str:
        return self.scene["truth"] or str(self.instance_folder / "truth_points.ply")

    def true_cameras(self) -> str:
        """The model with the true cameras; empty where nobody knows them."""
        return self.scene["cameras"] if self.scene["folder"] else str(
            self.instance_folder / "true_cameras")

    def cameras(self) -> str:
        """The refined cameras of a run, those of the scene where it has none."""
        refined = self.folder / "refine/cameras"
        return str(refined) if refined.is_dir() else self.scene_folder()

    def evaluate_options(self) -> Options:
        options = dict(self.scene["evaluate"])
        if options.get("unit") == FOOTPRINT:
            options["unit"] = read_json(self.instance_folder / "synth.json")["footprint"]
        return options

    # Commands

    def do(self, stage: str, after: Path | None, arguments: Callable[[], list[str]],
           keep_output: bool = False) -> None:
        """Runs a stage unless the one before it failed, and writes its record."""
        before = read_json(after)["failed"] if after else None
        if before:
            record = {"command": "", "failed": before, "seconds": 0.0, "memory_mib": 0.0}
        else:
            record, out = run_command([self.burin, *arguments()], self.folder / f"{stage}.log")
            if keep_output and not record["failed"]:
                record["result"] = json.loads(out)
            if record["failed"]:
                record["failed"] = f"{stage}: {record['failed']}"
        write_json(self.folder / f"{stage}.json", {"stage": stage} | record)

    def make_scene(self) -> None:
        """scene.json: the synthetic scene, or that there is nothing to make."""
        if self.scene["folder"]:
            write_json(self.folder / "scene.json", {"stage": "scene", "command": "", "failed": None,
                                                    "seconds": 0.0, "memory_mib": 0.0})
            return
        options = self.scene["synth"] | {"synth.seed": self.scene["seed"]}
        self.do("scene", None, lambda: ["synth", "--output", str(self.folder), *flags(options)])

    def initial(self) -> None:
        """initial.json: the scores of the mesh that all variants start from."""
        self.do("initial", self.folder / "scene.json",
                lambda: self.evaluation(self.mesh(), self.scene_folder()), True)

    def select(self) -> None:
        """select.json: the variant's camera pairs."""
        pairs = {key: value for key, value in self.options.items() if key.startswith("pairs.")}
        self.do("select", self.instance_folder / "scene.json",
                lambda: ["select", self.scene_folder(), "--mesh", self.mesh(), "--output",
                         str(self.folder / "select"), "--no-pictures",
                         f"--run.threads={self.threads}", *flags(pairs)])

    def refine(self) -> None:
        """refine.json: the refined mesh, with the pairs that were selected."""
        options = {key: value for key, value in self.options.items() if not key.startswith("pairs.")}
        options = {"verdict.action": "warn"} | options  # a row is kept whatever the verdict is
        options |= {"pairs.method": "file", "pairs.file": str(self.folder / "select/pairs.json"),
                    "run.threads": self.threads}
        self.do("refine", self.folder / "select.json",
                lambda: ["refine", self.scene_folder(), "--mesh", self.mesh(), "--output",
                         str(self.folder / "refine"), "--level-meshes", *flags(options)])

    def evaluation(self, mesh: str, cameras: str = "") -> list[str]:
        """Scores of a mesh, and of the cameras given where the true ones are known."""
        true = self.true_cameras() if cameras else ""
        return ["evaluate", "--mesh", mesh, "--truth", self.truth(), "--json",
                *(["--scene", cameras, "--cameras", true] if true else []),
                *flags(self.evaluate_options())]

    def evaluate(self) -> None:
        """evaluate.json: the scores of the refined mesh."""
        self.do("evaluate", self.folder / "refine.json",
                lambda: self.evaluation(str(self.folder / "refine/refined.ply"), self.cameras()), True)
        self.write_script()

    def evaluate_levels(self) -> None:
        """levels.json: the scores of the mesh at the end of each level, for one curve a variant."""
        levels = []
        if not read_json(self.folder / "refine.json")["failed"]:
            for end in level_ends(read_json(self.folder / "refine/summary.json")):
                mesh = str(self.folder / f"refine/level_{end['level']}.ply")
                record, out = run_command([self.burin, *self.evaluation(mesh)],
                                          self.folder / "levels.log")
                result = {} if record["failed"] else {"result": json.loads(out)}
                levels.append(end | {"failed": record["failed"]} | result)
        write_json(self.folder / "levels.json", {"stage": "levels", "levels": levels})

    def picture(self, mesh: str, stage_before: Path) -> None:
        """picture.json: the mesh and its errors from the middle view, in picture.jpg."""
        self.do("picture", stage_before,
                lambda: ["picture", self.scene_folder(), "--mesh", mesh, "--truth", self.truth(),
                         "--output", str(self.folder / "picture.jpg"),
                         *flags(self.evaluate_options())])

    def write_script(self) -> None:
        """repeat.sh: the commands that made this run, from the scene on."""
        records = [self.instance_folder / "scene.json"]
        records += [self.folder / f"{stage}.json" for stage in ("select", "refine", "evaluate")]
        commands = [read_json(path)["command"] for path in records]
        up = "/".join([".."] * len(self.folder.parts))
        lines = ["#!/bin/sh", "# Repeats this run in place. BURIN names another burin program.",
                 "set -e", f'cd -- "$(dirname -- "$0")/{up}"',
                 f"burin={shlex.quote(self.burin)}", 'burin="${BURIN:-$burin}"']
        lines += [f'"$burin" {command}' for command in commands if command]
        script = self.folder / "repeat.sh"
        write_if_changed(script, "\n".join(lines) + "\n")
        script.chmod(0o755)


def run_job(output: Path, stage: str, instance: str, variant: str, threads: int) -> None:
    """What the Snakefile calls: `stage` is the name of its rule."""
    job = Job(output, instance, variant, threads)
    if stage == "initial_picture":
        job.picture(job.mesh(), job.folder / "scene.json")
    elif stage == "picture":
        job.picture(str(job.folder / "refine/refined.ply"), job.folder / "refine.json")
    else:
        {"scene": job.make_scene, "initial": job.initial, "select": job.select,
         "refine": job.refine, "evaluate": job.evaluate,
         "evaluate_levels": job.evaluate_levels}[stage]()

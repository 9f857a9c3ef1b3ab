"""The command line of studies: run, plan, charts, and the parts that the Snakefile calls."""

import argparse
import fcntl
import os
import subprocess
import sys
import tomllib
from pathlib import Path

from study.burin_program import Burin
from study.errors import StudyError
from study.plan import PLAN, make_plan, read_json, write_json
from study.study_file import read_study

HERE = Path(__file__).resolve().parent
PROGRAM = HERE.parent.parent / "build/release/apps/burin"


def toml_value(text: str) -> object:
    """A value as a study file would have it; what is not TOML is text."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def folder_scene(arguments: argparse.Namespace) -> dict | None:
    """The scene given on the command line, if any."""
    given = {key: getattr(arguments, key) for key in ("scene", "mesh", "truth")}
    if not any(given.values()) and not arguments.evaluate:
        return None
    missing = [key for key, value in given.items() if not value]
    if missing:
        raise StudyError("command line", f"--{missing[0]}", "missing; --scene, --mesh and --truth go together")
    evaluate = {}
    for pair in arguments.evaluate:
        key, equals, value = pair.partition("=")
        if not equals:
            raise StudyError("command line", f"--evaluate {pair}", "must be OPTION=VALUE")
        evaluate[key] = toml_value(value)
    return {"folder": given["scene"], "mesh": given["mesh"], "truth": given["truth"],
            "evaluate": evaluate}


def plan(arguments: argparse.Namespace) -> int:
    """Checks the study and writes study.json into the output folder."""
    burin = Burin(Path(arguments.burin))
    study = read_study(Path(arguments.file), burin, folder_scene(arguments))
    try:
        write_json(Path(arguments.output) / PLAN, make_plan(study, burin))
    except OSError as error:
        raise StudyError(arguments.output, "", f"cannot be written to: {error.strerror}") from None
    return 0


def run(arguments: argparse.Namespace) -> int:
    """plan, then Snakemake, then the verdict."""
    output = Path(arguments.output)
    plan(arguments)
    # The lock is held by Snakemake too and goes with it, however it ends: nothing to unlock by hand.
    with open(output / ".lock", "w", encoding="utf-8") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise StudyError(output, "", "another study is running in this folder") from None
        command = [sys.executable, "-m", "snakemake", "--snakefile", str(HERE / "Snakefile"),
                   "--directory", str(output), "--nolock", "--rerun-incomplete", "--keep-going",
                   *(arguments.snakemake or ["--cores", str(arguments.cores)]), "report.html"]
        done = subprocess.run(command, pass_fds=[lock.fileno()], check=False)
    if done.returncode != 0:
        print("study: error: Snakemake did not finish; the same command goes on from here",
              file=sys.stderr)
        return 1
    print(f"study: wrote {output / 'report.html'}")
    return verdict(output)


def verdict(output: Path) -> int:
    """A line for every run that failed; 1 when there is any."""
    rows = read_json(output / "results.json")["runs"]
    failed = [row for row in rows if row["failed"]]
    for row in failed:
        print(f"study: failed: {row['folder']}: {row['failed']}", file=sys.stderr)
    if failed:
        print(f"study: {len(failed)} of {len(rows)} rows failed", file=sys.stderr)
    return 1 if failed else 0


def charts(folder: Path) -> int:
    """The charts of a comparison of strategies, into its folder."""
    from study.comparison import draw_comparison
    written = draw_comparison(folder)
    more = f" and {len(written) - 1} of single rounds in {written[1].parent}" if written[1:] else ""
    print(f"study: wrote {written[0]}{more}")
    return 0


def parser() -> argparse.ArgumentParser:
    """The command line."""
    top = argparse.ArgumentParser(prog="study", description=__doc__)
    commands = top.add_subparsers(dest="command", required=True)
    for name, text in (("run", "check a study, run its jobs, write its report"),
                       ("plan", "check a study and write study.json, for plain snakemake")):
        sub = commands.add_parser(name, help=text)
        sub.add_argument("file", help="study file, TOML")
        sub.add_argument("--output", required=True, metavar="DIR", help="folder of the study's results")
        sub.add_argument("--burin", default=str(PROGRAM), metavar="PROGRAM", help="burin program to study")
        sub.add_argument("--scene", metavar="DIR", help="COLMAP workspace to add to the scenes")
        sub.add_argument("--mesh", metavar="FILE", help="mesh to start from there")
        sub.add_argument("--truth", metavar="FILE", help="truth there")
        sub.add_argument("--evaluate", action="append", default=[], metavar="OPTION=VALUE",
                         help="option of burin evaluate there; may be repeated")
        if name == "run":
            sub.add_argument("--cores", type=int, default=os.cpu_count(), metavar="N",
                             help="cores to use (default: all)")
            sub.epilog = "What follows -- is handed to snakemake in place of --cores."
    comparison = commands.add_parser("charts", help="draw what burin compare-solvers found")
    comparison.add_argument("folder", metavar="DIR", help="its output folder, with compare.csv")
    job = commands.add_parser("job", help="one job of the Snakefile, in the study's folder")
    job.add_argument("stage")
    job.add_argument("instance")
    job.add_argument("variant", nargs="?", default="")
    job.add_argument("--threads", type=int, default=1)
    for name, text in (("table", "CSV and JSON from the records"), ("report", "report.html"),
                       ("verdict", "which runs failed")):
        commands.add_parser(name, help=text + ", in the study's folder")
    return top


def main(argv: list[str]) -> int:
    """Exit code: 0, 1 = something failed, 2 = wrong study or command line."""
    end = argv.index("--") if "--" in argv else len(argv)
    arguments = parser().parse_args(argv[:end])
    arguments.snakemake = argv[end + 1:]
    if arguments.snakemake and arguments.command != "run":
        parser().error("only run hands arguments to snakemake")
    here = Path(".")
    try:
        if arguments.command == "run":
            return run(arguments)
        if arguments.command == "plan":
            return plan(arguments)
        if arguments.command == "charts":
            return charts(Path(arguments.folder))
        if arguments.command == "job":
            from study.jobs import run_job
            run_job(here, arguments.stage, arguments.instance, arguments.variant, arguments.threads)
            return 0
        if arguments.command == "table":
            from study.table import write_tables
            write_tables(here)
            return 0
        if arguments.command == "report":
            from study.report import write_report
            write_report(here)
            return 0
        return verdict(here)
    except StudyError as error:
        print(f"study: error: {error}", file=sys.stderr)
        return 2

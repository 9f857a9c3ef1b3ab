#!/usr/bin/env python3
"""Prints README's tables of results anew, from the commands that README gives above them.

readme_figures.py BURIN OUTPUT_DIR [FOUNTAIN]: the strategies on the embedded scene; with FOUNTAIN, a folder
of fountain-P11 with init.ply and truth/points_10mm.ply, that table too. Rows are README's, in Markdown.
"""
import json
import re
import subprocess
import sys
from pathlib import Path

STRATEGIES = ("gradient_descent", "steepest_descent", "ncg", "bfgs", "lbfgs", "lbfgs_sobolev", "lbfgs_h",
              "lm_cholesky", "lm_cgnr", "lm_pcg", "dogleg")
SPLIT = ["--surface.remesh", "none", "--surface.trim", "none"]
GIVEN = [*SPLIT, "--cameras.refine", "none"]
FOUNTAIN_ROWS = {"**burin, defaults**": [], "burin, `--surface.remesh none --surface.trim none`": SPLIT,
                 "burin, and `--cameras.refine none`": GIVEN,
                 "burin, `--level.rounds 4`": [*GIVEN, "--level.rounds", "4"],
                 "burin, `--mask.mode none`": [*GIVEN, "--mask.mode", "none"]}


def row(*cells):
    """Prints a row."""
    print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def run(*command):
    """The command's standard output; None where it fails."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    return done.stdout if done.returncode == 0 else None


def summary_of(folder):
    """What a run says about itself."""
    return json.loads((folder / "summary.json").read_text())


def strategies(burin, output):
    """A row for each strategy's demo."""
    for name in STRATEGIES:
        folder = output / f"demo-{name}"
        said = run(burin, "demo", "--output", folder, "--solver.type", name)
        if said is None:
            row(f"`{name}`", "refused", "", "", "", "")
            continue
        after, times, pixels = re.search(r"after (\S+) \((\S+) times smaller; (\S+) px\)", said).groups()
        summary = summary_of(folder)
        row(f"`{name}`", f"{after} ({pixels} px)", times + "x", f"{summary['seconds']['refine']:.1f}",
            summary["iterations"], summary["evaluations"])


def fountain(burin, output, scene):
    """The initial mesh and burin's rows, by README's two commands."""
    def f1(mesh):
        scores = json.loads(run(burin, "evaluate", "--mesh", mesh, "--truth", scene / "truth/points_10mm.ply",
                                "--tau", "5,10,20", "--unit", "0.001", "--align", "rigid", "--json"))
        return (scores["mesh"]["faces"],
                " / ".join(f"{score['f1']:.3f}".lstrip("0") for score in scores["scores"]))

    faces, scores = f1(scene / "init.ply")
    row("initial mesh", faces, "", "", scores, "")
    for k, (name, options) in enumerate(FOUNTAIN_ROWS.items()):
        folder = output / f"fountain-{k}"
        run(burin, "refine", scene, "--mesh", scene / "init.ply", "--output", folder, *options)
        faces, scores = f1(folder / "refined.ply")
        summary = summary_of(folder)
        row(name, faces, summary["pairs"]["count"], summary["iterations"], scores,
            f"{summary['seconds']['total']:.0f}")


def main():
    """Both tables, or the first."""
    burin, output = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    output.mkdir(parents=True, exist_ok=True)
    strategies(burin, output)
    if len(sys.argv) > 3:
        print()
        fountain(burin, output, Path(sys.argv[3]))


if __name__ == "__main__":
    main()

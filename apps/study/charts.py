"""The figures of a report, as SVG text: error against time, and energies of the iterations."""

import csv
import io
from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend is chosen first)
import pandas  # noqa: E402

from study.plan import read_json  # noqa: E402

INK = "#333333"
plt.rcParams.update({
    "svg.hashsalt": "burin",  # the same picture is the same text
    "font.size": 9, "axes.edgecolor": "#999999", "axes.labelcolor": INK, "xtick.color": INK,
    "ytick.color": INK, "text.color": INK, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": "#e8e8e8", "grid.linewidth": 0.6, "axes.axisbelow": True,
    "legend.frameon": False})


def colors(names: list[str]) -> dict[str, tuple]:
    """A colour for each variant, the same in all figures of a report."""
    if len(names) <= 10:
        return {name: plt.get_cmap("tab10")(k) for k, name in enumerate(names)}
    ramp = plt.get_cmap("turbo")
    return {name: ramp(0.05 + 0.9 * k / (len(names) - 1)) for k, name in enumerate(names)}


def svg_of(figure: plt.Figure) -> str:
    """The figure as SVG text without a date; closes it."""
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None}, bbox_inches="tight")
    plt.close(figure)
    return text.getvalue()


def error_against_time(curves: dict[str, list[tuple[float, float]]], runs: pandas.DataFrame,
                       initial: float, unit: str, color: dict[str, tuple]) -> str:
    """A line a variant, and the mean and spread over seeds of where it ends.

    `curves`: (seconds, error) at the start and at the end of every level, of one seed. `runs`:
    columns variant, error, refine_seconds, all seeds.
    """
    figure, axes = plt.subplots(figsize=(5.6, 3.4))
    for name, points in curves.items():
        axes.plot(*zip(*points), color=color[name], linewidth=1.1, marker=".", markersize=4)
    for name, group in runs.groupby("variant", sort=False):
        spread = group[["refine_seconds", "error"]].std().fillna(0)
        axes.errorbar(group["refine_seconds"].mean(), group["error"].mean(),
                      xerr=spread["refine_seconds"], yerr=spread["error"], fmt="o", markersize=5,
                      elinewidth=0.8, color=color[name], label=name)
    axes.axhline(initial, color="#999999", linewidth=0.9, linestyle="--", label="initial mesh")
    if initial > 4 * runs["error"].max():
        axes.set_yscale("log")
    axes.set_xlim(left=0)
    axes.set_xlabel("seconds, refining")
    axes.set_ylabel(f"average error [{unit}]")
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8)
    return svg_of(figure)


def energy_curve(folder: Path) -> tuple[list[float], list[float]]:
    """(seconds since refining began, energy per pixel pair) of every iteration of a run.

    trace.csv counts seconds from the start of each solve; the summary has what lies between.
    """
    summary = read_json(folder / "summary.json")
    with open(folder / "trace.csv", encoding="utf-8", newline="") as file:
        trace = list(csv.DictReader(file))
    seconds: list[float] = []
    energies: list[float] = []
    now = 0.0
    for level in summary["levels"]:
        now += sum(level["seconds"].values())
        for one in level["rounds"]:
            now += one["seconds"]["visibility"] + one["seconds"]["build"]
            for line in trace:
                if (int(line["level"]), int(line["round"])) == (level["level"], one["round"]):
                    seconds.append(now + float(line["seconds"]))
                    energies.append(float(line["energy"]) / max(1, one["pair_pixels"]))
            now += one["seconds"]["solve"]
    return seconds, energies


def energies(folders: dict[str, Path], color: dict[str, tuple]) -> str:
    """Energy per pixel pair against time, a line for each variant's refine folder."""
    figure, axes = plt.subplots(figsize=(5.6, 3.4))
    for name, folder in folders.items():
        axes.plot(*energy_curve(folder), color=color[name], linewidth=1.1, label=name)
    axes.set_yscale("log")
    axes.set_xlim(left=0)
    axes.set_xlabel("seconds, refining")
    axes.set_ylabel("energy per pixel pair")
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8)
    return svg_of(figure)


def css(color: tuple) -> str:
    """A colour of matplotlib as the page writes it."""
    return matplotlib.colors.to_hex(color)

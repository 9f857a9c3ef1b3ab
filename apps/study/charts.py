"""Every curve that burin draws, as SVG text: those of a study's report (error against time, energies of the
iterations) and those of a comparison of strategies."""

import csv
import io
import math
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend is chosen first)
import pandas  # noqa: E402

from study.plan import read_json  # noqa: E402

INK = "#333333"
LOG_FROM = 4  # ratio of largest to smallest value from which an axis is logarithmic
Points = list[tuple[float, float]]
plt.rcParams.update({
    "svg.hashsalt": "burin",  # the same picture is the same text
    "font.size": 9, "axes.edgecolor": "#999999", "axes.labelcolor": INK, "xtick.color": INK,
    "ytick.color": INK, "text.color": INK, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": "#e8e8e8", "grid.linewidth": 0.6, "axes.axisbelow": True,
    "legend.frameon": False})


def colors(names: list[str]) -> dict[str, tuple]:
    """A colour for each variant or strategy, the same in all figures of a report or comparison."""
    few = [*plt.get_cmap("tab10").colors, (0, 0, 0), (0.05, 0.2, 0.5)]
    if len(names) <= len(few):
        return dict(zip(names, few))
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
    if initial > LOG_FROM * runs["error"].max():
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


def curve_styles(names: list[str]) -> dict[str, dict]:
    """Line and marks of each curve. Four layers, from solid lines with large marks below to dotted ones with
    small marks on top: of up to four neighbours that lie on each other, all show."""
    layers = [{"linestyle": dashes, "markersize": size, "zorder": 2 + 0.1 * k}
              for k, (dashes, size) in enumerate((("-", 6.5), ((0, (4, 2)), 5.2), ((0, (6, 2, 1, 2)), 4),
                                                  ((0, (1, 1.2)), 2.8)))]
    return {name: {"color": color, "linewidth": 1.4, "marker": "osD^v"[k % 5], "markerfacecolor": "white",
                   **layers[k % len(layers)]}
            for k, (name, color) in enumerate(colors(names).items())}


@dataclass(frozen=True)
class Panel:
    """Curves that all begin at one value. `cut`: one that rises far above it, which would flatten the
    others, leaves through the top."""

    x_label: str
    y_label: str
    curves: dict[str, Points]
    cut: bool = False


def round_ticks(axis: matplotlib.axis.Axis, low: float, high: float) -> None:
    """Plain numbers along a logarithmic axis; over a few decades also 2 and 5 times each power."""
    many = high > 1000 * low
    axis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1,) if many else (1, 2, 5)))
    axis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(matplotlib.ticker.NullFormatter())


def draw_panel(axes: plt.Axes, panel: Panel, styles: dict[str, dict]) -> None:
    """The panel's curves without their points that are not finite; an axis is logarithmic where its
    values are above 0 and spread by LOG_FROM."""
    curves = {name: [point for point in points if all(map(math.isfinite, point))]
              for name, points in panel.curves.items()}
    curves = {name: points for name, points in curves.items() if points}
    axes.set_xlabel(panel.x_label)
    axes.set_ylabel(panel.y_label)
    if not curves:
        return
    xs, ys = zip(*(point for points in curves.values() for point in points))
    lowest, start, top = min(ys), ys[0], max(ys)
    if panel.cut and lowest < start:
        top = min(top, start + 0.5 * (start - lowest))
    for name, points in curves.items():
        axes.plot(*zip(*points), label=name, **styles[name])
    for low, high, axis, to_log in ((min(xs), max(xs), axes.xaxis, axes.set_xscale),
                                    (lowest, top, axes.yaxis, axes.set_yscale)):
        if 0 < LOG_FROM * low < high:
            to_log("log")
            round_ticks(axis, low, high)
        else:
            axis.set_major_formatter(matplotlib.ticker.ScalarFormatter(useOffset=False,
                                                                       useMathText=True))
    if top < max(ys):
        margin = (top / lowest) ** 0.05 if axes.get_yscale() == "log" else 0.05 * (top - lowest)
        axes.set_ylim((lowest / margin, top * margin) if axes.get_yscale() == "log" else
                      (lowest - margin, top + margin))


def strategies(title: str, subtitle: str, rows: list[list[Panel]], styles: dict[str, dict]) -> plt.Figure:
    """A page of panels with one legend for the strategies of all of them."""
    height = 0.6 + 3.1 * len(rows)
    figure, grid = plt.subplots(len(rows), len(rows[0]), figsize=(9.6, height), squeeze=False,
                                layout="constrained")
    figure.get_layout_engine().set(rect=(0, 0, 1, 1 - 0.6 / height))
    for axes_row, row in zip(grid, rows):
        for axes, panel in zip(axes_row, row):
            draw_panel(axes, panel, styles)
    figure.text(0.01, 1 - 0.2 / height, title, fontsize=12, fontweight="bold")
    figure.text(0.01, 1 - 0.42 / height, subtitle, color="#666666")
    shown = dict(zip(*reversed(grid[0][0].get_legend_handles_labels())))
    figure.legend(shown.values(), shown.keys(), loc="upper center", bbox_to_anchor=(0.5, 0), ncol=6,
                  handlelength=3.2)
    return figure


def css(color: tuple) -> str:
    """A colour of matplotlib as the page writes it."""
    return matplotlib.colors.to_hex(color)

"""report.html: one self-contained page with everything that a study found."""

import base64
import math
import shlex
from pathlib import Path

import jinja2
import pandas

from study import charts
from study.plan import read_json, read_plan, write_if_changed
from study.ranking import ERROR_MEASURES, MATCHED_SHARES
from study.study_file import FOOTPRINT, INITIAL
from study.table import scores_of

HERE = Path(__file__).resolve().parent
LABELS = {"accuracy_mean": "acc. mean", "accuracy_median": "acc. median",
          "completeness_mean": "compl. mean", "completeness_median": "compl. median",
          "max_distance": "within", "accuracy_matched": "acc. matched %",
          "completeness_matched": "compl. matched %",
          "cameras_px_before": "cameras before, px", "cameras_px": "cameras, px",
          "quality": "quality", "under_10_deg": "under 10° %", "turned": "turned %",
          "pairs": "pairs", "faces": "faces", "iterations": "iterations",
          "total_seconds": "seconds", "memory_mib": "MiB"}
SHARES = ("under_10_deg", "turned")  # of the mesh, shown in per cent
MIME = {".jpg": "image/jpeg", ".svg": "image/svg+xml"}


def number(value: float) -> str:
    """Four significant digits, large and whole numbers in full."""
    if (value == round(value) or abs(value) >= 1000) and abs(value) < 1e9:
        return str(round(value))
    return f"{value:#.4g}".rstrip(".")


def cell(values: pandas.Series | list) -> dict:
    """Mean over seeds and its spread (sample standard deviation)."""
    values = pandas.Series(values, dtype=float)
    if values.empty or values.isna().any():
        return {"text": "–", "sort": ""}
    spread = values.std() if len(values) > 1 else math.nan
    return {"text": number(values.mean()), "sort": repr(float(values.mean())),
            "spread": "" if math.isnan(spread) else f"{spread:.2g}"}


def percent(values: pandas.Series | list) -> dict:
    """The same of shares, in per cent."""
    return cell(100 * pandas.Series(values, dtype=float))


def mark_best(rows: list[dict], column: int, highest: bool) -> None:
    """Marks the best cells of a column among the rows that compete; equal as printed is equal."""
    cells = [row["cells"][column] for row in rows if row["competes"] and row["cells"][column]["sort"]]
    if len(cells) < 2:
        return
    best = (max if highest else min)(cells, key=lambda one: float(one["sort"]))
    for one in cells:
        one["best"] = one["text"] == best["text"]


def overview(results: dict, plan: dict, color: dict[str, tuple]) -> dict:
    """Average rank, average error with the share that matched, time and memory of every variant."""
    units = {str(instance["evaluate"]["unit"]) for instance in plan["instances"].values()}
    rows = []
    for line in results["summary"]:
        cells = [cell([line[key]]) if line[key] is not None else {"text": "–", "sort": ""}
                 for key in ("average_rank", "average_error", "total_seconds", "memory_mib")]
        if cells[0]["sort"]:
            cells[0]["text"] = f"{line['average_rank']:.2f}"
        matched = line["average_matched"]
        cells.insert(2, percent([] if matched is None else [matched]))
        cells.append({"text": str(line["failed"]), "sort": str(line["failed"])})
        rows.append({"name": line["variant"], "competes": True, "cells": cells,
                     "color": charts.css(color[line["variant"]])})
    mark_best(rows, 0, False)
    mark_best(rows, 1, False)
    return {"id": "overview", "rows": rows,
            "columns": ["average rank", "average error" + (" (mixed units)" if len(units) > 1 else ""),
                        "matched %", "seconds", "MiB", "failed runs"]}


def scene_table(name: str, runs: pandas.DataFrame, color: dict[str, tuple]) -> dict:
    """All measures of one scene: a row for the initial mesh and for each variant."""
    thresholds = [key for key in runs.columns
                  if key.startswith("f1@") and runs[key].notna().any()]
    shares = tuple(dict.fromkeys(MATCHED_SHARES.values()))
    cameras = [key for key in ("cameras_px_before", "cameras_px")
               if key in runs and runs[key].notna().any()]
    keys = [*ERROR_MEASURES, "max_distance", *shares, *thresholds, *cameras, "pairs", "faces", "quality",
            "under_10_deg", "turned", "iterations", "total_seconds", "memory_mib"]
    rows = []
    for variant, group in runs.groupby("variant", sort=False):
        failed = group["failed"].notna().sum()
        cells = [(percent if key in (*shares, *SHARES) else cell)(group[key] if key in group else [])
                 for key in keys]
        rows.append({"name": variant, "competes": variant != INITIAL, "cells": cells,
                     "color": charts.css(color[variant]) if variant in color else "",
                     "note": f"failed ({failed} of {len(group)})" if failed else ""})
    for column, key in enumerate(keys):
        if key in ERROR_MEASURES or key in thresholds or key == "cameras_px":
            mark_best(rows, column, key in thresholds)
    return {"id": "scene-" + name, "rows": rows,
            "columns": [LABELS.get(key, key.replace("f1@", "F1 at ")) for key in keys]}


def differing(plan: dict) -> dict:
    """The options that are not the same for all variants."""
    variants = list(plan["variants"].values())
    keys = [key for key in variants[0]["effective"]
            if len({str(variant["effective"][key]) for variant in variants}) > 1]
    rows = []
    for variant in variants:
        texts = [str(variant["effective"][key]) for key in keys]
        rows.append({"name": variant["name"], "competes": False,
                     "cells": [{"text": text, "sort": text} for text in texts]})
    return {"id": "options", "columns": keys, "rows": rows}


def rank_table(results: dict, names: list[str]) -> dict:
    """The rank of every variant in every row, with the share of the points that matched."""
    rows = []
    for line in results["ranks"]:
        cells = [cell([] if line[name] is None else [line[name]]) for name in names]
        for name, one in zip(names, cells):
            if one["sort"]:
                one["beside"] = percent([line[f"{name}: matched"]])["text"] + " %"
        within = cell([] if line["max_distance"] is None else [line["max_distance"]])["text"]
        rows.append({"name": f"{line['scene']}, {LABELS[line['measure']]} (within {within})",
                     "competes": False, "cells": cells})
    return {"id": "ranks", "columns": names, "rows": rows}


def data_uri(path_or_svg: Path | str) -> str:
    """A picture inside the page."""
    if isinstance(path_or_svg, Path):
        mime, data = MIME[path_or_svg.suffix], path_or_svg.read_bytes()
    else:
        mime, data = MIME[".svg"], path_or_svg.encode()
    return f"data:{mime};base64,{base64.b64encode(data).decode('ascii')}"


def pictures(output: Path, key: str, plan: dict) -> list[dict]:
    """The initial mesh and every variant on one instance; why, where there is no picture."""
    folders = {INITIAL: output / "scenes" / key}
    folders |= {what["name"]: output / "runs" / key / variant
                for variant, what in plan["variants"].items()}
    found = []
    for name, folder in folders.items():
        failed = read_json(folder / "picture.json")["failed"]
        found.append({"name": name, "failed": failed,
                      "uri": "" if failed else data_uri(folder / "picture.jpg")})
    return found


def mean_error(result: dict) -> float:
    """Mean of the four error measures of `burin evaluate --json`, in its unit."""
    scores = scores_of(result)
    return sum(scores[key] for key in ERROR_MEASURES) / len(ERROR_MEASURES)


def level_curves(output: Path, plan: dict, key: str) -> dict[str, list[tuple[float, float]]]:
    """(seconds, average error) at the start and at the end of every level, by variant."""
    start = read_json(output / "scenes" / key / "initial.json") | {"seconds": 0.0}
    curves = {}
    for variant, what in plan["variants"].items():
        levels = read_json(output / "runs" / key / variant / "levels.json")["levels"]
        points = [(one["seconds"], mean_error(one["result"])) for one in [start, *levels]
                  if not one["failed"]]
        if levels and points:
            curves[what["name"]] = points
    return curves


def scene_section(output: Path, plan: dict, key: str, runs: pandas.DataFrame,
                  color: dict[str, tuple]) -> dict:
    """One scene: its table, figures and pictures. `key`: the instance with the first seed."""
    instance = plan["instances"][key]
    name, unit = instance["scene"], instance["evaluate"]["unit"]
    unit = "px" if unit == FOOTPRINT else f"{unit:g} world units"
    runs = runs[runs["scene"] == name]
    done = runs[runs["failed"].isna()].copy()
    section = {"name": name, "unit": unit, "table": scene_table(name, runs, color),
               "pictures": pictures(output, key, plan), "figures": [],
               "range": max(float(tau) for tau in str(instance["evaluate"]["tau"]).split(","))}
    refined = done[done["variant"] != INITIAL]
    if not refined.empty:
        done["error"] = done[list(ERROR_MEASURES)].mean(axis="columns")
        initial = done.loc[done["variant"] == INITIAL, "error"].mean()
        section["figures"].append({
            "caption": "Average error (mean of the four error measures) against time: at the end of "
                       "each level of the first seed (lines), and of whole runs (circles: mean over "
                       "seeds; bars: spread).",
            "uri": data_uri(charts.error_against_time(
                level_curves(output, plan, key), done[done["variant"] != INITIAL], initial, unit,
                color))})
        folders = {what["name"]: output / "runs" / key / variant / "refine"
                   for variant, what in plan["variants"].items()
                   if not read_json(output / "runs" / key / variant / "refine.json")["failed"]}
        section["figures"].append({
            "caption": "Energy of every iteration, all levels and rounds, divided by the pixel pairs "
                       "of its round; first seed. It jumps where a round or a level begins.",
            "uri": data_uri(charts.energies(folders, color))})
    return section


def write_report(output: Path) -> None:
    """report.html from results.json, the plan and the pictures."""
    plan, results = read_plan(output), read_json(output / "results.json")
    runs = pandas.DataFrame(results["runs"])
    names = [what["name"] for what in plan["variants"].values()]
    color = charts.colors(names)
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(HERE), autoescape=True,
                                     trim_blocks=True, lstrip_blocks=True)
    first = [key for key, instance in plan["instances"].items() if instance["first"]]
    seeds = {key: sum(one["scene"] == plan["instances"][key]["scene"]
                      for one in plan["instances"].values()) for key in first}
    write_if_changed(output / "report.html", environment.get_template("report.html.j2").render(
        plan=plan, results=results, variant_count=len(names), seeds=list(seeds.values()),
        run_count=len(plan["instances"]) * len(names), overview=overview(results, plan, color),
        scenes=[scene_section(output, plan, key, runs, color) for key in first],
        options=differing(plan), ranks=rank_table(results, names),
        failures=[row for row in results["runs"] if row["failed"]],
        threads=sorted({int(row["threads"]) for row in results["runs"] if row.get("threads")}),
        command=shlex.join(["./run", "study", plan["study"], "--output", "DIR"])))
    (output / "report.html").touch()

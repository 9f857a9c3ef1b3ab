"""Collects the records of a study's jobs into runs.csv, summary.csv, ranks.csv and results.json."""

import json
import math
from pathlib import Path

import pandas

from study.plan import read_json, read_plan, write_if_changed, write_json
from study.ranking import ERROR_MEASURES, MATCHED_SHARES, average_error, average_rank, ranks
from study.study_file import INITIAL


def scores_of(result: dict) -> dict[str, float]:
    """The scores of `burin evaluate --json`, lengths in its unit."""
    unit = result["unit"]
    scores = {"max_distance": result["max_distance"] / unit}
    for side in ("accuracy", "completeness"):
        for name in ("mean", "median", "rmse"):
            scores[f"{side}_{name}"] = result[side][name] / unit
        scores[f"{side}_matched"] = result[side]["matched_share"]
    for score in result["scores"]:
        for name in ("precision", "recall", "f1"):
            scores[f"{name}@{score['tau'] / unit:.6g}"] = score[name]
    scores |= {"vertices": result["mesh"]["vertices"], "faces": result["mesh"]["faces"]}
    scores |= {name: result["mesh"][name] for name in ("quality", "under_10_deg", "over_150_deg")}
    if result["turned"] is not None:
        scores["turned"] = result["turned"]
    if "cameras" in result:
        scores["cameras_px"] = result["cameras"]["rms_px"]
    return scores


def cost_of(summary: dict) -> dict[str, float]:
    """Times, memory and work from refine's summary.json."""
    rounds = [one for level in summary["levels"] for one in level["rounds"]]
    return {"pairs": summary["pairs"]["count"], "iterations": summary["iterations"],
            "evaluations": summary["evaluations"],
            "energy": rounds[-1]["energy_final"]["total"] if rounds else math.nan,
            "refine_seconds": summary["seconds"]["refine"],
            "total_seconds": summary["seconds"]["total"],
            "memory_mib": summary["peak_memory_mib"], "threads": summary["threads"]}


def failure_of(folder: Path) -> str | None:
    """The reason that the last record of a run's or scene's folder gives."""
    last = folder / ("evaluate.json" if (folder / "evaluate.json").is_file() else "initial.json")
    return read_json(last)["failed"]


def collect(output: Path, plan: dict) -> list[dict]:
    """One row for the initial mesh of every instance and for every run, failed ones with the reason."""
    rows = []
    for key, instance in plan["instances"].items():
        head = {"scene": instance["scene"], "seed": instance["seed"]}
        folder = Path("scenes", key)
        row = head | {"variant": INITIAL, "folder": str(folder), "failed": failure_of(output / folder)}
        before: dict[str, float] = {}
        if not row["failed"]:
            row |= scores_of(read_json(output / folder / "initial.json")["result"])
            if "cameras_px" in row:
                before = {"cameras_px_before": row["cameras_px"]}
        rows.append(row | before)
        for variant, what in plan["variants"].items():
            folder = Path("runs", key, variant)
            row = head | {"variant": what["name"], "folder": str(folder),
                          "failed": failure_of(output / folder)}
            if not row["failed"]:
                row |= scores_of(read_json(output / folder / "evaluate.json")["result"])
                row |= cost_of(read_json(output / folder / "refine/summary.json")) | before
            rows.append(row)
    return rows


def rows_of(runs: pandas.DataFrame, figures: dict[str, str]) -> pandas.DataFrame:
    """Rows: scene and error measure, the mean over seeds of its figure. Columns: variants, in the plan's order."""
    variants = [name for name in runs["variant"].unique() if name != INITIAL]
    columns = runs[["scene", "variant"]].assign(
        **{measure: runs.get(figure, math.nan) for measure, figure in figures.items()})
    means = columns.groupby(["scene", "variant"], sort=False)[list(figures)].agg(
        lambda values: values.mean(skipna=False))
    wide = means.stack(dropna=False).unstack("variant")
    return wide.reindex(index=pandas.MultiIndex.from_product(
        [runs["scene"].unique(), list(figures)]), columns=variants)


def errors_of(runs: pandas.DataFrame) -> pandas.DataFrame:
    """The errors themselves."""
    return rows_of(runs, {measure: measure for measure in ERROR_MEASURES})


def ranks_of(runs: pandas.DataFrame, errors: pandas.DataFrame) -> pandas.DataFrame:
    """The rank of every variant in every row. In each row, what the distances were within; after each
    rank, "VARIANT: matched", the share of the points that was."""
    matched = rows_of(runs, MATCHED_SHARES)
    table = ranks(errors)
    for name in reversed(list(errors)):
        table.insert(list(table).index(name) + 1, f"{name}: matched", matched[name])
    table.index.names = ["scene", "measure"]
    within = runs.reindex(columns=["scene", "max_distance"]).groupby("scene")["max_distance"].mean()
    table["max_distance"] = [within[scene] for scene in table.index.get_level_values("scene")]
    return table.set_index("max_distance", append=True)


def versions_of(output: Path, plan: dict) -> dict:
    """Of the first run that has a summary; one program makes all runs of a study."""
    for key in plan["instances"]:
        for variant in plan["variants"]:
            path = output / "runs" / key / variant / "refine/summary.json"
            if path.is_file():
                return read_json(path)["versions"]
    return {}


def without_nan(value: object) -> object:
    return None if isinstance(value, float) and math.isnan(value) else value


def write_tables(output: Path) -> None:
    """results.json and the three CSV files."""
    plan = read_plan(output)
    rows = collect(output, plan)
    runs = pandas.DataFrame(rows)
    errors = errors_of(runs)
    summary = pandas.DataFrame({"average_rank": average_rank(errors),
                                "average_error": average_error(errors),
                                "average_matched": average_error(rows_of(runs, MATCHED_SHARES))})
    of_variants = runs[runs["variant"] != INITIAL]
    summary["failed"] = of_variants.groupby("variant")["failed"].count()
    for name in ("total_seconds", "memory_mib"):
        summary[name] = of_variants.reindex(columns=["variant", name]).groupby("variant")[name].mean()
    summary.index.name = "variant"
    table = ranks_of(runs, errors)
    write_if_changed(output / "runs.csv", runs.convert_dtypes().to_csv(index=False))
    write_if_changed(output / "summary.csv", summary.to_csv())
    write_if_changed(output / "ranks.csv", table.to_csv())
    write_json(output / "results.json", {
        "title": plan["title"], "versions": versions_of(output, plan),
        "runs": [{key: without_nan(value) for key, value in row.items()} for row in rows],
        "summary": json.loads(summary.reset_index().to_json(orient="records", double_precision=15)),
        "ranks": json.loads(table.reset_index().to_json(orient="records"))})
    for name in ("runs.csv", "summary.csv", "ranks.csv", "results.json"):
        (output / name).touch()  # Snakemake asks for files newer than what they are made of

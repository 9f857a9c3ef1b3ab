"""study.json in the output folder: what Snakemake and its jobs read, with every scene and variant spelt out."""

import json
import os
from dataclasses import asdict
from pathlib import Path

from study.burin_program import Burin
from study.study_file import Study
from study.variants import folder_name

PLAN = "study.json"


def make_plan(study: Study, burin: Burin) -> dict:
    """The plan of a checked study.

    instances: a scene with one of its seeds, by the name of its folder under scenes/.
    variants: by the name of their folder under runs/INSTANCE/.
    """
    instances = {}
    for name, scene in study.scenes.items():
        for seed in scene.seeds or [None]:
            key = folder_name(name) + ("" if seed is None else f"-seed{seed}")
            instances[key] = {"scene": name, "seed": seed, "first": seed == (scene.seeds or [None])[0],
                              **asdict(scene)}
            del instances[key]["seeds"]
    variants = {folder_name(name): {"name": name, "options": variant.options,
                                    "effective": variant.effective}
                for name, variant in study.variants.items()}
    return {"study": study.file, "title": study.title, "description": study.description,
            "burin": {"path": str(burin.path), "sha256": burin.sha256()},
            "instances": instances, "variants": variants}


def write_if_changed(path: Path, text: str) -> None:
    """Whole or not at all; untouched when it says so already, so that nothing is done again."""
    if path.is_file() and path.read_text(encoding="utf-8") == text:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(path.name + ".partial")
    partial.write_text(text, encoding="utf-8")
    os.replace(partial, path)


def write_json(path: Path, data: object) -> None:
    """Indented JSON; NaN is refused."""
    write_if_changed(path, json.dumps(data, indent=1, allow_nan=False) + "\n")


def read_json(path: Path) -> dict:
    """The JSON of a file."""
    return json.loads(path.read_text(encoding="utf-8"))


def read_plan(output: Path) -> dict:
    """The plan in an output folder."""
    return read_json(output / PLAN)

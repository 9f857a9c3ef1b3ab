"""Reads a study file, and finds everything that is wrong with it before any job starts."""

import difflib
import math
import re
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from study.burin_program import Burin, Options, Value, flatten
from study.errors import StudyError
from study.variants import axis_values, combined, folder_name, read_axes

FIELDS = ("title", "description", "seeds", "options", "evaluate", "scenes", "combine", "axes",
          "variants")
SCENE_FIELDS = ("synth", "seeds", "folder", "mesh", "truth", "cameras", "evaluate")
FOOTPRINT = "footprint"  # evaluate.unit of a synthetic scene: its pixel footprint
INITIAL = "initial mesh"  # a row of every report


@dataclass
class Scene:
    """A scene of a study: made by `burin synth`, or a folder with a mesh and a truth."""

    synth: Options = field(default_factory=dict)
    seeds: list[int] = field(default_factory=list)  # of a synthetic scene
    folder: str = ""  # absolute paths; empty for a synthetic scene
    mesh: str = ""
    truth: str = ""
    cameras: str = ""  # true ones, where a scene with a folder has such
    evaluate: Options = field(default_factory=dict)


@dataclass
class Variant:
    """What is compared: the options given to `burin refine`, and all of them with the defaults."""

    options: Options
    effective: Options


@dataclass
class Study:
    """A study that can be run."""

    file: str
    title: str
    description: str
    scenes: dict[str, Scene]
    variants: dict[str, Variant]


class _Reader:
    """One study file; methods raise StudyError with the file and the field."""

    def __init__(self, path: Path, burin: Burin):
        self.path = path
        self.burin = burin

    def fail(self, where: str, reason: str) -> StudyError:
        return StudyError(self.path, where, reason)

    def known(self, table: dict, fields: tuple[str, ...], prefix: str = "") -> None:
        for key in table:
            if key not in fields:
                near = difflib.get_close_matches(key, fields, 1)
                hint = f" (did you mean {near[0]}?)" if near else f"; known are {', '.join(fields)}"
                raise self.fail(prefix + key, "unknown field" + hint)

    def table(self, parent: dict, key: str, prefix: str = "") -> dict:
        value = parent.get(key, {})
        if not isinstance(value, dict):
            raise self.fail(prefix + key, "must be a table")
        return value

    def text(self, parent: dict, key: str, prefix: str = "", default: str | None = None) -> str:
        value = parent.get(key, default)
        if value is None:
            raise self.fail(prefix + key, "missing")
        if not isinstance(value, str):
            raise self.fail(prefix + key, "must be text")
        return value

    def options(self, command: str, options: Options, where: Callable[[str], str]) -> Options:
        """All options of burin's command with these; burin itself says what is wrong with them.

        `where` says which field of the file sets an option ("" = none in particular).
        """
        for key, value in options.items():
            if not isinstance(value, (bool, int, float, str)):
                raise self.fail(where(key), "must be true, false, a number or text")
            if isinstance(value, float) and not math.isfinite(value):
                raise self.fail(where(key), "must be a finite number")
            if key not in self.burin.defaults(command):
                near = difflib.get_close_matches(key, self.burin.defaults(command), 1)
                hint = f" (did you mean {near[0]}?)" if near else ""
                raise self.fail(where(key), f"not an option of burin {command}{hint}")
        try:
            return self.burin.config(command, options)
        except ValueError as error:
            named = re.match(r"(?:--)?([a-z_.]+)", str(error))
            field_name = where(named[1] if named and named[1] in options else "")
            raise self.fail(field_name, f"burin {command} refuses it: {error}") from None

    def seeds(self, parent: dict, prefix: str, default: list[int]) -> list[int]:
        seeds = parent.get("seeds", default)
        if not isinstance(seeds, list) or not seeds or len(set(map(str, seeds))) < len(seeds):
            raise self.fail(prefix + "seeds", "must be a list of different whole numbers")
        for seed in seeds:
            if isinstance(seed, bool) or not isinstance(seed, int):
                raise self.fail(prefix + "seeds", "must be a list of different whole numbers")
            self.options("synth", {"synth.seed": seed}, lambda _: prefix + "seeds")
        return seeds

    def existing(self, parent: dict, key: str, prefix: str, folder: bool) -> str:
        path = (self.path.parent / self.text(parent, key, prefix)).resolve()
        if not (path.is_dir() if folder else path.is_file()):
            raise self.fail(prefix + key, f"{path}: no such {'folder' if folder else 'file'}")
        return str(path)

    def paths_from_here(self, options: Options) -> Options:
        """Options that name files, relative to the study file."""
        return {key: str((self.path.parent / value).resolve())
                if key in ("pairs.file", "synth.mesh_path") and isinstance(value, str) and value
                else value for key, value in options.items()}

    def evaluate_options(self, options: Options, where: str, synthetic: bool) -> Options:
        """These options, with tau and unit always among them."""
        checked = dict(options)
        if checked.get("unit") == FOOTPRINT:
            if not synthetic:
                raise self.fail(f"{where}.unit", f"{FOOTPRINT} is known of synthetic scenes only")
            checked["unit"] = 1.0
        effective = self.options("evaluate", checked, lambda key: f"{where}.{key}" if key else where)
        return {"tau": effective["tau"], "unit": effective["unit"]} | options

    def scene(self, table: dict, where: str, seeds: list[int], evaluate: Options) -> Scene:
        prefix = where + "."
        self.known(table, SCENE_FIELDS, prefix)
        own = flatten(self.table(table, "evaluate", prefix))
        scene = Scene()
        if "folder" in table:
            for key in ("synth", "seeds"):
                if key in table:
                    raise self.fail(prefix + key, "belongs to synthetic scenes; this one has a folder")
            scene.folder = self.existing(table, "folder", prefix, True)
            scene.mesh = self.existing(table, "mesh", prefix, False)
            scene.truth = self.existing(table, "truth", prefix, False)
            if "cameras" in table:
                scene.cameras = self.existing(table, "cameras", prefix, True)
        else:
            for key in ("mesh", "truth", "cameras"):
                if key in table:
                    raise self.fail(prefix + key, "belongs to scenes with a folder")
            scene.synth = self.paths_from_here(
                flatten({"synth": self.table(table, "synth", prefix)}))
            if "synth.seed" in scene.synth:
                raise self.fail(prefix + "synth.seed", "is set by seeds")
            self.options("synth", scene.synth, lambda key: prefix + key if key else where)
            scene.seeds = self.seeds(table, prefix, seeds)
        scene.evaluate = self.evaluate_options(evaluate | own, prefix + "evaluate", not scene.folder)
        return scene

    def scenes(self, data: dict) -> dict[str, Scene]:
        seeds = self.seeds(data, "", [1])
        evaluate = flatten(self.table(data, "evaluate"))
        self.evaluate_options(evaluate, "evaluate", True)
        scenes = {}
        for name, table in self.table(data, "scenes").items():
            self.name(name, "scenes")
            scenes[name] = self.scene(self.table(data["scenes"], name, "scenes."),
                                      f"scenes.{name}", seeds, evaluate)
        if not scenes:
            raise self.fail("scenes", "has none; a study needs at least one [scenes.NAME]")
        return scenes

    def name(self, name: str, where: str) -> None:
        if folder_name(name) != name.replace(" ", "_") or not name[:1].isalnum() or name == INITIAL:
            raise self.fail(f"{where}.{name}", "a name is letters, digits, spaces and ._=+- , "
                            "begins with a letter or digit, and is not '" + INITIAL + "'")

    def axes(self, data: dict, combine: str) -> dict[str, list[Value]]:
        axes = {}
        for key, axis in read_axes(self.table(data, "axes")).items():
            try:
                axes[key] = axis_values(axis)
            except ValueError as error:
                raise self.fail(f"axes.{key}", str(error)) from None
        lengths = {key: len(values) for key, values in axes.items()}
        if combine == "zip" and len(set(lengths.values())) > 1:
            raise self.fail("axes", "zip needs axes of one length, not " +
                            ", ".join(f"{key} {count}" for key, count in lengths.items()))
        return axes

    def variants(self, data: dict) -> dict[str, Variant]:
        base = flatten(self.table(data, "options"))
        combine = self.text(data, "combine", default="product")
        if combine not in ("product", "zip"):
            raise self.fail("combine", "must be product or zip")
        axes = self.axes(data, combine)
        named = {}
        for name in self.table(data, "variants"):
            self.name(name, "variants")
            named[name] = flatten(self.table(data["variants"], name, "variants."))
        if not axes and not named:
            raise self.fail("variants", "there are none; give [axes] or [variants.NAME]")
        found: dict[str, Variant] = {}
        for label, name, point in combined(axes, combine, list(named)):
            own = named.get(name, {})

            def where(key: str) -> str:
                for place, options in (("axes", axes), (f"variants.{name}", own), ("options", base)):
                    if key in options:
                        return f"{place}.{key}"
                return f"variant {label}"

            if folder_name(label) in map(folder_name, found):
                raise self.fail("variants", f"two are called {label}")
            options = self.paths_from_here(base | own | point)
            found[label] = Variant(options, self.options("refine", options, where))
        return found


def read_study(path: Path, burin: Burin, folder_scene: dict | None = None) -> Study:
    """The study in a TOML file. `folder_scene`: folder, mesh, truth and evaluate given beside it.

    Raises StudyError for anything wrong with the file, its options or the files it names.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise StudyError(path, "", f"cannot be read: {reason}") from None
    except tomllib.TOMLDecodeError as error:
        raise StudyError(path, "", str(error)) from None
    reader = _Reader(path, burin)
    reader.known(data, FIELDS)
    if folder_scene:
        name = folder_name(Path(folder_scene["folder"]).resolve().name) or "scene"
        added = {key: str(Path(folder_scene[key]).resolve()) for key in ("folder", "mesh", "truth")}
        added["evaluate"] = folder_scene["evaluate"]
        data["scenes"] = reader.table(data, "scenes")
        if name in data["scenes"]:
            raise reader.fail(f"scenes.{name}", "is also the name of the folder given")
        data["scenes"][name] = added
    return Study(file=str(path.resolve()), title=reader.text(data, "title"),
                 description=reader.text(data, "description", default=""),
                 scenes=reader.scenes(data), variants=reader.variants(data))

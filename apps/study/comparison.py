"""compare.csv of `burin compare-solvers`: read, checked and drawn as SVG files beside it."""

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from study import charts
from study.errors import StudyError
from study.plan import write_if_changed

CSV = "compare.csv"
MODES = ("frozen", "whole")
Round = tuple[int, int]  # level, round


@dataclass(frozen=True)
class Row:
    """One iteration of one strategy: a line of the file that has no note."""

    strategy: str
    round: Round
    width: int | None  # of the round's first view; the sizes are None where a whole run broke off
    height: int | None
    faces: int | None
    unknowns: int | None
    pairs: int
    evaluations: int
    seconds: float
    energy: float  # not finite where the solver's is not; such a point is not drawn
    rmse: float  # NaN where it was not measured


@dataclass(frozen=True)
class Comparison:
    """The file: its mode, its iterations, and the strategies' rounds that have no result."""

    mode: str
    strategies: list[str]  # in the order of the file, also those that have no result
    rows: list[Row]
    failed: set[tuple[str, Round]]

    def solved_rounds(self) -> dict[Round, list[Row]]:
        """The rows of each round that some strategy solved, in the order of the file."""
        rounds: dict[Round, list[Row]] = {}
        for row in self.rows:
            rounds.setdefault(row.round, []).append(row)
        return {one: rows for one, rows in rounds.items()
                if any((row.strategy, one) not in self.failed for row in rows)}


class Line:
    """A line of the file whose fields are taken one by one."""

    def __init__(self, file: Path, number: int, fields: dict[str, str]):
        self.file, self.number, self.fields = file, number, fields

    def error(self, field: str, reason: str) -> StudyError:
        """What is wrong with a field of this line."""
        return StudyError(self.file, field, f"line {self.number}: {reason}")

    def text(self, field: str) -> str:
        """A field that may not be empty."""
        if not self.fields[field]:
            raise self.error(field, "is empty")
        return self.fields[field]

    def count(self, field: str) -> int:
        """A whole number from 0 on."""
        text = self.text(field)
        if not (text.isascii() and text.isdigit() and len(text) < 19):
            raise self.error(field, f"{text!r} is not a whole number from 0 on")
        return int(text)

    def number_of(self, field: str) -> float:
        """Any number."""
        try:
            return float(self.text(field))
        except ValueError:
            raise self.error(field, f"{self.fields[field]!r} is not a number") from None

    def size(self, field: str) -> int | None:
        """A whole number, or in mode whole nothing."""
        return self.count(field) if self.fields[field] or self.fields["mode"] == "frozen" else None

    def round(self) -> Round:
        """Its level and round."""
        return self.count("level"), self.count("round")

    def row(self) -> Row:
        """The line as an iteration."""
        row = Row(strategy=self.text("strategy"), round=self.round(),
                  width=self.size("width"), height=self.size("height"),
                  faces=self.size("faces"), unknowns=self.size("unknowns"),
                  pairs=self.count("pairs"), evaluations=self.count("evaluations"),
                  seconds=self.number_of("seconds"), energy=self.number_of("energy"),
                  rmse=self.number_of("rmse") if self.fields["rmse"] else math.nan)
        if not (math.isfinite(row.seconds) and row.seconds >= 0):
            raise self.error("seconds", f"{row.seconds:g} is no duration")
        return row


def read_lines(file: Path) -> list[Line]:
    """The lines below the heading, each with all of its fields."""
    wanted = ("mode", "strategy", "level", "round", "width", "height", "faces", "unknowns", "pairs",
              "evaluations", "seconds", "energy", "rmse", "note")
    try:
        with open(file, encoding="utf-8", newline="") as stream:
            reader = csv.DictReader(stream, strict=True)
            for name in wanted:
                if name not in (reader.fieldnames or ()):
                    raise StudyError(file, name, "there is no such column; "
                                                 "is it of burin compare-solvers?")
            lines = []
            for fields in reader:
                if None in fields or None in fields.values():
                    raise StudyError(file, "", f"line {reader.line_num}: does not have "
                                               f"{len(reader.fieldnames)} fields")
                lines.append(Line(file, reader.line_num, fields))
    except OSError as error:
        raise StudyError(file, "", f"cannot be read: {error.strerror}") from None
    except (csv.Error, UnicodeDecodeError) as error:
        raise StudyError(file, "", f"is not CSV: {error}") from None
    return lines


def read_comparison(file: Path) -> Comparison:
    """The file, checked. Raises StudyError."""
    mode = ""
    rows: list[Row] = []
    failed: set[tuple[str, Round]] = set()
    names: dict[str, None] = {}
    for line in read_lines(file):
        mode = mode or line.text("mode")
        if line.fields["mode"] not in MODES or line.fields["mode"] != mode:
            raise line.error("mode", f"{line.fields['mode']!r} must be {' or '.join(MODES)}, "
                                     "the same in all lines")
        names[line.text("strategy")] = None
        if not line.fields["note"]:
            rows.append(line.row())
        elif mode == "frozen":
            failed.add((line.fields["strategy"], line.round()))
    comparison = Comparison(mode, list(names), rows, failed)
    if not comparison.solved_rounds():
        raise StudyError(file, "", "no strategy in it has a result: nothing to draw")
    return comparison


def fall(rows: list[Row], failed: set[tuple[str, Round]]) -> float:
    """How far the best strategy takes a round's energy down, as a share of the start."""
    solved = [row for row in rows if (row.strategy, row.round) not in failed]
    last = {row.strategy: row.energy for row in solved}
    start = solved[0].energy
    return 1 - min(last.values()) / start if start > 0 else 0


def panels(rows: list[Row], cut: bool) -> list[list[charts.Panel]]:
    """Energy and, where it was measured, error, each against evaluations and seconds."""
    across = {"evaluations": lambda row: row.evaluations, "seconds of solving": lambda row: row.seconds}
    up = {"energy": lambda row: row.energy, "RMSE to truth, world units": lambda row: row.rmse}
    if all(math.isnan(row.rmse) for row in rows):
        del up["RMSE to truth, world units"]
    by_strategy: dict[str, list[Row]] = {}
    for row in rows:
        by_strategy.setdefault(row.strategy, []).append(row)
    return [[charts.Panel(x_label, y_label, cut=cut, curves={
        name: [(x(row), y(row)) for row in of_one] for name, of_one in by_strategy.items()})
        for x_label, x in across.items()] for y_label, y in up.items()]


def figures(comparison: Comparison) -> Iterator[tuple[str, Figure]]:
    """The charts with their file names, compare.svg first; each is made when it is asked for.

    Mode whole has this one, over the whole run. Mode frozen has one a round, and compare.svg is that
    of the round whose energy falls most, as a share of its start.
    """
    # One that was refused keeps its colour, so that comparisons of the same strategies look alike.
    styles = charts.curve_styles(comparison.strategies)
    if comparison.mode == "whole":
        yield "compare.svg", charts.strategies(
            "Whole runs of each strategy",
            "energies of different rounds and strategies do not compare (own visibility); "
            f"{comparison.rows[0].pairs} pairs", panels(comparison.rows, cut=False), styles)
        return

    def of_round(rows: list[Row]) -> Figure:
        first = rows[0]
        level, number = first.round
        return charts.strategies(
            f"Strategies on one frozen round: level {level} ({first.width}x{first.height}), "
            f"round {number + 1}",
            f"{first.faces} faces, {first.unknowns} unknowns, {first.pairs} pairs; the same vertices "
            "at the start; a mark an iteration", panels(rows, cut=True), styles)

    rounds = comparison.solved_rounds()
    most = max(rounds.values(), key=lambda rows: fall(rows, comparison.failed))
    yield "compare.svg", of_round(most)
    for (level, number), rows in rounds.items():
        yield f"rounds/level{level}_round{number}.svg", of_round(rows)


def draw_comparison(folder: Path) -> list[Path]:
    """Draws the folder's compare.csv into it; the files written. Raises StudyError."""
    written = []
    for name, figure in figures(read_comparison(folder / CSV)):
        try:
            write_if_changed(folder / name, charts.svg_of(figure))
        except OSError as error:
            raise StudyError(folder / name, "", f"cannot be written: {error.strerror}") from None
        written.append(folder / name)
    return written

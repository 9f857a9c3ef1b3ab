"""Charts of compare-solvers: what is drawn of a compare.csv, and that a wrong one is one line."""

import csv
import json
import subprocess
import sys
import xml.etree.ElementTree
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import ROOT, burin_program
from study import charts
from study.comparison import Comparison, draw_comparison, figures, read_comparison

HEADING = ("mode,strategy,level,round,width,height,faces,unknowns,pairs,iteration,evaluations,seconds,"
           "energy,rmse,accepted,note")
SOLVERS = ["lbfgs", "lm_pcg", "dogleg"]


def burin(*arguments: object) -> None:
    """Runs the program under test, which must succeed."""
    done = subprocess.run([burin_program(), *map(str, arguments)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def draw(folder: Path) -> subprocess.CompletedProcess:
    """`apps/study charts`."""
    return subprocess.run([sys.executable, str(ROOT / "apps/study"), "charts", str(folder)],
                          capture_output=True, text=True, check=False)


@pytest.fixture(name="scene", scope="module")
def tiny_scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scene")
    burin("synth", "--output", folder, "--synth.width", 96, "--synth.height", 72, "--synth.views", 4,
          "--synth.truth_point_count", 1000)
    return folder


def compared(scene: Path, folder: Path, *more: object) -> Path:
    """The folder of a real comparison, two levels of one round."""
    burin("compare-solvers", scene, "--mesh", scene / "init.ply", "--output", folder, "--level.count", 2,
          "--level.rounds", 1, "--level.extra_rounds", 0, "--level.min_side_px", 1,
          "--solver.max_iterations", 4, "--solvers", ",".join(SOLVERS), *more)
    return folder


def table(folder: Path, *lines: str) -> Path:
    """A compare.csv by hand."""
    file = folder / "compare.csv"
    file.write_text("\n".join((HEADING, *lines)) + "\n", encoding="utf-8")
    return file


def line(strategy: str, evaluations: int, energy: object, rmse: object = "", at: str = "0,0",
         mode: str = "frozen") -> str:
    """An iteration; its seconds are a tenth of the evaluations."""
    return (f"{mode},{strategy},{at},96,72,200,100,12,{evaluations - 1},{evaluations},"
            f"{evaluations / 10},{energy},{rmse},1,")


def refusal(strategy: str, at: str = "0,0") -> str:
    return f'frozen,{strategy},{at},96,72,200,100,12,,,,,,,"refused: ""too many"", it says"'


def charts_of(comparison: Comparison) -> dict[str, charts.plt.Figure]:
    """The charts by file name."""
    return dict(figures(comparison))


@pytest.fixture(autouse=True)
def no_figure_stays_open() -> Iterator[None]:
    yield
    charts.plt.close("all")


def drawn(axes: charts.plt.Axes) -> dict[str, list[tuple[float, float]]]:
    """The curves by label."""
    return {curve.get_label(): list(zip(*curve.get_data())) for curve in axes.get_lines()}


def texts(figure: charts.plt.Figure) -> str:
    return " ".join(text.get_text() for text in figure.texts)


def test_frozen_rounds_of_a_real_comparison(scene: Path, tmp_path: Path) -> None:
    folder = compared(scene, tmp_path, "--truth", scene / "truth.ply", "--sample_count", 2000)
    pages = charts_of(read_comparison(folder / "compare.csv"))
    assert list(pages) == ["compare.svg", "rounds/level1_round0.svg", "rounds/level0_round0.svg"]
    with open(folder / "compare.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    rounds = json.loads((folder / "compare.json").read_text())["strategies"][0]["rounds"]
    for one in rounds:
        page = pages[f"rounds/level{one['level']}_round{one['round']}.svg"]
        assert [(axes.get_xlabel(), axes.get_ylabel()) for axes in page.axes] == [
            ("evaluations", "energy"), ("seconds of solving", "energy"),
            ("evaluations", "RMSE to truth, world units"),
            ("seconds of solving", "RMSE to truth, world units")]
        for axes, x, y in zip(page.axes, ("evaluations", "seconds") * 2, ("energy", "energy", "rmse", "rmse")):
            curves = drawn(axes)
            assert list(curves) == SOLVERS
            for name, points in curves.items():
                assert points == [(float(row[x]), float(row[y])) for row in rows
                                  if (row["strategy"], row["level"]) == (name, str(one["level"]))]
        assert [text.get_text() for text in page.legends[0].get_texts()] == SOLVERS
        assert len({curve.get_color() for curve in page.axes[0].get_lines()}) == len(SOLVERS)
        for part in (f"level {one['level']} ({one['image'][0]}x{one['image'][1]}), round 1",
                     f"{one['faces']} faces, {one['unknowns']} unknowns"):
            assert part in texts(page)
    # The main chart: of the round whose energy falls most as a share, which the coarse one does.
    assert texts(pages["compare.svg"]) == texts(pages["rounds/level1_round0.svg"])


def test_the_command_writes_svg_and_the_same_again(scene: Path, tmp_path: Path) -> None:
    folder = compared(scene, tmp_path)
    done = draw(folder)
    assert (done.returncode, done.stderr) == (0, "")
    files = {path: path.read_bytes() for path in sorted(folder.rglob("*.svg"))}
    assert [str(path.relative_to(folder)) for path in files] == [
        "compare.svg", "rounds/level0_round0.svg", "rounds/level1_round0.svg"]
    assert str(folder / "compare.svg") in done.stdout
    for text in files.values():
        assert xml.etree.ElementTree.fromstring(text).tag == "{http://www.w3.org/2000/svg}svg"
    assert files[folder / "compare.svg"] == files[folder / "rounds/level1_round0.svg"]
    for path in files:
        path.unlink()
    assert draw(folder).returncode == 0
    assert {path: path.read_bytes() for path in files} == files
    # Without a truth there is no error to draw.
    page = charts_of(read_comparison(folder / "compare.csv"))["compare.svg"]
    assert [axes.get_ylabel() for axes in page.axes] == ["energy", "energy"]


def test_whole_runs_are_one_chart_over_all_rounds(scene: Path, tmp_path: Path) -> None:
    folder = compared(scene, tmp_path, "--compare.mode", "whole", "--truth", scene / "truth.ply",
                      "--compare.error", "round", "--sample_count", 2000)
    pages = charts_of(read_comparison(folder / "compare.csv"))
    assert list(pages) == ["compare.svg"]
    with open(folder / "compare.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["level"] for row in rows} == {"0", "1"}
    energies, _, errors, _ = map(drawn, pages["compare.svg"].axes)
    for name in SOLVERS:
        assert len(energies[name]) == sum(row["strategy"] == name for row in rows)
        assert len(errors[name]) == 2 * 2, "start and end of each round"
    assert "own visibility" in texts(pages["compare.svg"])


def test_rounds_and_strategies_without_a_result(tmp_path: Path) -> None:
    comparison = read_comparison(table(
        tmp_path, line("a", 1, 100, at="1,0"), line("a", 2, 90, at="1,0"), line("b", 1, 100, at="1,0"),
        line("b", 2, 1, at="1,0"), line("a", 1, 50), line("a", 2, 40), line("b", 1, 50, at="0,1"),
        refusal("b", "1,0"), refusal("b"), refusal("b", "0,1"), refusal("c"), refusal("c", "1,0")))
    pages = charts_of(comparison)
    assert list(pages) == ["compare.svg", "rounds/level1_round0.svg", "rounds/level0_round0.svg"]
    # b broke off at level 1: its iterations are drawn, but are not how far the round falls.
    assert list(drawn(pages["rounds/level1_round0.svg"].axes[0])) == ["a", "b"]
    assert list(drawn(pages["compare.svg"].axes[0])) == ["a"]
    assert "level 0" in texts(pages["compare.svg"])
    # A strategy without a result keeps its colour, so that two comparisons look alike.
    page = charts_of(read_comparison(table(tmp_path, refusal("a"), line("b", 1, 100))))["compare.svg"]
    assert page.axes[0].get_lines()[0].get_color() == charts.colors(["a", "b"])["b"]


def test_axes_are_logarithmic_where_values_spread(tmp_path: Path) -> None:
    page = charts_of(read_comparison(table(
        tmp_path, line("a", 1, 100, 1), line("a", 9, 20, 0.5), line("b", 1, 100, 1), line("b", 2, "nan", ""),
        line("b", 3, 90, 0.5))))["compare.svg"]
    energy, _, error, _ = page.axes
    assert (energy.get_xscale(), energy.get_yscale(), error.get_yscale()) == ("log", "log", "linear")
    assert drawn(energy)["b"] == [(1, 100), (3, 90)], "what is not finite is left out"
    page.canvas.draw()
    ticks = [text.get_text() for text in energy.get_xticklabels()]
    assert [tick for tick in ticks if 1 <= float(tick) <= 9] == ["1", "2", "5"]
    page = charts_of(read_comparison(table(
        tmp_path, line("a", 1, 5), line("a", 9, 0))))["compare.svg"]
    assert page.axes[0].get_yscale() == "linear", "a zero cannot be shown"


def test_a_curve_that_explodes_leaves_through_the_top(tmp_path: Path) -> None:
    lines = [line("falls", 1, 100), line("falls", 2, 80), line("explodes", 1, 100), line("explodes", 2, 9e9)]
    page = charts_of(read_comparison(table(tmp_path, *lines)))["compare.svg"]
    low, high = page.axes[0].get_ylim()
    assert 78 < low < 80 and 110 < high < 112
    assert page.axes[0].get_yscale() == "linear"
    assert drawn(page.axes[0])["explodes"][-1] == (2, 9e9)
    whole = charts_of(read_comparison(table(tmp_path, *(one.replace("frozen", "whole") for one in lines))))
    assert whole["compare.svg"].axes[0].get_ylim()[1] > 9e9


def test_one_value_or_twenty_strategies_are_drawn(tmp_path: Path) -> None:
    for value in (0, 5, -3e8, 1e-12):
        page = charts_of(read_comparison(table(tmp_path, line("a", 1, value))))["compare.svg"]
        assert "</svg>" in charts.svg_of(page)
    names = [f"solver{k}" for k in range(20)]
    page = charts_of(read_comparison(table(tmp_path, *(line(name, 1, 5) for name in names))))["compare.svg"]
    curves = page.axes[0].get_lines()
    assert len({(charts.css(curve.get_color()), curve.get_linestyle(), curve.get_marker())
                for curve in curves}) == len(names)


def test_one_figure_is_open_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    svg_of, open_figures = charts.svg_of, []

    def counted(figure: charts.plt.Figure) -> str:
        open_figures.append(len(charts.plt.get_fignums()))
        return svg_of(figure)

    monkeypatch.setattr(charts, "svg_of", counted)
    table(tmp_path, line("a", 1, 5), line("a", 1, 5, at="0,1"))
    assert len(draw_comparison(tmp_path)) == 3
    assert open_figures == [1, 1, 1]


GOOD = line("a", 1, 5)


@pytest.mark.parametrize(("text", "field", "reason"), [
    (None, "", "cannot be read: No such file"),
    ("", "mode", "no such column"),
    (HEADING.replace(",energy", "") + "\n" + GOOD, "energy", "no such column"),
    (HEADING, "", "nothing to draw"),
    (HEADING + "\n" + refusal("a"), "", "nothing to draw"),
    (HEADING + f"\n{GOOD}\n{refusal('a')}", "", "nothing to draw"),
    (HEADING + f"\n{GOOD}\n{GOOD},", "", "line 3: does not have 16 fields"),
    (HEADING + f"\n{GOOD}\nfrozen,a", "", "line 3: does not have 16 fields"),
    (HEADING + f"\n{GOOD}\n" + line("a", 2, "low"), "energy", "line 3: 'low' is not a number"),
    (HEADING + "\n" + line("a", 2, ""), "energy", "line 2: is empty"),
    (HEADING + "\n" + GOOD.replace(",200,", ",,"), "faces", "line 2: is empty"),
    (HEADING + "\n" + line("", 2, 1), "strategy", "line 2: is empty"),
    (HEADING + "\n" + line("a", 2, 1, "?"), "rmse", "line 2: '?' is not a number"),
    (HEADING + "\n" + line("a", 2, 1, at="0,-1"), "round", "line 2: '-1' is not a whole number"),
    (HEADING + "\n" + line("a", 2, 1, at="../x,1"), "level", "'../x' is not a whole number"),
    (HEADING + "\n" + line("a", 2, 1).replace("0.2", "-0.2"), "seconds", "line 2: -0.2 is no duration"),
    (HEADING + f"\n{GOOD}\n" + line("a", 2, 1, mode="whole"), "mode", "line 3: 'whole' must be"),
    (HEADING + "\n" + line("a", 2, 1, mode="both"), "mode", "frozen or whole"),
    (HEADING + '\nfrozen,"a' + GOOD, "", "is not CSV"),
    (HEADING + "\n\udcff", "", "is not CSV"),
])
def test_a_wrong_file_is_one_line_with_file_field_and_reason(
        tmp_path: Path, text: str | None, field: str, reason: str) -> None:
    file = tmp_path / "compare.csv"
    if text is not None:
        file.write_bytes(text.encode("utf-8", "surrogateescape"))
    done = draw(tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done
    assert done.stderr.startswith(f"study: error: {file}: {field}: " if field else
                                  f"study: error: {file}: "), done.stderr
    assert reason in done.stderr
    assert not list(tmp_path.rglob("*.svg"))


def test_a_folder_that_cannot_be_written_to(tmp_path: Path) -> None:
    table(tmp_path, GOOD)
    (tmp_path / "rounds").write_text("in the way", encoding="utf-8")
    done = draw(tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert "rounds/level0_round0.svg: cannot be written" in done.stderr

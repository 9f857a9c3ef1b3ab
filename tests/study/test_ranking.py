"""Average rank and average error value against the table that the paper prints."""

from pathlib import Path

import pandas
import pytest
from study.ranking import ERROR_MEASURES, average_error, average_rank, ranks


@pytest.fixture(name="dtu")
def dtu_table() -> pandas.DataFrame:
    path = Path(__file__).parent / "dtu_table.csv"
    return pandas.read_csv(path, comment="#").set_index(["scene", "measure"])


def test_the_table_has_the_rows_of_twelve_scenes(dtu: pandas.DataFrame) -> None:
    assert dtu.shape == (48, 5)
    assert set(dtu.index.get_level_values("measure")) == set(ERROR_MEASURES)


def test_average_error_of_the_paper(dtu: pandas.DataFrame) -> None:
    errors = average_error(dtu)
    assert round(errors["proposed"], 4) == 0.4212  # printed, table of the ablation
    assert round(errors["vu"], 4) == 0.4271  # not printed; from the same table


def test_ranks_of_a_row_and_ties(dtu: pandas.DataFrame) -> None:
    row = ranks(dtu).loc[(36, "accuracy_median")]  # .2317 .2778 .2007 .1831 .1831
    assert row.to_dict() == {"campbell": 4, "furukawa": 5, "tola": 3, "vu": 1, "proposed": 1}
    assert average_rank(dtu)["proposed"] == average_rank(dtu).min()


def test_a_method_that_failed_has_no_average() -> None:
    errors = pandas.DataFrame({"a": [1.0, 2.0], "b": [2.0, None], "c": [3.0, 1.0]})
    assert ranks(errors).loc[0].to_list() == [1, 2, 3]
    assert average_rank(errors).isna().to_list() == [False, True, False]
    assert average_error(errors).isna().to_list() == [False, True, False]
    assert average_rank(errors)["a"] == 1.5

"""The two figures by which the ablation of Romanoni & Matteucci, "Mesh-based Camera
Pairs Selection and Occlusion-Aware Masking for Mesh Refinement", compares methods.

Both take a table of errors. It has a row for each error measure of each scene (in the paper: accuracy and
completeness, mean and median, of 12 scenes) and a column for each method. A method that failed in some
row has no value there. It gets no average, and no rank in that row.
"""

import pandas

# The rows that a scene contributes.
ERROR_MEASURES = ("accuracy_mean", "accuracy_median", "completeness_mean", "completeness_median")

# Of each: the share of the points that it is over. Whoever matches fewer has a better mean.
MATCHED_SHARES = {measure: measure.split("_", maxsplit=1)[0] + "_matched" for measure in ERROR_MEASURES}


def ranks(errors: pandas.DataFrame) -> pandas.DataFrame:
    """The rank of each method in each row, 1 = smallest error; ties take the minimum rank."""
    return errors.rank(axis="columns", method="min")


def average_rank(errors: pandas.DataFrame) -> pandas.Series:
    """Average Position: of each method, the mean of its ranks over the rows."""
    return ranks(errors).mean(skipna=False)


def average_error(errors: pandas.DataFrame) -> pandas.Series:
    """Average Error Value: of each method, the mean of its errors over the rows."""
    return errors.mean(skipna=False)

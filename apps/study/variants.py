"""Axes and named variants become the variants of a study: each is a name and the options that it sets."""

import math
from collections.abc import Iterator
from itertools import product

from study.burin_program import Options, Value, flatten, text_of

MOST_VALUES = 1000
RANGE_KEYS = {"from", "to", "step", "factor"}


def is_axis(value: object) -> bool:
    """Whether a value under [axes] is an axis itself, not a group of them."""
    return not isinstance(value, dict) or "from" in value


def range_values(table: dict) -> list[Value]:
    """{from, to, step} or {from, to, factor} -> the values, both ends included. Raises ValueError."""
    unknown = set(table) - RANGE_KEYS
    if unknown:
        raise ValueError(f"a range has from, to and step or factor, not {sorted(unknown)[0]}")
    if "to" not in table or ("step" in table) == ("factor" in table):
        raise ValueError("a range needs from, to and one of step and factor")
    for key, value in table.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise ValueError(f"{key} of a range must be a number")
    first, last = table["from"], table["to"]
    if "step" in table:
        step = table["step"]
        count = (last - first) / step if step else -1
    else:
        factor = table["factor"]
        fits = factor > 0 and factor != 1 and first != 0 and last / first > 0
        count = math.log(last / first) / math.log(factor) if fits else -1
    if not 0 <= count < MOST_VALUES:
        raise ValueError(f"the range does not lead from {first} to {last} in at most {MOST_VALUES} values")
    steps = range(math.floor(count + 1e-9) + 1)
    if "step" in table:
        return [first + k * step for k in steps]
    return [first * factor**k for k in steps]


def axis_values(axis: object) -> list[Value]:
    """The values of one axis, given as a list or a range. Raises ValueError."""
    values = range_values(axis) if isinstance(axis, dict) else axis
    if not isinstance(values, list):
        raise ValueError("must be a list of values, or a range {from, to, step or factor}")
    if not values:
        raise ValueError("has no values")
    texts = [text_of(value) for value in values]
    if len(set(texts)) < len(texts):
        raise ValueError("has a value twice")
    return values


def read_axes(table: dict) -> dict[str, object]:
    """The [axes] table -> option: list or range, unchecked."""
    return flatten(table, is_axis)


def combined(axes: dict[str, list[Value]], combine: str, named: list[str]
             ) -> Iterator[tuple[str, str, Options]]:
    """(label, named variant or "", axes' values) of every variant: each named one at each point.

    combine = "product" takes all combinations of the axes' values, "zip" their first values, their
    second ones, ... The label is the named variant's name, then option=value of each axis.
    """
    if not axes:
        points: list[tuple[Value, ...]] = [()]
    else:
        points = list(zip(*axes.values()) if combine == "zip" else product(*axes.values()))
    for name in named or [""]:
        for values in points:
            point = dict(zip(axes, values))
            parts = [name] if name else []
            parts += [f"{key}={text_of(value)}" for key, value in point.items()]
            yield " ".join(parts), name, point


def folder_name(name: str) -> str:
    """A variant's or scene's name as a folder's name."""
    return "".join(c if c.isalnum() or c in "._=+-" else "_" for c in name)

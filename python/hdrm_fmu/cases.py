"""Tables of cases for `sweep`: one row for each run, one column for each parameter."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas

from hdrm_fmu.errors import BadInput
from hdrm_fmu.names import whole


def grid(**values: Any) -> pandas.DataFrame:
    """All combinations of values; a name with a dot is given as `grid(**{"hdrm.inertia_scale": [0.8, 1.2], "mode": [...]})`."""
    lists = {name: [of] if np.isscalar(of) else list(of) for name, of in values.items()}
    for name, of in lists.items():
        if not of:
            raise BadInput(f"`{name}` has no values")
    return pandas.DataFrame(list(itertools.product(*lists.values())), columns=list(lists))


def random(count: int, seed: int, distributions: Mapping[str, object]) -> pandas.DataFrame:
    """`count` cases drawn by `seed`.

    A distribution is a pair (low, high), even between both; a list of values, each as likely; or a frozen distribution of `scipy.stats`.
    Each column has a stream of its own, which depends on the seed and the column's name alone.
    """
    count, seed = whole("count", count, 1), whole("seed", seed, 0)
    if not distributions:
        raise BadInput("there are no distributions")
    columns = {}
    for name, of in distributions.items():
        source = np.random.default_rng([seed, *name.encode()])
        if hasattr(of, "rvs"):
            columns[name] = of.rvs(size=count, random_state=source)
        elif isinstance(of, tuple) and len(of) == 2:
            if not of[0] < of[1]:
                raise BadInput(f"`{name}` between {of[0]} and {of[1]}: the first must be less than the second")
            columns[name] = source.uniform(*of, size=count)
        elif isinstance(of, list) and of:
            columns[name] = [of[k] for k in source.integers(len(of), size=count)]
        else:
            raise BadInput(f"`{name}`: {of!r} must be a pair (low, high), a list of values, or a distribution of scipy.stats")
    return pandas.DataFrame(columns)


def rows(table):
    """The rows as dictionaries of plain Python values."""
    if not isinstance(table, pandas.DataFrame):
        raise BadInput(f"cases must be a pandas.DataFrame, as `grid` and `random` make them, not {type(table).__name__}")
    if table.empty:
        raise BadInput("there are no cases")
    if not table.columns.is_unique:
        raise BadInput(f"the column `{table.columns[table.columns.duplicated()][0]}` is there twice")
    empty = np.argwhere(table.isna().to_numpy())
    if len(empty):
        row, column = empty[0]
        raise BadInput(f"row {row}, column `{table.columns[column]}`: there is no value (NaN)")
    plain = lambda value: value.item() if isinstance(value, np.generic) else value
    return [{name: plain(value) for name, value in zip(table.columns, row)} for row in table.itertuples(index=False, name=None)]

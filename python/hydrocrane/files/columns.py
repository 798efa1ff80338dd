"""Named columns as plain arrays, for runs and files, without the import of xarray."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeGuard, cast

import numpy as np

from hydrocrane.errors import ResultFileError

if TYPE_CHECKING:
    import xarray as xr

TIME = "time"

Attributes = dict[str, str | float]


@dataclass(frozen=True)
class Column:
    """Values of one variable.

    Attributes
    ----------
    values : array of float
        SI; one axis per dimension.
    attrs : dict
        Of a run ``units`` and ``long_name``.
    dims : tuple of str
        Names of the dimensions.
    """

    values: np.ndarray
    attrs: Attributes
    dims: tuple[str, ...] = (TIME,)


class Columns(Mapping[str, Column]):
    """Variables by name, ``time`` among them.

    Attributes
    ----------
    attrs : dict
        Attributes of the whole set.
    """

    def __init__(self, columns: dict[str, Column], attrs: Attributes) -> None:
        self._columns = columns
        self.attrs = attrs

    @classmethod
    def of(cls, data: xr.Dataset | Columns) -> Columns:
        """The time and the variables of a data set; its arrays and attributes are shared, not copied."""
        if isinstance(data, Columns):
            return data
        names = [*data.data_vars, *([TIME] if TIME in data.coords else [])]
        chosen = {str(name): data.variables[name] for name in names}
        columns = {
            name: Column(variable.values, cast(Attributes, variable.attrs), tuple(map(str, variable.dims)))
            for name, variable in chosen.items()
        }
        return cls(columns, cast(Attributes, data.attrs))

    def assign_attrs(self, attrs: Attributes) -> Columns:
        """The same columns with more attributes, as of a data set."""
        return Columns(self._columns, self.attrs | attrs)

    def __getitem__(self, name: str) -> Column:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def time(self) -> np.ndarray:
        """(m,) s."""
        return self._columns[TIME].values

    @property
    def rows(self) -> int:
        """Number of times; zero without a time."""
        return len(self.time) if TIME in self._columns else 0

    def over_time(self) -> dict[str, np.ndarray]:
        """The values (m,) by name for a table with a row per time, which comes first; one value holds at all times.

        Raises
        ------
        ResultFileError
            If a variable has other dimensions.
        """
        found = {}
        for name in [TIME, *(name for name in self if name != TIME)]:
            column = self[name]
            if column.dims not in ((TIME,), ()):
                over = ", ".join(column.dims)
                raise ResultFileError(f"`{name}` is over {over}, and a table has a row per time; save .nc, or drop it")
            found[name] = column.values if column.dims else np.broadcast_to(column.values, self.rows)
        return found

    def labelled(self) -> xr.Dataset:
        """The columns as a data set with the time as coordinate."""
        import xarray as xr

        # One construction from all columns: adding variables one by one takes longer than a short run.
        entries = {name: (column.dims, column.values, column.attrs) for name, column in self._columns.items()}
        time = entries.pop(TIME)
        return xr.Dataset(entries, coords={TIME: time}, attrs=self.attrs)


def is_dataset(value: object) -> TypeGuard[xr.Dataset]:
    """Whether `value` is an ``xarray.Dataset``; False in a program that has not imported xarray."""
    return isinstance(value, getattr(sys.modules.get("xarray"), "Dataset", ()))

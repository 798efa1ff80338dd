"""Writing runs to files, and reading them back from NetCDF."""

from __future__ import annotations

import importlib.util
from collections.abc import Collection, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hydrocrane.errors import ResultFileError
from hydrocrane.files.columns import TIME, Columns
from hydrocrane.files.excel import titled, write_excel
from hydrocrane.files.mcap_file import write_mcap
from hydrocrane.files.mdf import write_mdf
from hydrocrane.files.netcdf import read_netcdf, write_netcdf
from hydrocrane.files.text_rows import csv_line, csv_rows
from hydrocrane.files.whole_file import checked_suffix, written_whole

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def save(data: xr.Dataset | Columns, path: Path) -> Path:
    """Write `data` in the format of the suffix, whole or not at all; missing folders are made. Returns the path."""
    writer = _WRITERS[writable(path)]
    with written_whole(path) as beside:
        writer(data, beside)
    return path


def writable(path: Path, writers: Collection[str] = ()) -> str:
    """The suffix of a file, by default for a run, or an error that names those of the `writers`, or the package that is
    not installed."""
    suffix = checked_suffix(path, writers or _WRITERS)
    require_library(suffix)
    return suffix


def require_library(suffix: str) -> None:
    """Raises an error with its cure if files of this suffix need a package that is not installed."""
    what, package, extra = _NEEDS.get(suffix, ("", "", ""))
    if package and importlib.util.find_spec(package) is None:
        raise ResultFileError(f"{what} files need the package {package}; install hydrocrane[{extra}]")


def load_netcdf(path: Path) -> xr.Dataset:
    """Read a run's dataset into memory."""
    data = read_netcdf(path)
    if TIME not in data.coords or data[TIME].dims != (TIME,) or "outcome" not in data.attrs:
        raise ResultFileError(f"{path} is not a run saved by hydrocrane: it has no time axis or no outcome")
    words = [str(name) for name, column in data.variables.items() if column.dtype.kind not in "buif"]
    if words:
        raise ResultFileError(f"{path} is not a run saved by hydrocrane: its `{words[0]}` has no numbers")
    for name, column in data.variables.items():
        for attribute, value in column.attrs.items():
            # All that is said of a variable is text but for its sign in the energy balance.
            if not (isinstance(value, str) if attribute != "sign" else np.size(value) == 1 and np.isreal(value)):
                raise ResultFileError(f"{path}: what it says of `{name}` as `{attribute}` is damaged; copy it again")
    return data.drop_encoding()


def frame(data: xr.Dataset | Columns) -> pd.DataFrame:
    """The data as a table: first column time, one column per variable, units in ``frame.attrs``."""
    data = data.labelled() if isinstance(data, Columns) else data
    table = data.to_dataframe().reset_index()
    table.attrs = {"units": {name: str(data[name].attrs.get("units", "")) for name in table.columns}}
    return table


def write_matlab(data: xr.Dataset | Columns, path: Path) -> None:
    """One column vector per variable, dots in names as underscores; `units` and `names` are structs beside them."""
    from scipy.io import savemat

    columns = Columns.of(data)
    names = {short: name for name, short in plain_names([TIME, *columns]).items()}
    content: dict[str, object] = {short: columns[name].values for short, name in names.items()}
    content["units"] = {short: str(columns[name].attrs.get("units", "")) for short, name in names.items()}
    content["names"] = dict(names)
    content["about"] = {short: columns.attrs[key] for key, short in plain_names(columns.attrs).items()}
    savemat(path, content, oned_as="column", long_field_names=True)


def plain_name(name: str) -> str:
    """A name that MATLAB and python-control take: a letter, then letters, digits and underscores, 63 in all."""
    plain = "".join(c if c.isascii() and c.isalnum() else "_" for c in name)
    return plain[:63] if plain[:1].isalpha() else f"x{plain}"[:63]


def plain_names(names: Iterable[str]) -> dict[str, str]:
    """Each name with its :func:`plain_name`, and a number behind it where another one has that already."""
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in dict.fromkeys(names):
        short, count = plain_name(name), 1
        while short in taken:
            count += 1
            end = f"_{count}"
            short = plain_name(name)[: 63 - len(end)] + end
        found[name] = short
        taken.add(short)
    return found


def _csv(data: xr.Dataset | Columns, path: Path) -> None:
    """A row of names with units, ``tip.z [m]``, then numbers that read back as the same doubles."""
    columns = Columns.of(data)
    table = columns.over_time()
    with path.open("wb") as stream:
        stream.write(csv_line([titled(columns, name) for name in table]))
        stream.writelines(csv_rows(list(table.values())))


def _parquet(data: xr.Dataset | Columns, path: Path) -> None:
    frame(data).to_parquet(path, index=False)


_WRITERS = {
    ".nc": write_netcdf,
    ".mat": write_matlab,
    ".csv": _csv,
    ".parquet": _parquet,
    ".xlsx": write_excel,
    ".mf4": write_mdf,
    ".mcap": write_mcap,
}
# Kind of file, package and extra of the formats with an optional package.
_NEEDS = {
    ".parquet": ("Parquet", "pyarrow", "parquet"),
    ".xlsx": ("Excel", "openpyxl", "excel"),
    ".mf4": ("MDF", "asammdf", "mdf"),
    ".mcap": ("MCAP", "mcap", "mcap"),
    ".db3": ("ROS", "rosbags", "ros"),
}

"""One table from a file of any supported format, chosen by its suffix."""

from __future__ import annotations

import gzip
import json
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from os.path import isfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hydrocrane import _core
from hydrocrane.errors import InputError, ResultFileError, nearest
from hydrocrane.files.datasets import require_library
from hydrocrane.files.excel import cell_text, read_sheet
from hydrocrane.files.mdf import mdf_class
from hydrocrane.files.netcdf import read_netcdf
from hydrocrane.files.received import SHORTER, check_values, plain, readable, received
from hydrocrane.files.toml_file import parsed
from hydrocrane.logs.formats.bags import read_bag, read_mcap
from hydrocrane.logs.formats.matlab import read_hdf5, read_matlab
from hydrocrane.logs.signals import Flag
from hydrocrane.logs.table import (
    AS_FOUND,
    BOUNDS,
    NO_NUMBERS,
    TIME_NAMES,
    Clocked,
    LogColumn,
    LogForm,
    LogTable,
    as_column,
    attribute,
    check_width,
    plain_facts,
    said_of,
    stated_unit,
)  # fmt: skip

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from asammdf import Signal

    from hydrocrane.arrays import Array

# Largest text, bytes.
LARGEST_TEXT = 2**28
# Between cells that are no part of a text file.
_CELLS = "\x1f"
# Why channels of MDF are left out whose master is no time, by its kind.
_MASTERS = {
    kind: f"samples over {what}, not over time" for kind, what in ((2, "an angle"), (3, "a distance"), (4, "an index"))
}


def read_table(path: Path, form: LogForm = AS_FOUND) -> LogTable:
    """Columns of the file at `path`, unchanged; `form` says how a text writes numbers and dates.

    Raises
    ------
    ResultFileError
        If there is no such file, or its content does not match its suffix.
    """
    bag = isfile(path / "metadata.yaml")
    suffix = ".db3" if bag else path.suffix.lower()
    if not bag:
        received(path)
    if suffix == ".gz":
        suffix = Path(path.stem).suffix.lower()
        if _READERS.get(suffix) not in (None, _text):
            raise ResultFileError(f"{path} is a packed `{suffix}`, and only texts are read packed; unpack it first")
    if suffix not in _READERS:
        raise ResultFileError(f"cannot read `{path.name}`: unknown suffix `{suffix}`{nearest(suffix, _READERS)}")
    if not path.stat().st_size:
        raise ResultFileError(f"{path} is empty; copy it again from the logger")
    table = _READERS[suffix](path, form)
    check_width(path, len(table.columns))
    if not table.columns:
        raise ResultFileError("; ".join([f"{path} holds no column of numbers", *said_of(table.left_out)]))
    return table


def table_of_dataset(data: xr.Dataset) -> LogTable:
    """Columns of a dataset: its one-dimensional numeric variables, with their `units` and the values of their
    dimension as their clock."""
    table = LogTable()
    clocks = {str(dim): _clock_over(data, str(dim)) for dim in data.dims}
    for name in data.variables:
        variable = data[name]
        dim = str(variable.dims[0]) if variable.dims else ""
        if variable.ndim == 1 and not clocks[dim] and any(clocks.values()):
            table.leave(str(name), f"it is over `{dim}`, of which no variable is the time")
            continue
        # xarray unpacks values, but not their bounds.
        factor, offset = (
            variable.encoding.get(key, start) for key, start in (("scale_factor", 1.0), ("add_offset", 0.0))
        )
        stated = {key: np.asarray(variable.attrs[key]) for key in BOUNDS if key in variable.attrs}
        bounds = {key: value * factor + offset for key, value in stated.items() if value.dtype.kind in "iuf"}
        table.take(str(name), variable.values, stated_unit(variable.attrs), {**variable.attrs, **bounds})
        if variable.ndim == 1 and str(name) in table.columns:
            table.columns[str(name)].clock = clocks[dim]
    table.about = plain_facts(data.attrs)
    return table


def _clock_over(data: xr.Dataset, dim: str) -> str:
    """The variable with the values of a dimension: the one of its name, or one that is called like times."""
    over = [str(n) for n, held in data.variables.items() if held.dims == (dim,) and held.dtype.kind in "iufmM"]
    return dim if dim in over else LogTable().first_of(TIME_NAMES, over) or ""


def table_of_frame(frame: pd.DataFrame, form: LogForm = AS_FOUND) -> LogTable:
    """Columns of a table of pandas or polars, with its index if that has a name or holds dates; names may repeat.

    Units are in ``frame.attrs["units"]`` or in the names. Columns of texts are read like those of a text file.
    """
    index = getattr(frame, "index", None)
    columns = [(name, frame.iloc[:, i] if index is not None else frame[name]) for i, name in enumerate(frame.columns)]
    if index is not None and (index.name or getattr(index.dtype, "kind", "O") in "mM"):
        columns.insert(0, (index.name or "time", index))
    units = attribute(getattr(frame, "attrs", {}), "units", "unit")
    return table_of_columns(columns, units if isinstance(units, Mapping) else {}, form)


def table_of_columns(
    columns: Iterable[tuple[object, object]], units: Mapping[object, object], form: LogForm = AS_FOUND
) -> LogTable:
    """Columns of a program: arrays of numbers, dates, durations, or texts of numbers and dates."""
    table, read = LogTable(), LogTable()
    given: list[tuple[str, object, str]] = []
    texts: dict[int, list[str]] = {}
    dates: dict[int, np.ndarray] = {}
    for name, values in columns:
        cells = np.asarray(values)
        found = cells.tolist() if cells.ndim == 1 and cells.dtype.kind not in "buifcmM" else []
        if any(isinstance(cell, str) for cell in found):
            texts[len(given)] = [_one_line(cell_text(cell)) for cell in found]
        elif cells.ndim == 1 and cells.dtype.kind == "M":
            dates[len(given)] = cells
        given.append((str(name), values, str(units.get(name, ""))))
    if texts:
        texts |= {at: [cell.replace("NaT", "") for cell in np.datetime_as_string(dates[at]).tolist()] for at in dates}
    names = [name for name, *_ in given]
    own = [name if name and names.count(name) == 1 else f"column {at + 1}" for at, name in enumerate(names)]
    # Together, because one column may say what the marks of another mean, or the dates of times of day.
    for size in dict.fromkeys(map(len, texts.values())):
        held = {at: cells for at, cells in texts.items() if len(cells) == size}
        lines = (_CELLS.join(cells) + "\n" for cells in zip(*held.values()))
        add_text(read, "".join(lines), form, _CELLS, [own[at] for at in held], [given[at][2] for at in held])
    for at, (name, values, unit) in enumerate(given):
        if at not in texts:
            table.take(name, values, unit)
        elif own[at] in read.columns:
            table.add(name, read.columns[own[at]])
        else:
            table.leave(name, read.left_out[own[at]], read.words.get(own[at], ""))
    table.about, table.notes = read.about, read.notes
    return table


def add_text(
    table: LogTable,
    text: str | bytes,
    form: LogForm,
    delimiter: str | None = None,
    names: Sequence[str] = (),
    units: Sequence[str] = (),
) -> None:
    """Add the columns of a text; those without numbers are left out with the reason, single words are noted.

    With `names`, and their `units`, every line is a row; else the text has a head.

    Raises
    ------
    ValueError
        If it is no table.
    """
    data = text.encode("utf-8", "replace") if isinstance(text, str) else text
    mark = None if delimiter is None else ord(delimiter)
    columns, comments, notes = _core.read_text(data, form.numbers, form.dates, mark, list(names))
    for i, (name, unit, values, reason, word, start, said) in enumerate(columns):
        if values is None:
            table.leave(name, reason, word)
        else:
            stated = units[i] if i < len(units) else unit
            table.add(name, LogColumn(values, stated if start is None else "s", start=start, notes=said))
    table.about = _facts(comments)
    table.notes += [Flag(kind, "", np.nan, np.nan, message) for kind, message in notes]


def _one_line(cell: str) -> str:
    return cell.replace("\n", " ").replace("\r", " ").replace(_CELLS, " ")


def _facts(comments: Sequence[str]) -> dict[str, str | float | int]:
    """Facts from comment lines like ``# payload = 20``, read as TOML; other comments are ignored."""
    facts: dict[str, object] = {}
    for line in comments:
        try:
            facts |= parsed(line.lstrip("#%/"), "a comment")
        except InputError:
            continue
    return plain_facts(facts)


def _text(path: Path, form: LogForm) -> LogTable:
    packed = path.suffix.lower() == ".gz"
    try:
        with gzip.open(path) if packed else path.open("rb") as stream:
            # Room is made for as much as is asked for.
            data = stream.read(min(LARGEST_TEXT, LARGEST_TEXT if packed else path.stat().st_size) + 1)
    except (OSError, EOFError, zlib.error) as error:
        reason = f"cannot be {'unpacked' if packed else 'read'}: {error}"
        raise ResultFileError(f"{path} {reason}; copy it again from the logger") from None
    if len(data) > LARGEST_TEXT:
        most = f"{LARGEST_TEXT >> 20} MiB of text"
        raise ResultFileError(f"{path} has more than {most}. {SHORTER}, or save it as .h5 or .nc")
    return _table_of_text(path, data, form)


def _table_of_text(path: Path, text: str | bytes, form: LogForm, delimiter: str | None = None) -> LogTable:
    """The columns of a text with a head, of which one at least has numbers."""
    table = LogTable()
    try:
        add_text(table, text, form, delimiter)
    except ValueError as error:
        raise ResultFileError(f"{path} {error}") from None
    if not table.columns:
        reasons = "; ".join(dict.fromkeys(table.left_out.values()))
        raise ResultFileError(f"{path} is not a CSV table: no column of numbers in it{reasons and ': '}{reasons}")
    return table


def _parquet(path: Path, form: LogForm) -> LogTable:
    require_library(".parquet")
    import pandas as pd
    from pyarrow import parquet

    with readable(path, "a Parquet file that is whole"):
        stored = parquet.ParquetFile(path)
        check_values(path, stored.metadata.num_rows * stored.metadata.num_columns)
        frame = pd.read_parquet(path)
        about = {
            field.name: {plain(k.decode()): v for k, v in (field.metadata or {}).items()}
            for field in stored.schema_arrow
        }
        units: dict[object, object] = {name: unit for name, facts in about.items() if (unit := stated_unit(facts))}
        given = attribute(frame.attrs, "units", "unit")
        frame.attrs["units"] = units | (given if isinstance(given, dict) else {})
        return table_of_frame(frame, form)


def _excel(path: Path, form: LogForm) -> LogTable:
    require_library(".xlsx")
    with readable(path, "an Excel workbook that is whole"):
        lines = [_CELLS.join(map(_one_line, row)) for row in read_sheet(path)]
    lines = [line for line in lines if line.strip(_CELLS)]
    if not lines:
        raise ResultFileError(f"{path} has no cells in its first sheet; a log is a table with a time column")
    return _table_of_text(path, "\n".join(lines), form, _CELLS)


def _mdf(path: Path, _: LogForm) -> LogTable:
    """Measurement data format 4 (ASAM): every raster has its own clock."""
    reader = mdf_class()
    table = LogTable()
    rasters: list[tuple[Array, list[Signal]]] = []
    with readable(path, "an MDF file that can be read"), reader(path) as stored:
        table.about = _header_facts(stored.header.description)
        for signal in stored.iter_channels():
            about = signal.master_metadata
            reason = _MASTERS.get(about[1] if about else 0, "" if len(signal.timestamps) else "no samples")
            if reason:
                table.leave(signal.name, reason)
                continue
            times = np.asarray(signal.timestamps, np.float64)
            known = next((raster for raster in rasters if np.array_equal(raster[0], times)), None)
            if known is None:
                rasters.append(known := (times, []))
            known[1].append(signal)
    groups = [Clocked("time", times, [*_channels(table, signals)]) for times, signals in rasters]
    table.add_clocked(groups)
    return table


def _channels(table: LogTable, signals: list[Signal]) -> Iterator[tuple[str, LogColumn]]:
    for signal in signals:
        column = as_column(signal.samples, str(signal.unit or ""))
        if column is None or column.values.ndim != 1:
            table.leave(signal.name, NO_NUMBERS)
            continue
        if signal.invalidation_bits is not None:
            column.mask(~np.asarray(signal.invalidation_bits, bool))
        yield signal.name, column


def _header_facts(text: str) -> dict[str, str | float | int]:
    """Facts from the text of an MDF header, which is JSON in files of this package and arbitrary in others."""
    try:
        facts = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return plain_facts(facts) if isinstance(facts, dict) else {}


_READERS: dict[str, Callable[[Path, LogForm], LogTable]] = {
    **dict.fromkeys((".csv", ".txt", ".tsv", ".dat", ".log", ".exp"), _text),
    **dict.fromkeys((".h5", ".hdf5"), lambda path, _: read_hdf5(path)),
    ".mat": lambda path, _: read_matlab(path),
    ".nc": lambda path, _: table_of_dataset(read_netcdf(path)),
    ".parquet": _parquet,
    ".xlsx": _excel,
    ".mf4": _mdf,
    ".mcap": lambda path, _: read_mcap(path),
    **dict.fromkeys((".db3", ".bag"), lambda path, _: read_bag(path)),
}

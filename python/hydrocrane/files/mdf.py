"""Measurement data format 4 (ASAM), the format of vehicle loggers and test benches."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from hydrocrane.errors import ResultFileError
from hydrocrane.files.columns import TIME, Columns

if TYPE_CHECKING:
    import xarray as xr


def mdf_class() -> type:
    """The class that reads and writes MDF files; it needs the extra `mdf`."""
    try:
        from asammdf import MDF
    except ImportError:
        raise ResultFileError("MDF files need the package asammdf; install hydrocrane[mdf]") from None
    found: type = MDF
    return found


def write_mdf(data: xr.Dataset | Columns, path: Path) -> None:
    """One channel per variable with its unit and meaning; attributes of the whole set are JSON in the header's text."""
    made = mdf_class()
    from asammdf import Signal

    columns = Columns.of(data)
    with made(version="4.10") as stored:
        stored.header.description = json.dumps(columns.attrs)
        stored.append(
            [
                Signal(
                    column.values,
                    columns.time,
                    unit=str(column.attrs.get("units", "")),
                    name=name,
                    comment=str(column.attrs.get("long_name", "")),
                )
                for name, column in columns.items()
                if name != TIME
            ]
        )
        stored.save(path, overwrite=True)

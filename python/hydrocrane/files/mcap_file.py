"""MCAP: messages over time, which viewers for robots can plot.

A variable is a field of a topic: ``cylinder.lift.p1`` is the field ``p1`` of ``/cylinder/lift``, which a viewer calls
``/cylinder/lift.p1``. Messages are JSON, and each topic has a JSON Schema with the unit and the meaning of its fields.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hydrocrane.errors import ResultFileError
from hydrocrane.files.columns import TIME, Column, Columns

if TYPE_CHECKING:
    import xarray as xr

# Topic of variables whose names have one part.
_ALONE = "run"
_NANOSECONDS = 1e9


def write_mcap(data: xr.Dataset | Columns, path: Path) -> None:
    """One message per topic and time; missing values (NaN) are left out."""
    from mcap.writer import Writer

    columns = Columns.of(data)
    times = np.rint(columns.time * _NANOSECONDS).astype(np.int64)
    if times.size and times.min() < 0:
        raise ResultFileError(f"cannot write `{path.suffix}`: MCAP has no times before zero; shift the time first")
    topics = _topics(columns)
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(library="hydrocrane")
        writer.add_metadata("hydrocrane", {str(key): str(value) for key, value in columns.attrs.items()})
        channels = {}
        for topic, fields in topics.items():
            schema = writer.register_schema(topic, "jsonschema", json.dumps(_schema(topic, fields)).encode())
            channels[topic] = writer.register_channel(f"/{topic}", "json", schema)
        tables = {
            topic: np.stack([column.values for column in fields.values()], -1) for topic, fields in topics.items()
        }
        for row, time in enumerate(times.tolist()):
            for topic, fields in topics.items():
                values = zip(fields, tables[topic][row].tolist(), strict=True)
                message = json.dumps({name: value for name, value in values if value == value})
                writer.add_message(channels[topic], time, message.encode(), time)
        writer.finish()


def owner_of(topic: str) -> str:
    """The part of a variable's name that is its topic."""
    return "" if topic == f"/{_ALONE}" else topic.strip("/").replace("/", ".")


def _topics(columns: Columns) -> dict[str, dict[str, Column]]:
    """Fields of each topic, in the order of the variables."""
    found: dict[str, dict[str, Column]] = {}
    for name, column in columns.items():
        if name != TIME:
            *front, last = name.split(".")
            found.setdefault("/".join(front) or _ALONE, {})[last] = column
    return found


def _schema(topic: str, fields: dict[str, Column]) -> dict[str, object]:
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": topic,
        "type": "object",
        "properties": {
            name: {
                "type": "number",
                "description": f"{column.attrs.get('long_name', name)} [{column.attrs.get('units') or 1}]",
            }
            for name, column in fields.items()
        },
    }

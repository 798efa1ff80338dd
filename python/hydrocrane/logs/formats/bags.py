"""Bags of ROS and MCAP files: fields of messages as columns, each topic with its own clock.

A field is named by its topic: ``/boom/pressure.fluid_pressure``, ``/imu.angular_velocity.x``, ``/axes.data[2]``.
Elements of an array beside a list `name` are named by that list: ``/joint_states.position.boom``.
"""

from __future__ import annotations

import json
from array import array
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from hydrocrane import _core
from hydrocrane.errors import ResultFileError
from hydrocrane.files.datasets import require_library
from hydrocrane.files.mcap_file import owner_of
from hydrocrane.files.received import SHORTER, check_values, plain, readable, received
from hydrocrane.logs.signals import known_unit
from hydrocrane.logs.table import NO_NUMBERS, Clocked, LogColumn, LogTable, check_width

if TYPE_CHECKING:
    from mcap.records import Channel, Schema

# Longest array whose elements are signals; others are scans, pictures and clouds.
LONGEST_ARRAY = 64
# Most bytes that a chunk of MCAP unpacks to.
LARGEST_CHUNK = 2**28
_SECOND = 10**9
# Units that definitions of messages state in words, by type and field.
_UNITS = {
    ("FluidPressure", "fluid_pressure"): "Pa",
    ("Imu", "angular_velocity"): "rad/s",
    ("Imu", "linear_acceleration"): "m/s^2",
    ("Range", "range"): "m",
    ("Temperature", "temperature"): "degC",
}
_GAUGE = (
    "is read as gauge pressure, which most hydraulic sensors give, though sensor_msgs/FluidPressure is absolute by its "
    'definition; if it is, give unit = "Pa a"'
)
_Decoder: TypeAlias = Callable[[bytes], object]


@dataclass
class _Rows:
    """Messages of a topic with the same fields: when they were logged and made, ns, and their values in a row."""

    logged: array[int] = field(default_factory=lambda: array("q"))
    made: array[int] = field(default_factory=lambda: array("q"))
    values: array[float] = field(default_factory=lambda: array("d"))


@dataclass
class _Topic:
    name: str
    kind: str
    units: Mapping[str, str]
    rows: dict[tuple[str, ...], _Rows] = field(default_factory=dict)

    def clocked(self) -> Iterator[tuple[str, np.ndarray, list[tuple[str, LogColumn]]]]:
        """Name of a clock, its times, ns, and its columns: those that are in the same messages."""
        made = all(min(rows.made) > 0 for rows in self.rows.values())
        holders: dict[tuple[tuple[str, ...], ...], list[str]] = {}
        for name in dict.fromkeys(name for names in self.rows for name in names):
            holders.setdefault(tuple(names for names in self.rows if name in names), []).append(name)
        for i, (held, names) in enumerate(holders.items()):
            parts = [self.rows[each] for each in held]
            times = np.concatenate([part.made if made else part.logged for part in parts])
            order = np.argsort(times, kind="stable")
            tables = [np.asarray(part.values).reshape(-1, len(each)) for each, part in zip(held, parts)]
            columns = []
            for name in names:
                values = np.concatenate([table[:, each.index(name)] for each, table in zip(held, tables)])
                columns.append((_joined(self.name, name), self._column(name, values[order])))
            yield _joined(self.name, f"time.{i + 1}" if i else "time"), times[order], columns

    def _column(self, name: str, values: np.ndarray) -> LogColumn:
        usual = _UNITS.get((self.kind.rsplit("/", 1)[-1], name.split(".")[0]), "")
        return LogColumn(values, self.units.get(name, usual), notes=[("assumed-unit", _GAUGE)] if usual == "Pa" else [])


class _Bag:
    """Messages on their way into a table."""

    def __init__(self, path: Path) -> None:
        self.path, self.left_out = path, dict[str, str]()
        self.topics: dict[str, _Topic] = {}
        self.count, self.width = 0, 0

    def take(self, topic: str, kind: str, units: Mapping[str, str], logged: int, content: object) -> None:
        message = _members(content)
        made = _stamp(message, "header") or _stamp(message, "timestamp")
        found: dict[str, float] = {}
        for path in _take_numbers(message or {"": content}, "", found):
            self.left_out[_joined(topic, path)] = f"arrays of more than {LONGEST_ARRAY} values, which are no signals"
        known = self.topics.setdefault(topic, _Topic(topic, kind, units))
        names = tuple(found)
        if names and names not in known.rows:
            self.width += 1 + len(set(names).difference(*known.rows))
            check_width(self.path, self.width)
        if names:
            rows = known.rows.setdefault(names, _Rows())
            rows.logged.append(logged)
            rows.made.append(made)
            rows.values.extend(found.values())
        self.count += len(names) + 2
        check_values(self.path, self.count)

    def finish(self) -> LogTable:
        table = LogTable()
        for name, reason in self.left_out.items():
            table.leave(name, reason)
        for topic in self.topics.values():
            if not topic.rows:
                table.leave(topic.name, NO_NUMBERS)
        groups = [group for topic in self.topics.values() for group in topic.clocked() if topic.rows]
        zero = min((int(times[0]) for _, times, _ in groups), default=0)
        table.add_clocked(
            [Clocked(name, (times - zero) / _SECOND, columns, zero / _SECOND) for name, times, columns in groups]
        )
        return table


def _joined(topic: str, name: str) -> str:
    return ".".join(filter(None, (topic, name)))


def _members(node: object) -> dict[str, object]:
    """Fields of a message; none of what is no message."""
    return node if isinstance(node, dict) else vars(node) if hasattr(node, "__dict__") else {}


def _stamp(message: dict[str, object], name: str) -> int:
    """When a message was made, ns, and takes it out of the message; 0 if there is no such field."""
    holder = message.get(name)
    stamp = _members(_members(holder).get("stamp", holder))
    seconds, rest = stamp.get("sec"), stamp.get("nanosec", stamp.get("nsec", 0))
    if not isinstance(seconds, int) or not isinstance(rest, int):
        return 0
    del message[name]
    return seconds * _SECOND + rest


def _take_numbers(members: Mapping[str, object], path: str, found: dict[str, float]) -> list[str]:
    """Adds the numbers of a message to those `found`, by their fields; returns the arrays that are too long."""
    long = []
    labels = members.get("name")
    for name, child in members.items():
        inner = f"{path}.{name}" if path and name else path or name
        if isinstance(child, int | float):
            found[inner] = child
        elif isinstance(child, list | np.ndarray):
            if len(child) > LONGEST_ARRAY:
                long.append(inner)
                continue
            named = labels if isinstance(labels, list) and len(labels) == len(child) else range(1, len(child) + 1)
            keys = [f"{inner}[{label}]" if isinstance(label, int) else f"{inner}.{label}" for label in named]
            long += _take_numbers(
                dict(zip(keys, child.tolist() if isinstance(child, np.ndarray) else child)), "", found
            )
        elif not isinstance(child, str):
            long += _take_numbers(_members(child), inner, found)
    return long


def read_bag(path: Path) -> LogTable:
    """A bag of ROS 2, a folder or its one file, or of ROS 1."""
    require_library(".db3")
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    for part in path.iterdir() if path.is_dir() else ():
        if not part.is_dir():
            received(part)
    bag = _Bag(path)
    # Until Humble, bags of ROS 2 do not define their messages.
    usual = get_typestore(Stores.ROS2_HUMBLE)
    with readable(path, "a bag of ROS that is whole"), AnyReader([path], default_typestore=usual) as reader:
        known = [each for each in reader.connections if each.msgtype in reader.typestore.fielddefs]
        for each in reader.connections:
            if each not in known:
                bag.left_out[plain(each.topic)] = f"the bag does not define its messages, {plain(each.msgtype)}"
        for each, logged, raw in reader.messages(known) if known else ():
            bag.take(plain(each.topic), each.msgtype, {}, logged, reader.deserialize(raw, each.msgtype))
    return bag.finish()


def read_mcap(path: Path) -> LogTable:
    """Messages in JSON, or of ROS as the file defines them."""
    require_library(".mcap")
    from mcap.reader import make_reader

    bag = _Bag(path)
    decoders: dict[int, tuple[str, _Decoder | None, Mapping[str, str]]] = {}
    with readable(path, "an MCAP file that is whole"), path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        if summary and any(chunk.uncompressed_size > LARGEST_CHUNK for chunk in summary.chunk_indexes):
            raise ResultFileError(f"{path} has a chunk of more than {LARGEST_CHUNK >> 20} MiB. {SHORTER}")
        own = reader.get_header().library == "hydrocrane"
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            if channel.id not in decoders:
                name, decode = plain(channel.topic), None
                name = owner_of(name) if own else name
                try:
                    decode = _decoder(channel, schema)
                except ValueError as error:
                    bag.left_out[name] = plain(str(error))
                decoders[channel.id] = name, decode, _units(schema)
            name, decode, units = decoders[channel.id]
            if decode is not None:
                bag.take(name, schema.name if schema else "", units, message.log_time, decode(message.data))
    return bag.finish()


def _decoder(channel: Channel, schema: Schema | None) -> _Decoder:
    """What reads the messages of a channel.

    Raises
    ------
    ValueError
        If nothing does.
    """
    written, defined = channel.message_encoding, schema.encoding if schema else ""
    if written == "json":
        return json.loads
    if schema is None or (written, defined) not in (("cdr", "ros2msg"), ("cdr", "ros2idl"), ("ros1", "ros1msg")):
        how = f"`{written}`" + (f", defined as `{defined}`" if defined else "")
        raise ValueError(f"messages written as {how}; JSON and messages of ROS 1 and 2 are read")
    require_library(".db3")
    from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore

    store, text = get_typestore(Stores.EMPTY), schema.data.decode()
    try:
        if defined == "ros2idl":
            for part in filter(None, text.split("=" * 80 + "\n")):
                store.register(get_types_from_idl(part[part.startswith("IDL: ") and part.find("\n") :]))
        else:
            store.register(get_types_from_msg(text, schema.name))
    except TypesysError as error:
        raise ValueError(f"messages whose definition cannot be read: {error}") from None
    package, _, kind = schema.name.rpartition("/")
    full = f"{package.removesuffix('/msg')}/msg/{kind}"
    read = store.deserialize_ros1 if written == "ros1" else store.deserialize_cdr
    return lambda raw: read(raw, full)


def _units(schema: Schema | None) -> dict[str, str]:
    """Units behind the descriptions of a JSON Schema, as this package writes them."""
    if schema is None or schema.encoding != "jsonschema":
        return {}
    try:
        fields = json.loads(schema.data)["properties"].items()
        stated = {name: _core.split_name(str(about.get("description", "")))[1] for name, about in fields}
    except (ValueError, LookupError, AttributeError, TypeError):
        return {}
    return {name: unit for name, unit in stated.items() if known_unit(unit)}

"""Bags of ROS and MCAP files: a signal per field of a topic, at the times of its messages; what is not read is said."""

from __future__ import annotations

import json

import numpy as np
import pytest

import hydrocrane as hc

pytest.importorskip("rosbags")

from mcap.writer import CompressionType  # noqa: E402
from mcap.writer import Writer as McapWriter  # noqa: E402
from rosbags.rosbag1 import Writer as Writer1  # noqa: E402
from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: E402
from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: E402

N = 40
# Messages are made at even times, ns, and logged a little later.
MADE = 1_700_000_000 * 10**9 + np.arange(N) * 20_000_000
LATE = np.random.default_rng(1).integers(1_000, 3_000_000, N)
T = np.arange(N) * 0.02
KINDS = {
    "/boom/pressure": "sensor_msgs/msg/FluidPressure",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/load": "std_msgs/msg/Float64",
    "/axes": "std_msgs/msg/Float64MultiArray",
    "/name": "std_msgs/msg/String",
    "/scan": "sensor_msgs/msg/LaserScan",
}


def messages(store, ns, topic):
    """Its messages, every one with values that follow from its number."""
    kinds = store.types
    stamp, header = kinds["builtin_interfaces/msg/Time"], kinds["std_msgs/msg/Header"]
    of = kinds[KINDS[topic]]
    for i, made in enumerate(ns):
        at = header(stamp(*divmod(int(made), 10**9)), "boom")
        angles = np.array([0.1 * i, 0.2 * i])
        yield {
            "/boom/pressure": lambda: of(at, 1e5 * i, 0.0),
            "/joint_states": lambda: of(at, ["boom", "arm"], angles, 2 * angles, np.zeros(0)),
            "/load": lambda: of(float(i)),
            "/axes": lambda: of(kinds["std_msgs/msg/MultiArrayLayout"]([], 0), np.array([1.0, -1.0]) * i),
            "/name": lambda: of("boom"),
            "/scan": lambda: of(at, *[0.0] * 7, np.zeros(720, np.float32), np.zeros(0, np.float32)),
        }[topic]()


def bag(path, topics=tuple(KINDS), plugin=StoragePlugin.SQLITE3, ns=MADE):
    store = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        for topic in topics:
            connection = writer.add_connection(topic, KINDS[topic], typestore=store)
            for i, message in enumerate(messages(store, ns, topic)):
                writer.write(connection, int(MADE[i] + LATE[i]), store.serialize_cdr(message, KINDS[topic]))
    return path


def said(log, kind):
    return "; ".join(flag.message for flag in log.flags if flag.kind == kind)


@pytest.mark.parametrize("form", ["folder", "file", "mcap folder", "mcap file"])
def test_topics_of_ros_2(form, tmp_path):
    plugin = StoragePlugin.MCAP if "mcap" in form else StoragePlugin.SQLITE3
    path = bag(tmp_path / "drive", plugin=plugin)
    log = hc.read_log(path if "folder" in form else next(path.glob("drive.[dm]*")))
    assert log.data["/boom/pressure.fluid_pressure"].attrs["units"] == "Pa"
    for name, factor in (("position", 0.1), ("velocity", 0.2)):
        np.testing.assert_allclose(log[f"/joint_states.{name}.boom"], factor * np.arange(N), atol=1e-9)
        np.testing.assert_allclose(log[f"/joint_states.{name}.arm"], 2 * factor * np.arange(N), atol=1e-9)
    # The time of logging is that of topics without a header, interpolated at those of the log.
    inside = np.isfinite(log["/load.data"])
    logged = (MADE + LATE - MADE[0]) * 1e-9
    np.testing.assert_allclose(log["/load.data"][inside], np.interp(log.time, logged, np.arange(N))[inside], atol=1e-6)
    assert inside.sum() > N - 4 and "/load.time" in said(log, "resampled")
    np.testing.assert_allclose(log["/axes.data[2]"], -log["/axes.data[1]"])
    assert "`/name` left out: no numbers" in said(log, "left-out")
    assert "`/scan.ranges` left out: arrays of more than 64" in said(log, "left-out")
    assert "absolute by its definition" in said(log, "assumed-unit")


def test_the_clock_is_that_of_the_headers(tmp_path):
    path = bag(tmp_path / "drive", ("/boom/pressure",))
    mapping = {"signal": {"p1": {"column": "/boom/pressure.fluid_pressure", "unit": "Pa"}}}
    log = hc.read_log(path, mapping)
    np.testing.assert_allclose(log.time, T, atol=1e-9)
    np.testing.assert_array_equal(log["p1"], 1e5 * np.arange(N))
    assert not said(log, "assumed-unit")
    unset = hc.read_log(bag(tmp_path / "unset", ("/boom/pressure",), ns=np.zeros(N, int)), mapping)
    np.testing.assert_allclose(unset.time, (MADE + LATE - MADE[0] - LATE[0]) * 1e-9, atol=1e-6)


def test_joints_of_two_publishers_keep_their_own_times(tmp_path):
    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = store.types
    with Writer(tmp_path / "drive", version=9) as writer:
        connection = writer.add_connection("/joint_states", KINDS["/joint_states"], typestore=store)
        for i, made in enumerate(MADE):
            header = kinds["std_msgs/msg/Header"](kinds["builtin_interfaces/msg/Time"](*divmod(int(made), 10**9)), "")
            none = np.zeros(0)
            message = kinds[KINDS["/joint_states"]](header, [("boom", "arm")[i % 2]], np.array([0.1 * i]), none, none)
            writer.write(connection, int(made), store.serialize_cdr(message, KINDS["/joint_states"]))
    log = hc.read_log(tmp_path / "drive")
    inside = np.isfinite(log["/joint_states.position.boom"]) & np.isfinite(log["/joint_states.position.arm"])
    assert inside.sum() >= N // 2 - 1
    np.testing.assert_allclose(log["/joint_states.position.arm"][inside], log["/joint_states.position.boom"][inside])


def test_bags_of_ros_1(tmp_path):
    store = get_typestore(Stores.ROS1_NOETIC)
    with Writer1(tmp_path / "drive.bag") as writer:
        connection = writer.add_connection("/boom/pressure", KINDS["/boom/pressure"], typestore=store)
        header, stamp = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
        for i, made in enumerate(MADE):
            at = header(i, stamp(*divmod(int(made), 10**9)), "boom")
            message = store.types[KINDS["/boom/pressure"]](at, 1e5 * i, 0.0)
            writer.write(connection, int(made), store.serialize_ros1(message, KINDS["/boom/pressure"]))
    log = hc.read_log(tmp_path / "drive.bag")
    np.testing.assert_allclose(log.time, T, atol=1e-9)
    np.testing.assert_array_equal(log["/boom/pressure.fluid_pressure"], 1e5 * np.arange(N))


def test_a_bag_that_does_not_define_its_own_messages(tmp_path):
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg("float64 pressure", "crane_msgs/msg/Valve"))
    path = tmp_path / "drive"
    with Writer(path, version=9) as writer:
        connection = writer.add_connection("/valve", "crane_msgs/msg/Valve", typestore=store)
        message = store.types["crane_msgs/msg/Valve"](1.0)
        writer.write(connection, int(MADE[0]), store.serialize_cdr(message, "crane_msgs/msg/Valve"))
    import sqlite3

    with sqlite3.connect(path / "drive.db3") as stored:
        stored.execute("DELETE FROM message_definitions")
    with pytest.raises(
        hc.ResultFileError, match=r"`/valve` left out: the bag does not define its messages, crane_msgs"
    ):
        hc.read_log(path / "drive.db3")


# --- MCAP ------------------------------------------------------------------------------------------------------------


def mcap(path, channels, compression=CompressionType.ZSTD, library="somebody"):
    """A file with one channel per (topic, encoding, schema, messages); a schema is its name, encoding and text."""
    with path.open("wb") as stream:
        writer = McapWriter(stream, compression=compression)
        writer.start(library=library)
        for topic, encoding, schema, contents in channels:
            known = writer.register_schema(*schema) if schema else 0
            channel = writer.register_channel(topic, encoding, known)
            for i, content in enumerate(contents):
                writer.add_message(channel, int(MADE[i]), content, int(MADE[i]))
        writer.finish()
    return path


def in_json(*objects):
    return [json.dumps(each).encode() for each in objects]


@pytest.mark.parametrize("compression", CompressionType)
def test_json(compression, tmp_path):
    contents = in_json(*({"x": 0.01 * i, "deep": {"p": [i, -i]}, "on": i > 3, "name": "boom"} for i in range(N)))
    log = hc.read_log(mcap(tmp_path / "drive.mcap", [("/boom", "json", None, contents)], compression))
    np.testing.assert_allclose(log.time, T)
    np.testing.assert_allclose(log["/boom.x"], 0.01 * np.arange(N))
    np.testing.assert_allclose(log["/boom.deep.p[2]"], -np.arange(N))
    assert log["/boom.on"].sum() == N - 4


IDL = """================================================================================
IDL: crane_msgs/msg/Valve
module crane_msgs {
  module msg {
    struct Valve {
      double pressure;
      sequence<float> flows;
    };
  };
};
"""
DEFINED = {
    "ROS 2": ("cdr", "ros2msg", "crane_msgs/msg/Valve", "float64 pressure\nfloat32[] flows"),
    "ROS 2, IDL": ("cdr", "ros2idl", "crane_msgs/msg/Valve", IDL),
    "ROS 1": ("ros1", "ros1msg", "crane_msgs/Valve", "float64 pressure\nfloat32[] flows"),
}


@pytest.mark.parametrize(("written", "defined", "kind", "definition"), DEFINED.values(), ids=DEFINED)
def test_messages_of_ones_own(written, defined, kind, definition, tmp_path):
    store, full = get_typestore(Stores.EMPTY), "crane_msgs/msg/Valve"
    store.register(get_types_from_msg("float64 pressure\nfloat32[] flows", full))
    write = store.serialize_ros1 if written == "ros1" else store.serialize_cdr
    contents = [bytes(write(store.types[full](1.0 * i, np.array([i, 2 * i], np.float32)), full)) for i in range(N)]
    path = mcap(tmp_path / "own.mcap", [("/valve", written, (kind, defined, definition.encode()), contents)])
    log = hc.read_log(path)
    np.testing.assert_array_equal(log["/valve.pressure"], np.arange(N))
    np.testing.assert_array_equal(log["/valve.flows[2]"], 2 * np.arange(N))


def test_a_run_reads_back(tmp_path):
    run = hc.simulate("single-cylinder-step", duration=0.5)
    path = run.save(tmp_path / "run.mcap")
    log = hc.read_log(path)
    assert log.data["cylinder.test.p1"].attrs["units"] == "Pa"
    np.testing.assert_array_equal(log["cylinder.test.p1"], run.columns["cylinder.test.p1"].values)
    assert run.compare(path).rms["cylinder.test.x"] < 1e-15


def test_what_is_written_otherwise_is_named(tmp_path):
    good = ("/boom", "json", None, in_json(*({"x": i} for i in range(N))))
    bad = ("/arm", "protobuf", ("Arm", "protobuf", b"\x00"), [b"\x01"] * N)
    log = hc.read_log(mcap(tmp_path / "both.mcap", [good, bad]))
    assert "`/arm` left out: messages written as `protobuf`" in said(log, "left-out")
    with pytest.raises(hc.ResultFileError, match="no column of numbers; .*`protobuf`.* JSON and messages of ROS"):
        hc.read_log(mcap(tmp_path / "bad.mcap", [bad]))
    odd = ("/odd", "cdr", ("a/msg/B", "ros2msg", b"float64 = ="), [b"\x00"])
    with pytest.raises(hc.ResultFileError, match="`/odd` left out: messages whose definition cannot be read"):
        hc.read_log(mcap(tmp_path / "odd.mcap", [odd]))


def damaged(path):
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    return path


def test_what_is_cut_off_is_one_error(tmp_path):
    contents = in_json(*({"x": i} for i in range(N)))
    with pytest.raises(hc.ResultFileError, match="damaged, or not an MCAP file that is whole"):
        hc.read_log(damaged(mcap(tmp_path / "cut.mcap", [("/boom", "json", None, contents)])))
    for plugin, name in ((StoragePlugin.SQLITE3, "db3"), (StoragePlugin.MCAP, "mcap")):
        path = bag(tmp_path / name, plugin=plugin)
        damaged(path / f"{name}.{name}")
        with pytest.raises(hc.ResultFileError, match="damaged, or not a bag of ROS that is whole"):
            hc.read_log(path)
    for name in ("text.mcap", "text.db3", "text.bag"):
        (tmp_path / name).write_text("time,x\n0,1\n")
        with pytest.raises(hc.ResultFileError, match="damaged, or not a"):
            hc.read_log(tmp_path / name)
    (tmp_path / "empty.mcap").write_bytes(b"")
    with pytest.raises(hc.ResultFileError, match="is empty"):
        hc.read_log(tmp_path / "empty.mcap")


def test_nothing_but_words_is_an_error(tmp_path):
    with pytest.raises(hc.ResultFileError, match="no column of numbers; column `/name` left out: no numbers"):
        hc.read_log(bag(tmp_path / "drive", ("/name",)))


def test_numbers_and_fields_are_bounded(tmp_path, monkeypatch):
    many = in_json(*({f"x{i}": i, f"y{i}": i} for i in range(N)))
    path = mcap(tmp_path / "many.mcap", [("/boom", "json", None, many)])
    monkeypatch.setattr("hydrocrane.logs.table.MOST_COLUMNS", 50)
    with pytest.raises(hc.ResultFileError, match="columns, more than 50"):
        hc.read_log(path)
    monkeypatch.setattr("hydrocrane.files.received.MOST_VALUES", 100)
    with pytest.raises(hc.ResultFileError, match="numbers, more than 100"):
        hc.read_log(bag(tmp_path / "long", ("/load",)))
    monkeypatch.setattr("hydrocrane.logs.formats.bags.LARGEST_CHUNK", 100)
    with pytest.raises(hc.ResultFileError, match="a chunk of more than"):
        hc.read_log(path)


def test_without_the_library_the_cure_is_named(tmp_path, monkeypatch):
    path = bag(tmp_path / "drive", ("/load",))
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(hc.ResultFileError, match=r"need the package rosbags; install hydrocrane\[ros\]"):
        hc.read_log(path)

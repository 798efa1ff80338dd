"""Bad input of the controllers in C: a status that says what is wrong, commands of zero, never a crash."""

from __future__ import annotations

import ctypes
import struct
import zlib

import numpy as np
import pytest
from c_controller import Sample, loaded, needs_compiler, needs_library

import hydrocrane as hc
from hydrocrane import _core

pytestmark = [needs_compiler, needs_library]
CRANE = "rottne-f9-lab"
TIP, LEVERS, HEIGHT = 0, 1, 2


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return loaded(tmp_path_factory.mktemp("library"))


def exported(monitor):
    return _core.controller_parameters(hc.load_machine(CRANE).core, "tip", monitor, 0.0)


@pytest.fixture(scope="module")
def block():
    return exported(monitor=False)


class Memory:
    """Memory of a program at a multiple of 8 bytes, and a controller in it."""

    def __init__(self, library, size):
        self.library, self.size = library, size
        self.words = np.zeros(size // 8 + 2, dtype=np.uint64)
        self.spool = np.full(3, np.nan)

    def create(self, parameters, size=None, offset=0):
        size = self.size if size is None else size
        return self.library.hydrocrane_create(self.words.ctypes.data + offset, size, parameters, len(parameters))

    def sample(self, t=0.0, q=(1.9, 1.7, 0.0), p=(80e5, 60e5, 70e5, 90e5, 50e5, 60e5)):
        self.q, self.p = np.array(q), np.array(p)
        return Sample(t, self.q.ctypes.data, self.p.ctypes.data)

    def reset(self, **sample):
        return self.library.hydrocrane_reset(self.words.ctypes.data, ctypes.byref(self.sample(**sample)))

    def step(self, axes=(0.0, 0.2), mode=TIP, count=None, **sample):
        sticks = np.array(axes)
        self.spool[:] = np.nan
        return self.library.hydrocrane_step(
            self.words.ctypes.data,
            ctypes.byref(self.sample(**sample)),
            mode,
            sticks.ctypes.data,
            len(axes) if count is None else count,
            self.spool.ctypes.data,
            len(self.spool),
        )


@pytest.fixture
def memory(library, block):
    """With a controller of three joints."""
    memory = Memory(library, block[1])
    assert memory.create(block[0]) == 0 and memory.reset() == 0
    return memory


@pytest.fixture
def monitored(library):
    """With a controller of three joints and a monitor of its sensors."""
    parameters, size = exported(monitor=True)
    memory = Memory(library, size)
    assert memory.create(parameters) == 0 and memory.reset() == 0
    return memory


def with_checksum(block: bytearray) -> bytes:
    return bytes(block[:-8]) + struct.pack("<Q", zlib.crc32(block[:-8]))


def test_sound_input_is_taken(memory):
    assert memory.step() == 0 and np.all(np.isfinite(memory.spool)) and np.any(memory.spool)
    assert memory.library.hydrocrane_period(memory.words.ctypes.data) == 0.01
    place = np.zeros(2)
    assert memory.library.hydrocrane_set_point(memory.words.ctypes.data, place.ctypes.data) == 0 and place[0] > 1.0
    assert memory.library.hydrocrane_notices(memory.words.ctypes.data) == 0
    assert memory.library.hydrocrane_suspects(memory.words.ctypes.data) == 0


def test_memory_that_does_not_do_is_refused(library, block):
    parameters, size = block
    memory = Memory(library, size)
    assert memory.create(parameters, offset=4) == 2
    assert [memory.create(parameters, size=n) for n in (0, 8, 16, 1000)] == [3, 3, 3, 3]
    assert library.hydrocrane_create(None, size, parameters, len(parameters)) == 1
    assert library.hydrocrane_create(memory.words.ctypes.data, size, None, 0) == 1
    assert memory.step() == 8, "nothing was created"
    assert library.hydrocrane_period(memory.words.ctypes.data) == 0.0
    assert [library.hydrocrane_notices(None), library.hydrocrane_suspects(None)] == [0, 0]
    assert library.hydrocrane_sensor_fault(None, 0) == 0


def test_parameters_that_are_none_are_refused(library, block):
    parameters, size = block
    memory = Memory(library, size)
    assert [memory.create(bad) for bad in (b"\0", bytes(200), parameters[:20])] == [4, 4, 4]
    assert [memory.create(bad) for bad in (parameters[:-8], parameters[:1000], parameters + bytes(8))] == [5, 5, 5]
    for place in range(32, len(parameters), 97):
        damaged = bytearray(parameters)
        damaged[place] ^= 1
        assert memory.create(bytes(damaged)) == 5, place
    other = bytearray(parameters)
    other[8] ^= 1
    assert memory.create(with_checksum(other)) == 6
    for joints in (0, 2, 9, 2**60):
        other = bytearray(parameters)
        other[24:32] = struct.pack("<Q", joints)
        assert memory.create(with_checksum(other)) in (6, 7), joints
    assert memory.create(parameters) == 0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_reading_that_is_no_number_centres_the_spools(memory, bad):
    assert memory.step() == 0
    for sample in ({"t": bad}, {"q": (1.9, bad, 0.0)}, {"p": (80e5, 60e5, 70e5, 90e5, 50e5, bad)}):
        assert memory.step(**sample) == 9
        assert np.array_equal(memory.spool, np.zeros(3)), sample
        assert memory.reset(**sample) == 9
    assert memory.step() == 0 and np.all(np.isfinite(memory.spool))


@pytest.mark.parametrize(
    ("sample", "bit", "fault"),
    [
        ({"q": (1.9, np.nan, 0.0)}, 3, 1),
        ({"q": (1.9, 1.7, np.inf)}, 6, 1),
        ({"p": (80e5, 60e5, 70e5, 90e5, 50e5, np.nan)}, 8, 1),
        ({"q": (-1e300, 1.7, 0.0)}, 0, 2),
        ({"p": (80e5, 60e5, 1e13, 90e5, 50e5, 60e5)}, 4, 2),
    ],
)
def test_with_a_monitor_a_bad_reading_is_a_failed_sensor(monitored, sample, bit, fault):
    library, place = monitored.library, monitored.words.ctypes.data
    assert monitored.step((0.0, 0.0)) == 0 and library.hydrocrane_suspects(place) == 0
    told = []
    # A crane at rest: while it moves, readings that stay the same would be suspect too.
    for k in range(1, 40):
        assert monitored.step((0.0, 0.0), t=0.01 * k, **sample) == 0 and np.all(np.isfinite(monitored.spool))
        assert library.hydrocrane_suspects(place) == 1 << bit
        assert [library.hydrocrane_sensor_fault(place, i) for i in range(40)] == [fault * (i == bit) for i in range(40)]
        told.append(library.hydrocrane_notices(place))
    # After 50 ms the crane stops, then the valves close.
    assert told[5] == 1 << 8 and not any(told[:5]) and not any(told[6:])
    assert not np.any(monitored.spool)
    for k in range(40, 140):
        assert monitored.step((0.0, 0.0), t=0.01 * k) == 0
        told.append(library.hydrocrane_notices(place))
    assert 1 << 10 in told and library.hydrocrane_suspects(place) == 0
    assert library.hydrocrane_sensor_fault(place, bit) == 0
    assert monitored.step(t=1.4) == 0 and np.any(monitored.spool)


def test_a_monitor_never_begins_without_readings_nor_takes_a_time_that_is_none(monitored):
    nothing = {"q": (np.nan,) * 3, "p": (np.nan,) * 6}
    assert monitored.reset(**nothing) == 0
    assert monitored.step(**nothing) == 0 and not np.any(monitored.spool)
    assert monitored.library.hydrocrane_suspects(monitored.words.ctypes.data) == (1 << 9) - 1
    for bad in (np.nan, np.inf):
        assert monitored.reset(t=bad) == 9 and monitored.step(t=bad) == 9 and not np.any(monitored.spool)


def test_a_stick_that_is_none_centres_the_spools(memory):
    for axes in ((np.nan, 0.0), (0.0, 1.5), (0.0,), (0.0, 0.0, 0.0)):
        assert memory.step(axes) == 10 and not np.any(memory.spool), axes
    assert memory.step((0.0, 0.0, 0.0), mode=LEVERS) == 11
    assert memory.step((0.0, 0.1, 0.0), mode=HEIGHT) == 0
    assert memory.step((0.0, 0.0), mode=7) == 10
    for huge in ((1e300, 0.0, 0.0), (0.0, 0.0, -1e300)):
        assert memory.step(q=huge) == 9 and not np.any(memory.spool), huge


@pytest.mark.parametrize("kind", ["memory", "monitored"])
def test_random_finite_input_never_stops_the_library(kind, request):
    """Readings of all sizes, from a sensor's last bit to far beyond any machine."""
    memory = request.getfixturevalue(kind)
    random = np.random.default_rng(7)
    size = lambda n: random.choice([-1.0, 0.0, 1.0], n) * 10.0 ** random.uniform(-12.0, 12.0, n)  # noqa: E731
    answers = set()
    for k in range(1500):
        near = k % 3 == 0
        q = np.array([1.9, 1.7, 0.0]) + 0.1 * random.standard_normal(3) if near else size(3)
        p = 70e5 + 20e5 * random.standard_normal(6) if near else size(6)
        if k % 50 == 0:
            memory.reset(q=q, p=p)
        answers.add(memory.step(random.uniform(-1.0, 1.0, 2), t=0.01 * k, q=q, p=p))
        assert np.all(np.isfinite(memory.spool)), (q, p)
    assert 0 in answers and answers <= {0, 12}, answers


def test_whatever_is_missing_the_commands_are_zero(memory, block):
    """Without a controller, and with pointers that are null or lie askew."""
    function, place = memory.library.hydrocrane_step, memory.words.ctypes.data
    good, axes, spool = memory.sample(), np.zeros(8), memory.spool
    sample, stick, out = ctypes.byref(good), axes.ctypes.data, spool.ctypes.data
    empty = np.zeros(block[1] // 8, dtype=np.uint64).ctypes.data
    askew = ctypes.byref(Sample(0.0, good.q + 4, good.p))
    huge = 2**64 - 1
    for given, status in {
        (None, sample, TIP, stick, 2): 1,
        (place + 4, sample, TIP, stick, 2): 2,
        (empty, sample, TIP, stick, 2): 8,
        (place, None, TIP, stick, 2): 1,
        (place, ctypes.byref(Sample(0.0, None, None)), TIP, stick, 2): 1,
        (place, askew, TIP, stick, 2): 2,
        (place, sample, TIP, None, 2): 1,
        (place, sample, TIP, stick + 4, 2): 2,
        (place, sample, TIP, stick, huge): 10,
        (place, sample, LEVERS, stick, huge // 8): 10,
        (place, sample, 7, stick, 3): 10,
    }.items():
        spool[:] = 0.02
        assert function(*given, out, 3) == status, given
        assert not np.any(spool), given
    assert function(place, sample, TIP, stick, 2, None, 3) == 1
    for room in (0, 2, 4):
        wide = np.full(4, 0.02)
        assert function(place, sample, TIP, stick, 2, wide.ctypes.data, room) == 15
        assert not np.any(wide[:room]) and np.all(wide[room:] == 0.02)
    bytes_of = np.full(8 * 4, 7, dtype=np.uint8)
    assert function(place, sample, TIP, stick, 2, bytes_of.ctypes.data + 1, 3) == 2
    assert not np.any(bytes_of[1:25]) and np.all(bytes_of[25:] == 7)
    assert memory.library.hydrocrane_reset(place, None) == 1


def test_sample_and_axes_may_lie_where_the_commands_go(library, block):
    one, two = (Memory(library, block[1]) for _ in range(2))
    for memory in (one, two):
        assert memory.create(block[0]) == 0 and memory.reset() == 0
    assert one.step((0.0, 0.2)) == 0
    shared = np.array([0.0, 0.2, 0.0])
    for place in (shared, two.sample()):
        if place is not shared:
            one.step((0.0, 0.2), t=0.01)
        sample = two.sample(t=0.0 if place is shared else 0.01)
        stick, out = (shared, shared) if place is shared else (np.array([0.0, 0.2]), two.q)
        answer = library.hydrocrane_step(
            two.words.ctypes.data, ctypes.byref(sample), TIP, stick.ctypes.data, 2, out.ctypes.data, 3
        )
        assert answer == 0 and np.array_equal(out, one.spool)


def test_every_status_has_words(library):
    texts = [library.hydrocrane_text(status).decode() for status in range(16)]
    assert len(set(texts)) == 16 and "null" in texts[1] and "no status" in library.hydrocrane_text(99).decode()


def test_what_cannot_be_exported_is_one_clear_error(tmp_path):
    with pytest.raises(hc.InputError, match="heinze-pid"):
        hc.export_controller(CRANE, tmp_path, controller="heinze")
    for delay in (-0.01, np.nan, np.inf, (0.01, 0.02)):
        with pytest.raises(hc.InputError, match="delay"):
            hc.export_controller(CRANE, tmp_path / "late", delay=delay)
    with pytest.raises(hc.MachineFileError, match="ride-through"):
        hc.load_machine(CRANE, {"control.plausibility.ride-through": "-5 ms"})
    assert not (tmp_path / "late").exists()
    (tmp_path / "file").write_text("")
    with pytest.raises(hc.ResultFileError, match="folder"):
        hc.export_controller(CRANE, tmp_path / "file")
    corners = [f"({5.0 + np.cos(a):.3f}, {5.0 + np.sin(a):.3f}) m" for a in np.linspace(0.0, 6.0, 20)]
    file = tmp_path / "round.toml"
    file.write_text(f'extends = "{CRANE}"\n[keep-out.round]\nclass = "assumed"\noutline = {corners}\n')
    with pytest.raises(hc.InputError, match="16 corners"):
        hc.export_controller(file, tmp_path / "c")
    assert not (tmp_path / "c").exists()

"""The bridge over UDP and WebSocket: packets, clock, watchdog, wrong input, a controller, a client in C."""

from __future__ import annotations

import json
import runpy
import shutil
import struct
import subprocess
import sys
import time
import types
from pathlib import Path

import numpy as np
import pytest
from bridge_program import HERE, Program, plant, served
from command_line import run

import hydrocrane as hc
from hydrocrane.app.serving import bridge as bridge_module
from hydrocrane.app.serving.bridge import Bridge, part_of, transport_of
from hydrocrane.app.serving.bridge_transport import Address, Kind, Packet, PacketFlag, address_of, is_local

CLIENT = Path(__file__).parents[3] / "docs/howto/bridge_client.c"


@pytest.mark.parametrize("scheme", ["udp", "ws"])
def test_a_crane_moves_as_it_is_told_in_real_time(scheme):
    with served(plant(period="5 ms"), scheme, watchdog=5.0) as (program, bridge):
        told = program.describe()
        assert told["role"] == "plant" and told["period"] == 5e-3 and told["machine"] == "single-cylinder"
        (command,) = told["inputs"]
        assert command["unit"] == "m" and command["high"] == -command["low"] > 0
        names = [output["name"] for output in told["outputs"]]
        place = names.index("joint.test.q") if "joint.test.q" in names else 0
        program.send(Packet(Kind.reset, 1).packed())
        first, began = program.next(Kind.sample), time.monotonic()
        while first.sequence != 1:
            # Sent before the reset came.
            first = program.next(Kind.sample)
        assert first.time == 0.0
        program.values(7, 0.0, [0.5 * command["high"]])
        sample = first
        while sample.time < 0.3:
            sample = program.next(Kind.sample)
        assert sample.sequence == 7 and len(sample.values) == len(names)
        assert sample.values[place] > first.values[place] + 1e-3
        # Simulated time is not ahead of the clock.
        assert time.monotonic() - began > 0.25
    assert bridge.record.samples > 50 and bridge.record.problems == 0


def test_what_is_simulated_is_what_a_simulator_gives():
    """The same commands at the same samples: the same bits."""
    part = plant(period="5 ms")
    machine = hc.load_machine("single-cylinder")
    simulator = hc.Simulator(machine, 5e-3)
    obs = simulator.reset(q=machine.home)
    for k in range(40):
        values = [1e-3 * np.sin(k)]
        got, obs = part.step(part.time, values), simulator.step(values)
        assert got[0] == obs.q[0] and part.time == simulator.time


def test_silence_centres_the_spools():
    heard = []
    part = plant(period="5 ms")
    step = part.step
    part.step = lambda at, values: heard.append(tuple(values)) or step(at, values)
    with served(part, watchdog=0.1) as (program, _):
        program.values(1, 0.0, [1e-3])
        assert not program.next(Kind.sample).flags & PacketFlag.watchdog
        sample = program.next(Kind.sample)
        while not sample.flags & PacketFlag.watchdog:
            sample = program.next(Kind.sample)
        program.values(2, 1.0, [2e-3])
        while sample.flags & PacketFlag.watchdog:
            sample = program.next(Kind.sample)
    assert (1e-3,) in heard and (0.0,) in heard and (2e-3,) in heard
    assert heard.index((1e-3,)) < heard.index((0.0,), heard.index((1e-3,))) < heard.index((2e-3,))


@pytest.mark.parametrize("scheme", ["udp", "ws"])
def test_one_packet_starts_no_stream_without_an_end(monkeypatch, scheme):
    monkeypatch.setattr(bridge_module, "_SILENCE", 0.3)
    part = plant(period="5 ms")
    with served(part, scheme, watchdog=0.1) as (program, bridge):
        sent, send = [], bridge._send
        monkeypatch.setattr(bridge, "_send", lambda packet, peer=None: sent.append(packet.kind) or send(packet, peer))
        program.describe()
        time.sleep(0.6)
        assert 20 < sent.count(Kind.sample) < 100
        # The crane goes on meanwhile, and the program finds it again.
        program.values(1, 0.0, [1e-3])
        found = program.next(Kind.sample).time
        assert len(sent) > 1
    # Asked once the thread that steps the crane has ended: no other one may look at a simulator while it steps.
    assert part.time > 0.4 and found < part.time + 0.1


GOOD = Packet(Kind.values, 1, 0.5, values=(1e-3,)).packed()
BAD = {
    "short": (GOOD[:20], "32 bytes"),
    "magic": (b"XXXX" + GOOD[4:], "begins with"),
    "version": (GOOD[:4] + struct.pack("<H", 9) + GOOD[6:], "version 9"),
    "kind": (GOOD[:6] + struct.pack("<H", 18) + GOOD[8:], "kind 18"),
    "count": (Packet(Kind.values, 1, 0.5, values=(1e-3, 0.0)).packed(), "1 values here; this one says 2"),
    "length": (GOOD + b"\0", "40 bytes; this one has 41"),
    "time": (Packet(Kind.values, 1, float("nan"), values=(0.0,)).packed(), "the time of a packet"),
    "no number": (Packet(Kind.values, 1, 0.5, values=(float("nan"),)).packed(), "is a number"),
    "beyond": (Packet(Kind.values, 1, 0.5, values=(1.0,)).packed(), "between -0.05 and 0.05"),
    "past": (Packet(Kind.values, 1, 0.1, values=(0.0,)).packed(), "time of packets must increase"),
}


@pytest.mark.parametrize("scheme", ["udp", "ws"])
def test_wrong_packets_are_answered_and_change_nothing(scheme):
    with served(plant(period="5 ms"), scheme, watchdog=5.0) as (program, bridge):
        program.values(1, 0.2, [1e-3])
        for data, words in BAD.values():
            program.send(data)
            assert words in program.next(Kind.problem).text
        sample = program.next(Kind.sample)
        assert sample.sequence == 1 and not sample.flags & ~PacketFlag.late
    assert bridge.record.problems == len(BAD)


@pytest.mark.parametrize("scheme", ["udp", "ws"])
def test_one_program_at_a_time(monkeypatch, scheme):
    monkeypatch.setattr(bridge_module, "_SILENCE", 0.3)
    with served(plant(period="5 ms"), scheme) as (first, bridge):
        first.describe()
        second = Program(bridge.address)
        second.send(Packet(Kind.hello).packed())
        assert "another program" in second.next(Kind.problem).text
        time.sleep(0.4)
        assert second.describe()["role"] == "plant"
        second.close()


def test_what_ends_is_told_and_begins_anew_after_a_reset():
    part = plant(period="5 ms")
    step = part.step

    def ends(at, values):
        if part.time > 0.05:
            raise hc.SimulationError("the simulation ended with `solver-failed` at 0.05 s")
        return step(at, values)

    part.step = ends
    with served(part, watchdog=5.0) as (program, _):
        program.values(1, 0.0, [0.0])
        assert "solver-failed" in program.next(Kind.problem).text
        sample = program.next(Kind.sample)
        assert sample.flags & PacketFlag.ended and sample.time > 0.05
        program.send(Packet(Kind.reset, 5).packed())
        while sample.sequence != 5:
            sample = program.next(Kind.sample)
        assert not sample.flags & PacketFlag.ended and sample.time < 0.05


@pytest.mark.parametrize("scheme", ["udp", "ws"])
def test_a_controller_behind_the_bridge_gives_the_bits_of_the_one_in_the_loop(scheme):
    crane = hc.load_machine("rottne-f9-lab")
    start, stick = np.array([np.deg2rad(100.0), np.deg2rad(100.0), 0.0]), [0.1, 0.3]
    direct, near = hc.NamedController("tip", crane), hc.Simulator(crane)
    obs = near.reset(q=start)
    direct.reset(crane, obs)
    with served(part_of("rottne-f9-lab", {}, controller="tip"), scheme) as (program, _):
        told = program.describe()
        assert told["role"] == "controller" and told["watchdog"] is None
        assert [i["name"] for i in told["inputs"]][-2:] == ["stick.x", "stick.z"]
        for k in range(60):
            program.values(k, obs.t, [*obs.q, *obs.p.ravel(), *stick])
            answer = program.next(Kind.sample)
            command = direct.step(obs, hc.Stick("tip", np.array(stick)))
            assert answer.sequence == k and list(answer.values) == command
            obs = near.step(command)
        # Readings may be missing, sticks may not; uneven samples are told.
        program.values(60, obs.t + 0.05, [np.nan] * 9 + stick)
        assert "apart" in program.next(Kind.problem).text
        program.values(61, obs.t + 0.06, [0.0] * 9 + [2.0, 0.0])
        assert "stick.x" in program.next(Kind.problem).text


def test_a_scenario_is_driven_by_its_sticks():
    with served(part_of("tip-vertical-line", {}), watchdog=5.0) as (program, _):
        told = program.describe()
        assert [i["name"] for i in told["inputs"]] == ["stick.x", "stick.z"] and told["period"] == 0.01
        height = [o["name"] for o in told["outputs"]].index("tip.z")
        program.values(1, 0.0, [0.0, 1.0])
        first = sample = program.next(Kind.sample)
        while sample.time < first.time + 0.5:
            sample = program.next(Kind.sample)
        assert sample.values[height] > first.values[height] + 0.01


def test_addresses():
    assert address_of("udp://127.0.0.1:5005") == Address("udp", HERE, 5005)
    assert str(address_of("ws://[::1]:0")) == "ws://[::1]:0"
    assert is_local(HERE) and is_local("::1") and is_local("localhost")
    assert not is_local("0.0.0.0") and not is_local("crane.example")
    for wrong in (
        "127.0.0.1:5005",
        "tcp://127.0.0.1:5005",
        "udp://127.0.0.1",
        "udp://127.0.0.1:99999",
        "udp://:1/x",
        "ws://[::1:5",
    ):
        with pytest.raises(hc.InputError, match="udp://HOST:PORT"):
            address_of(wrong)
    with served(plant()) as (_, bridge), pytest.raises(hc.InputError, match="cannot use"):
        transport_of(bridge.address)
    with served(plant()) as (_, bridge), pytest.raises(hc.InputError, match="watchdog"):
        Bridge(plant(), bridge._transport, watchdog=0.0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--bridge", "tcp://127.0.0.1:1"], "udp://HOST:PORT"),
        (["--bridge", "udp://127.0.0.1:0", "--watchdog", "100"], "--watchdog"),
        (["--bridge", "udp://127.0.0.1:0", "--period", "1 bar"], "--period"),
        (["--bridge", "udp://127.0.0.1:0", "--controller", "tipp"], "tip"),
        (["--bridge", "udp://127.0.0.1:0", "--controller", "tip", "--period", "1 ms"], "control.period"),
        (["--controller", "tip"], "--bridge"),
    ],
)
def test_wrong_options_are_one_message(arguments, words):
    done = run("live", "rottne-f9-lab", "--no-browser", *arguments)
    assert done.returncode == 2 and done.stderr.count("error:") == 1
    assert words in done.stderr


def test_a_scenario_without_controller_is_its_loaded_crane_at_rest_and_nothing_against_time(tmp_path):
    start = {"boom": 1.7, "jib": 1.7, "extension": 0.2}
    plan = hc.Scenario(joints=start, payload=100.0, duration=1.0)
    crane = part_of(str(plan.save(tmp_path / "still.toml")), {})
    began = crane.now()
    for _ in range(200):
        crane.step(crane.time, [0.0, 0.0, 0.0])
    assert crane.time == pytest.approx(0.2) and np.abs(np.subtract(crane.now(), began))[:3].max() < 1e-4
    torn = plan.changed(bursts=hc.Burst("lift", "rod-side", 0.1, 1e-6)).save(tmp_path / "torn.toml")
    with pytest.raises(hc.InputError, match="torn.toml has hoses that burst.*leave `bursts` out"):
        part_of(str(torn), {})


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"phases": [hc.Phase(0.5, {"supply.pressure": "100 bar"})]}, "plan.toml has phases.*leave `phases` out"),
        ({"payload_changes": {0.5: 30.0}}, "loads that come and go.*leave `payload_changes` out"),
        ({"goals": [hc.Goal(0.5, 2.6, 0.35)]}, "goals of the tip.*leave `goals` out"),
    ],
)
def test_a_plan_that_an_operator_ends_is_refused(more, words, tmp_path):
    plan = hc.Scenario(joints={"boom": 1.7, "jib": 1.7, "extension": 0.2}, controller="tip", **more)
    with pytest.raises(hc.InputError, match=words):
        part_of(str(plan.save(tmp_path / "plan.toml")), {})


def test_a_scenario_with_controller_has_its_faults_bursts_and_supply(tmp_path):
    plan = hc.Scenario(
        joints={"boom": 1.7, "jib": 1.7, "extension": 0.2},
        joystick=hc.Joystick([0.0], {"x": [1.0]}, full_speed=0.2, dead_zone=0.1),
        sensor_faults=[hc.SensorFault("cylinder.lift.p1", "freeze", 0.1)],
        bursts=[hc.Burst("lift", "piston-side", 0.2, 5e-6)],
        supply=hc.SupplyPressure([0.0, 0.3], [140e5, 100e5]),
    )
    part, alone = part_of(str(plan.save(tmp_path / "plan.toml")), {}), hc.LiveSimulator(plan)
    for _ in range(50):
        part.step(part.time, [0.0, 0.5])
        alone.set_stick(z=0.5)
        alone.step()
    told = dict(zip([signal.name for signal in part.outputs], part.now(), strict=True))
    seen = alone.observation
    assert told["measured.cylinder.lift.p1"] == seen.measured["cylinder.lift.p1"] != told["cylinder.lift.p1"]
    assert (told["tip.x"], told["tip.z"]) == tuple(seen.tip)
    assert alone.scenario().bursts == plan.bursts


def test_a_crane_under_spool_commands_has_the_solver_of_its_scenario(tmp_path):
    plan = hc.Scenario(joints={"boom": 1.7, "jib": 1.7, "extension": 0.2}, solver=hc.Solver("tsit5", rtol=1e-6))
    crane = part_of(str(plan.save(tmp_path / "still.toml")), {})
    other = hc.Simulator(plan.load_machine(), 1e-3, method="tsit5", rtol=1e-6)
    other.reset(state=plan.initial_state(plan.load_machine()))
    for _ in range(50):
        crane.step(crane.time, [0.01, 0.0, 0.0])
        seen = other.step([0.01, 0.0, 0.0])
    assert crane.now()[:3] == seen.q.tolist()


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_a_program_in_c(tmp_path):
    program = tmp_path / "client"
    subprocess.run(["cc", "-O2", "-Wall", "-Wextra", "-Werror", "-o", program, CLIENT], check=True)
    with served(part_of("rottne-f9-lab", {})) as (_, bridge):
        port = str(address_of(bridge.address).port)
        done = subprocess.run([program, port], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    description, result = done.stdout.splitlines()
    assert json.loads(description)["machine"] == "rottne-f9-lab"
    assert float(result.split("up by")[1].split()[0]) > 0.005


def test_the_node_for_ros_2_publishes_joints_and_steers(monkeypatch):
    """ROS is not here: its modules are stood in for, the node and the bridge are real."""
    published, timers = [], []

    class Node:
        def __init__(self, name):
            pass

        def create_publisher(self, *_):
            return types.SimpleNamespace(publish=published.append)

        def create_subscription(self, *_):
            pass

        def create_timer(self, period, call):
            timers.append((period, call))

        def get_clock(self):
            now = types.SimpleNamespace(nanoseconds=time.monotonic_ns())
            return types.SimpleNamespace(now=lambda: now)

        def get_logger(self):
            return types.SimpleNamespace(warning=pytest.fail)

    def joint_state(name):
        header = types.SimpleNamespace(stamp=types.SimpleNamespace())
        return types.SimpleNamespace(name=name, header=header)

    for name, has in {
        "rclpy": {},
        "rclpy.node": {"Node": Node},
        "geometry_msgs": {},
        "geometry_msgs.msg": {"Twist": object},
        "sensor_msgs": {},
        "sensor_msgs.msg": {"JointState": joint_state},
    }.items():
        monkeypatch.setitem(sys.modules, name, types.SimpleNamespace(**has))
    names = runpy.run_path(str(CLIENT.with_name("ros2_node.py")))
    with served(part_of("tip-vertical-line", {}), watchdog=5.0) as (_, bridge):
        node = names["Crane"](address_of(bridge.address).port)
        ((period, tick),) = timers
        assert period == 0.01
        node.steer(types.SimpleNamespace(linear=types.SimpleNamespace(x=0.0, z=3.0)))
        for _ in range(60):
            tick()
            time.sleep(period)
        node.socket.close()
    assert published[-1].name == ["boom", "jib", "extension"]
    assert abs(published[-1].position[0] - published[0].position[0]) > 1e-3
    assert published[-1].header.stamp.nanosec > 0


@pytest.mark.parametrize("solver", [hc.Solver(atol=1e-9), hc.Solver(max_step=1e-4)], ids=["atol", "max_step"])
def test_settings_of_a_solver_that_the_bridge_has_not_are_refused(solver, tmp_path):
    plan = hc.Scenario(joints={"boom": 1.7, "jib": 1.7, "extension": 0.2}, solver=solver)
    with pytest.raises(hc.InputError, match="states `solver.(atol|max-step)`"):
        part_of(str(plan.save(tmp_path / "still.toml")), {})

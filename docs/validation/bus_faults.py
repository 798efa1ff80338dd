"""Common faults of a bus while ``tip`` drives: a section of ``docs/validation/sensor-faults.md``.

All readings of a sample travel in one frame, 16 bits each, the high byte first: joints signed, pressures unsigned.
``python docs/validation/bus_faults.py`` prints the table.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import hydrocrane as hc

# With what they carry at the tip, kg.
MACHINES = {"rottne-f9-lab": 150.0, "rottne-f9-ls": 150.0, "hiab-xs031": 0.0}
FAIL, RELEASE, END = 1.0, 2.0, 3.5
DIRECTIONS = ((0.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0))
HIGHEST = 600e5
COUNT = 8.0 / 32767

Frame = NDArray[np.uint16]
# What arrives in place of the last of the frames sent so far; `None`: nothing. The number of joints comes with them.
Fault = Callable[[list[Frame], int], "Frame | None"]


class Case(NamedTuple):
    """A fault, by the number of samples that it lasts; ``None`` is for good."""

    name: str
    fault: Fault
    samples: int | None


def of_part(fault: Fault, joints: bool) -> Fault:
    """A fault of the joints' words or of the pressures' words alone."""

    def at(sent: list[Frame], n: int) -> Frame | None:
        whole, frame = fault(sent, n), sent[-1].copy()
        if whole is None:
            return None
        part = slice(0, n) if joints else slice(n, None)
        frame[part] = whole[part]
        return frame

    return at


def zeroed(sent: list[Frame], _: int) -> Frame:
    return np.zeros_like(sent[-1])


def ones(sent: list[Frame], _: int) -> Frame:
    return np.full_like(sent[-1], 0xFFFF)


def lost(_sent: list[Frame], _: int) -> None:
    return None


def frozen(sent: list[Frame], _: int) -> Frame:
    return sent[round(FAIL / 0.01)]


def swapped(sent: list[Frame], _: int) -> Frame:
    return sent[-1].byteswap()


def late(by: int) -> Fault:
    return lambda sent, _: sent[-1 - by]


def flipped(bit: int) -> Fault:
    return lambda sent, _: sent[-1] ^ np.uint16(1 << bit)


def shifted(sent: list[Frame], _: int) -> Frame:
    return np.roll(sent[-1], 1)


def exchanged(sent: list[Frame], n: int) -> Frame:
    """The two pressures of each cylinder."""
    return np.concatenate([sent[-1][:n], sent[-1][n:].reshape(-1, 2)[:, ::-1].ravel()])


def halved(sent: list[Frame], _: int) -> Frame:
    return sent[-1] >> np.uint16(1)


def after_gap(samples: int, fault: Fault, gap: Fault = lost) -> Fault:
    """Nothing arrives for some samples, then the fault."""
    first = round(FAIL / 0.01)
    return lambda sent, n: (gap if len(sent) - 1 < first + samples else fault)(sent, n)


CASES = (
    Case("frame zeroed", zeroed, 1),
    Case("frame zeroed", zeroed, 5),
    Case("frame zeroed", zeroed, None),
    Case("joints zeroed", of_part(zeroed, True), None),
    Case("pressures zeroed", of_part(zeroed, False), None),
    Case("10 ms nothing, then zeroed", after_gap(1, zeroed), None),
    Case("50 ms nothing, then zeroed", after_gap(5, zeroed), None),
    Case("50 ms without pressures, then zeroed", after_gap(5, zeroed, of_part(lost, False)), None),
    Case("frame of ones", ones, 1),
    Case("frame of ones", ones, None),
    Case("frame lost", lost, 1),
    Case("frame lost", lost, 5),
    Case("frame lost", lost, None),
    Case("frame repeated", late(1), 1),
    Case("frame frozen", frozen, 5),
    Case("frame frozen", frozen, None),
    Case("one frame late", late(1), None),
    Case("two frames late", late(2), None),
    Case("bytes swapped", swapped, 1),
    Case("bytes swapped", swapped, None),
    Case("bit 14 flipped", flipped(14), 1),
    Case("bit 12 flipped", flipped(12), None),
    Case("words shifted by one", shifted, 1),
    Case("words shifted by one", shifted, None),
    Case("pressures exchanged", exchanged, None),
    Case("words halved", halved, None),
)


class Drive(NamedTuple):
    tip: NDArray[np.float64]
    spools: NDArray[np.float64]
    seen: float | None


def drive(machine: hc.Machine, payload: float, stick: Sequence[float], case: Case | None) -> Drive:
    """A drive with the stick held until it is let go; a fault meets the frames from its time on."""
    plant, controller = hc.Simulator(machine, 0.01, payload=payload), hc.NamedController("tip", machine)
    n = len(machine.joint_names)
    obs = plant.reset(q=machine.home)
    controller.reset(machine, obs)
    sent: list[Frame] = []
    tip, spools, seen = [], [], None
    for k in range(round(END / 0.01)):
        joints = np.clip(np.round(obs.q / COUNT), -32768, 32767).astype(np.int16).view(np.uint16)
        pressures = np.clip(np.round(obs.p.ravel() * 65535 / HIGHEST), 0, 65535).astype(np.uint16)
        sent.append(np.concatenate([joints, pressures]))
        begun = k - round(FAIL / 0.01)
        fails = case is not None and begun >= 0 and (case.samples is None or begun < case.samples)
        frame = case.fault(sent, n) if fails and case else sent[-1]
        if frame is None:
            q, p = np.full(n, np.nan), np.full(obs.p.shape, np.nan)
        else:
            q = frame[:n].view(np.int16) * COUNT
            p = (frame[n:] * (HIGHEST / 65535)).reshape(obs.p.shape)
        read = dataclasses.replace(obs, q=q, p=p, measured={})
        axes = np.array(stick) * (0.3 <= obs.t < RELEASE)
        command = controller.step(read, hc.Stick("tip", axes))
        if seen is None and any("the crane stops" in notice for notice in controller.notices):
            seen = obs.t - FAIL
        obs = plant.step(command)
        tip.append(obs.tip)
        spools.append(command)
    return Drive(np.array(tip), np.array(spools), seen)


def rows() -> list[str]:
    lines = ["| frame | lasts | stopped | after | way | astray | spool |", "|---|---|---|---|---|---|---|"]
    cranes = [(hc.load_machine(name), payload) for name, payload in MACHINES.items()]
    sound = [[drive(*crane, stick, None) for stick in DIRECTIONS] for crane in cranes]
    for case in CASES:
        seen, way, astray, spool = [], 0.0, 0.0, 0.0
        for crane, of_crane in zip(cranes, sound, strict=True):
            for stick, healthy in zip(DIRECTIONS, of_crane, strict=True):
                found = drive(*crane, stick, case)
                if found.seen is not None:
                    seen.append(found.seen)
                off = found.tip[round(FAIL / 0.01) :] - found.tip[round(FAIL / 0.01)]
                along = np.array(stick)
                aside = off - np.outer(off @ along, along)
                way = max(way, float(np.hypot(*off.T).max()))
                astray = max(astray, float(np.hypot(*aside.T).max()))
                spool = max(spool, float(np.abs(found.spools - healthy.spools)[: round(RELEASE / 0.01)].max()))
        lasts = "for good" if case.samples is None else f"{case.samples * 10} ms"
        after = f"{1e3 * max(seen):.0f} ms" if seen else "-"
        lines.append(
            f"| {case.name} | {lasts} | {len(seen)} of {len(cranes) * len(DIRECTIONS)} | {after} | {way * 1e3:.1f} mm "
            f"| {astray * 1e3:.1f} mm | {spool * 1e3:.1f} mm |"
        )
    return lines


if __name__ == "__main__":
    print("\n".join(rows()))

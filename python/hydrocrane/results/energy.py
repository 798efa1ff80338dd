"""Energy sources and sinks of a run, summed from its ledger."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from hydrocrane.errors import InputError
from hydrocrane.files.columns import Columns
from hydrocrane.results.record import Record

# Energy from the pump line to the valves, and from them to the tank line, each with its counterpart: internal
# transfers, which cancel.
HANDED_ON = {"delivered": "supply", "returned": "tank"}
# Terms of external energy; all other terms of positive sign are elastic energy that oil carries in.
SOURCES = ("shaft", "supply", "load")
# Stored energies under one name.
STORED = {
    "energy.kinetic": "crane lifted and moving",
    "energy.potential": "crane lifted and moving",
    "energy.oil": "oil compressed and carried",
    "energy.end_stops": "springs of the end stops",
    "energy.bristles": "bristles of the seals",
    "energy.ground": "spring of the ground",
}
CARRIED = STORED["energy.oil"]
# Names for terms whose meaning does not name the source or sink.
PLACES = {
    "shaft": "shaft of the pump",
    "supply": "supply",
    "load": "loads picked up less loads let go",
    "tank": "into the tank",
    "into_tank": "into the tank",
}


@dataclass(frozen=True)
class EnergyEntry:
    """One energy source or sink.

    Attributes
    ----------
    name : str
        Name in words.
    parts : mapping
        Energy in J by owner: a cylinder, or an empty text for the whole machine.
    """

    name: str
    parts: Mapping[str, float]

    @property
    def total(self) -> float:
        """J"""
        return sum(self.parts.values())


@dataclass(frozen=True)
class EnergyFlow:
    """Energy from the start of a run to its end: the sum of the sources equals that of the sinks, up to the error of
    the run.

    Attributes
    ----------
    given, taken : tuple of EnergyEntry
        Largest first, each with a total above zero.
    residual : float
        Largest difference, at any time, between energy input and stored plus lost energy, J.
    """

    given: tuple[EnergyEntry, ...]
    taken: tuple[EnergyEntry, ...]
    residual: float

    @property
    def total(self) -> float:
        """Sum of the sources, J."""
        return sum(entry.total for entry in self.given)

    @property
    def gap(self) -> float:
        """Sum of the sources less that of the sinks, J: the error at the end."""
        return self.total - sum(entry.total for entry in self.taken)


@dataclass(frozen=True)
class EnergyBalance:
    """Energy of a run from start to end, J.

    Attributes
    ----------
    pump : float
        Work of the pump's shaft, or of an ideal supply, with the elastic energy that its oil carries.
    loads : float
        Energy of loads that are picked up, minus that of loads that are released.
    stored : float
        Gain of kinetic, potential and elastic energy.
    lost : dict
        By place: metering edges, leakage, seal friction, ...
    residual : float
        Largest gap, at any time, between what came in and what was stored or lost.
    """

    pump: float
    loads: float
    stored: float
    lost: dict[str, float]
    residual: float


@dataclass(frozen=True)
class _Term:
    """An entry of the ledger at the end of a run; `energy` in J with the sign of its name."""

    owner: str
    name: str
    text: str
    sign: float
    energy: float


def energy_balance(run: Record) -> EnergyBalance:
    """Sum the ledger of a run over its cylinders and loads."""
    terms = _terms(run.columns)
    stored = _stored(run.columns)
    loads = sum(term.energy for term in terms if (term.owner, term.name) == ("payload", "load"))
    pump = sum(term.energy for term in terms if term.sign > 0) - loads
    lost: dict[str, float] = {}
    for term in terms:
        if term.sign < 0:
            place = _place(term.name)
            lost[place] = lost.get(place, 0.0) + term.energy
    gain = float(sum(values[-1] - values[0] for values in stored.values()))
    return EnergyBalance(pump, loads, gain, lost, _residual(run.columns, stored))


def energy_flow(run: Record) -> EnergyFlow:
    """All energy sources and sinks of a run.

    Raises
    ------
    InputError
        If the run recorded no ledger.
    """
    columns = run.columns
    terms = _terms(columns)
    if not terms or not columns.rows:
        raise InputError(
            "this run has no energy ledger: simulate it without `ledger=False`, with a duration above zero"
        )
    stored = _stored(columns)
    # Energy of the sinks by name and owner, J; sources are negative.
    taken: dict[str, dict[str, float]] = {}

    def take(name: str, owner: str, energy: float) -> None:
        parts = taken.setdefault(name, {})
        parts[owner] = parts.get(owner, 0.0) + energy

    for key, values in stored.items():
        take(STORED.get(key, key), "", float(values[-1] - values[0]))
    for term in terms:
        owner = term.owner if term.owner in run.cylinder_names else ""
        carried = term.sign > 0 and term.name not in SOURCES
        take(CARRIED if carried else term.text, "" if carried else owner, -term.sign * term.energy)
    entries = [
        EnergyEntry(name, {owner: energy for owner, energy in parts.items() if energy}) for name, parts in taken.items()
    ]
    gave = [
        EnergyEntry(e.name, {owner: -energy for owner, energy in e.parts.items()}) for e in entries if e.total < 0.0
    ]
    return EnergyFlow(_largest(gave), _largest(e for e in entries if e.total > 0.0), _residual(columns, stored))


def _largest(entries: Iterable[EnergyEntry]) -> tuple[EnergyEntry, ...]:
    return tuple(sorted(entries, key=lambda entry: -entry.total))


def _terms(columns: Columns) -> list[_Term]:
    """Entries of the ledger that enter the balance, without internal transfers."""
    found = []
    for key, column in columns.items():
        sign = float(column.attrs.get("sign", 0.0)) if key.startswith("ledger.") else 0.0
        if sign and column.values.size:
            owner, _, name = key.removeprefix("ledger.").rpartition(".")
            text = str(column.attrs.get("long_name", name)).rpartition(": ")[2]
            text = PLACES.get(name, re.sub(r"^(?:loss|heat|work) (?:of|against|into) (?:the )?", "", text))
            found.append(_Term(owner, name, text, sign, float(column.values[-1])))
    names = {term.name for term in found}
    handed = {name for pair in HANDED_ON.items() if pair[0] in names for name in pair}
    return [term for term in found if term.name not in handed]


def _stored(columns: Columns) -> dict[str, np.ndarray]:
    return {name: column.values for name, column in columns.items() if name.startswith("energy.")}


def _residual(columns: Columns, stored: Mapping[str, np.ndarray]) -> float:
    """Largest residual over all times; internal transfers cancel."""
    gap = np.sum([values - values[0] for values in stored.values()], axis=0) if stored else np.zeros(columns.rows)
    for name, column in columns.items():
        if name.startswith("ledger."):
            gap = gap - float(column.attrs.get("sign", 0.0)) * column.values
    return float(np.abs(gap).max())


def _place(term: str) -> str:
    if term.startswith("edge_"):
        return "metering edges"
    if term.endswith("_leakage"):
        return "leakage"
    places = {
        "friction": "seal friction",
        "tank": "into the tank",
        "into_tank": "into the tank",
        "filter": "return filter",
        "bypass": "return filter",
        "impact": "impacts of loads",
        "contact": "contact with the ground",
    }
    return places.get(term, term.replace("_", " "))

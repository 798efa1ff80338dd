"""Simulation: whole runs, sample by sample, many cranes at once."""

from __future__ import annotations


def __getattr__(name: str) -> object:
    """`simulate` and its parts, which need more libraries than stepping."""
    if name in ("simulate", "integrate"):
        from hydrocrane.simulation import running

        return getattr(running, name)
    if name == "interruptible":
        from hydrocrane.simulation.interruption import interruptible

        return interruptible
    raise AttributeError(f"module 'hydrocrane.simulation' has no attribute {name!r}")

"""A run in a few lines of text."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from hydrocrane.result import Run


def text(run: Run) -> str:
    """Outcome, effort, tip, cylinders and energy of a run."""
    if not run.data.sizes.get("time"):
        return "\n".join(_head(run))
    return "\n".join([*_head(run), *_tip(run), *_cylinders(run), *_energy(run)])


def _head(run: Run) -> list[str]:
    about, outcome = run.data.attrs, run.outcome
    lines = [f"{about['scenario']} on {about['machine']}: {outcome.kind} at {outcome.time:.4g} s"]
    if outcome.message:
        lines.append(f"  {outcome.message}")
    effort = f"  {about['solver_method']}, rtol {about['solver_rtol']:g}"
    if "solver_steps" in about:
        effort += f": {about['solver_steps']} steps, {about.get('solver_rejected', 0)} rejected"
    wall = float(about.get("wall_time", 0.0))
    if wall > 0 and outcome.time > 0:
        effort += f", {wall * 1e3:.3g} ms ({outcome.time / wall:.3g} x real time)"
    return [*lines, effort]


def _tip(run: Run) -> list[str]:
    if "tip.x" not in run.data:
        return []
    x, z = run.data["tip.x"].values, run.data["tip.z"].values
    way = float(np.hypot(np.diff(x), np.diff(z)).sum())
    return [f"  tip        ({x[0]:.3f}, {z[0]:.3f}) m -> ({x[-1]:.3f}, {z[-1]:.3f}) m, way {way:.3f} m"]


def _cylinders(run: Run) -> list[str]:
    lines = []
    width = max([10, *(len(name) for name in run.cylinder_names)])
    for name in run.cylinder_names:
        parts = [
            f"{label} {_range(run, f'cylinder.{name}.{key}', scale)} {unit}"
            for label, key, scale, unit in (("x", "x", 1e3, "mm"), ("p1", "p1", 1e-5, "bar"), ("p2", "p2", 1e-5, "bar"))
        ]
        lines.append(f"  {name:<{width}} {', '.join(parts)}")
    return lines


def _range(run: Run, name: str, scale: float) -> str:
    values = run.data[name].values * scale
    return f"{values.min():.1f} .. {values.max():.1f}"


def _energy(run: Run) -> list[str]:
    """Largest entries of the ledger at the end of the run, and its residual."""
    entries = {str(n)[7:]: float(v.values[-1]) for n, v in run.data.items() if str(n).startswith("ledger.")}
    if not entries:
        return []
    residual = entries.pop("residual", None)
    largest = sorted(entries.items(), key=lambda entry: -abs(entry[1]))[:4]
    lines = ["  energy     " + ", ".join(f"{name} {value:.4g} J" for name, value in largest)]
    if residual is not None:
        lines.append(f"             ledger residual {residual:.2g} J")
    return lines

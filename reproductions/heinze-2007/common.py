"""Paths, pictures and the adapter to the printed program that the scripts here share."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PICTURES = ROOT / "docs" / "validation" / "heinze-2007"
EXPECTED = HERE / "expected"

_TESTS = str(ROOT / "tests" / "python")
if _TESTS not in sys.path:
    sys.path.insert(0, _TESTS)

from oracles import printed_controller, printed_program  # noqa: E402

__all__ = [
    "EXPECTED",
    "HERE",
    "PICTURES",
    "ROOT",
    "RUN_REPEATABILITY",
    "TABLE_1",
    "completed",
    "figure",
    "printed_controller",
    "printed_program",
    "program_rhs",
    "save",
]

# A controller inside the right-hand side amplifies rounding: twelve runs, each with a relative
# disturbance of 1e-13 on the right-hand side, spread by up to 6 mm at the tip.
RUN_REPEATABILITY = 1e-2
TABLE_1 = {"alpha": np.deg2rad([45.0, 172.0]), "beta": np.deg2rad([5.0, 178.0]), "x3": np.array([-0.315, 0.315])}


def figure(rows: int = 1, columns: int = 1, size: tuple[float, float] = (7.0, 4.0)):
    """A new matplotlib figure and its axes, drawn without a display."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    fig, axes = plt.subplots(rows, columns, figsize=size, layout="constrained", squeeze=False)
    for axis in axes.flat:
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
    return fig, axes


def save(fig, name: str) -> None:
    """Write one picture of the validation page and release the figure."""
    import matplotlib.pyplot as plt

    PICTURES.mkdir(parents=True, exist_ok=True)
    fig.savefig(PICTURES / f"{name}.png", dpi=110, metadata={"Software": None})
    plt.close(fig)


def completed(run):
    """The data of a run that has reached its end; what ended early would be judged before anything moves."""
    if run.outcome.kind != "completed":
        raise RuntimeError(f"{run.data.attrs['machine']} ended at {run.outcome.time:g} s: {run.outcome.message}")
    return run.data


def program_rhs(crane):
    """hydrocrane's state derivative, taking and returning states in the thesis's order."""
    order = np.array([crane.state_names.index(name) for name in printed_program.STATE_NAMES])
    inverse = np.argsort(order)

    def rhs(state: np.ndarray, command: np.ndarray) -> np.ndarray:
        return np.asarray(crane.state_derivative(state[inverse], command))[order]

    return rhs

"""Linear models for other programs: python-control, MATLAB, JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hydrocrane.errors import InputError
from hydrocrane.files.datasets import plain_name, plain_names
from hydrocrane.files.whole_file import checked_suffix, write_text, written_whole

if TYPE_CHECKING:
    import control

    from hydrocrane.state_space.matrices import Matrices

NUMBERS = ("A", "B", "C", "D", "x", "u", "y", "drift", "output_error")
LABELS = ("state_names", "state_units", "input_names", "input_units", "output_names", "output_units")
SUFFIXES = (".mat", ".json")


def state_space(model: Matrices) -> control.StateSpace:
    """See :meth:`hydrocrane.linear.LinearModel.to_control`."""
    try:
        import control
    except ImportError:
        raise InputError("to_control needs the package control; install hydrocrane[control]") from None
    return control.ss(
        model.A,
        model.B,
        model.C,
        model.D,
        states=list(plain_names(model.state_names).values()),
        inputs=list(plain_names(model.input_names).values()),
        outputs=list(plain_names(model.output_names).values()),
        name=plain_name(model.machine),
    )


def save(model: Matrices, path: Path) -> Path:
    """See :meth:`hydrocrane.linear.LinearModel.save`."""
    if checked_suffix(path, SUFFIXES) == ".json":
        content = {
            **{name: getattr(model, name).tolist() for name in NUMBERS},
            **{name: list(getattr(model, name)) for name in LABELS},
            "about": dict(model.about),
        }
        return write_text(path, json.dumps(content, indent=1) + "\n")
    from scipy.io import savemat

    # Cell arrays of names, as `ss` of MATLAB expects them.
    cells = {name: np.array(getattr(model, name), dtype=object) for name in LABELS}
    matrices = {name: getattr(model, name) for name in NUMBERS}
    with written_whole(path) as beside:
        savemat(beside, {**matrices, **cells, "about": dict(model.about)}, oned_as="column")
    return path

"""One run of a study: its arrays by name, labelled only on request."""

from __future__ import annotations

from functools import cached_property, lru_cache

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.errors import check_known
from hydrocrane.machine.machine import Machine
from hydrocrane.result_warning import ResultWarning
from hydrocrane.results.dataset import outputs_table, run_dataset
from hydrocrane.results.outcome import Outcome
from hydrocrane.results.recording import Recording
from hydrocrane.results.run import Run
from hydrocrane.scenario.scenario import Scenario

# Its tables take longer than a run of a few seconds.
OIL = "energy.oil"


class CaseRecord:
    """The core's record of a run.

    Attributes
    ----------
    machine : Machine
    plan : Scenario
    outcome : Outcome
    warnings : tuple of ResultWarning
    time : (m,) array
        s.
    """

    def __init__(self, machine: Machine, plan: Scenario, recorded: Recording, payload: float) -> None:
        self.machine, self.plan, self._recorded, self._payload = machine, plan, recorded, payload
        self.outcome: Outcome = recorded.outcome
        self.warnings: tuple[ResultWarning, ...] = recorded.warnings
        self.time: Array = recorded.time

    @property
    def effort(self) -> dict[str, int]:
        """Steps, rejections, evaluations."""
        return self._recorded.effort

    @property
    def states(self) -> Array:
        """(m, n_states)."""
        return self._recorded.states

    def signal(self, name: str) -> Array:
        """A state, output, command or sample by its name, (m,) over :attr:`time`, SI."""
        if name in self._state_columns:
            return np.asarray(self.states[:, self._state_columns[name]])
        output = self.machine.core.output_index(name)
        if output is not None and name != OIL:
            return np.asarray(self._outputs[:, output])
        columns = self.run.columns
        check_known("signal", name, columns)
        return columns[name].values

    def pressures(self) -> Array:
        """(m, 2 n_cyl) chamber pressures, Pa."""
        return np.asarray(self.states[:, _pressure_columns(self.machine.state_names)])

    @cached_property
    def run(self) -> Run:
        """The whole run as a :class:`hydrocrane.Run`."""
        return Run(run_dataset(self.machine, self.plan, self._recorded, payload=self._payload, wall=0.0), self.machine)

    @cached_property
    def _state_columns(self) -> dict[str, int]:
        return _columns(self.machine.state_names)

    @cached_property
    def _outputs(self) -> Array:
        return outputs_table(self.machine, self._recorded, oil=False)


# The cases of a study differ seldom in their states.
@lru_cache(8)
def _columns(names: tuple[str, ...]) -> dict[str, int]:
    return {name: i for i, name in enumerate(names)}


@lru_cache(8)
def _pressure_columns(names: tuple[str, ...]) -> list[int]:
    return [i for i, name in enumerate(names) if name.endswith((".p1", ".p2"))]

"""An exported FMU in FMPy, by the names of its variables, the same for both versions of FMI."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import c_double, c_void_p
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Model, FMU3Slave

STEP = 1e-3


class Messages:
    """What an FMU tells through its logger."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def __call__(self, *arguments: object) -> None:
        self.texts.append(next(a.decode() for a in reversed(arguments) if isinstance(a, bytes)))


class Unit:
    """One instance of an FMU that is unzipped into a folder."""

    def __init__(self, file: Path, folder: Path, *, exchange: bool = False, token: str | None = None) -> None:
        self.description = read_model_description(str(file))
        self.fmi = int(self.description.fmiVersion[0])
        if not (folder / "modelDescription.xml").exists():
            extract(str(file), str(folder))
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.messages = Messages()
        own = self.description.guid if self.fmi == 2 else self.description.instantiationToken
        kinds = (FMU2Model, FMU3Model) if exchange else (FMU2Slave, FMU3Slave)
        self.fmu = kinds[self.fmi - 2](
            guid=token or own,
            unzipDirectory=str(folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="one",
        )

    def instantiate(self) -> Unit:
        if self.fmi == 2:
            calls = fmi2CallbackFunctions()
            calls.logger = fmi2CallbackLoggerTYPE(self.messages)
            self.fmu.instantiate(callbacks=calls)
        else:
            self.fmu.instantiate(logMessage=self.messages)
        return self

    def begin(self, start: dict[str, float] | None = None) -> Unit:
        """Until steps can be made."""
        self.instantiate()
        self.initialise(start or {})
        return self

    def initialise(self, start: dict[str, float]) -> None:
        if self.fmi == 2:
            self.fmu.setupExperiment(startTime=0.0)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=0.0)
        self.set(start)
        self.fmu.exitInitializationMode()

    def references(self, names: Sequence[str]) -> list[int]:
        return [self.variables[name].valueReference for name in names]

    def set(self, values: dict[str, float]) -> None:
        if values:
            put = self.fmu.setReal if self.fmi == 2 else self.fmu.setFloat64
            put(self.references(list(values)), list(map(float, values.values())))

    def get(self, names: Sequence[str]) -> np.ndarray:
        ask = self.fmu.getReal if self.fmi == 2 else self.fmu.getFloat64
        return np.array(ask(self.references(names)))

    def step(self, now: float, duration: float = STEP) -> None:
        self.fmu.doStep(currentCommunicationPoint=now, communicationStepSize=duration)

    def keep(self) -> c_void_p:
        """The state, which the library holds until it is let go."""
        return self.fmu.getFMUstate() if self.fmi == 2 else self.fmu.getFMUState()

    def put_back(self, state: c_void_p) -> None:
        (self.fmu.setFMUstate if self.fmi == 2 else self.fmu.setFMUState)(state)

    def let_go(self, state: c_void_p) -> None:
        (self.fmu.freeFMUstate if self.fmi == 2 else self.fmu.freeFMUState)(state)

    def save(self) -> bytes:
        """The state, as bytes."""
        state = self.keep()
        kept = (self.fmu.serializeFMUstate if self.fmi == 2 else self.fmu.serializeFMUState)(state)
        self.let_go(state)
        return bytes(kept)

    def load(self, kept: bytes) -> None:
        state = (self.fmu.deSerializeFMUstate if self.fmi == 2 else self.fmu.deserializeFMUState)(kept)
        self.put_back(state)
        self.let_go(state)

    def directional(self, unknowns: Sequence[str], knowns: Sequence[str], seed: Sequence[float]) -> np.ndarray:
        unknown, known = self.references(unknowns), self.references(knowns)
        if self.fmi == 2:
            return np.array(self.fmu.getDirectionalDerivative(unknown, known, list(seed)))
        return np.array(self.fmu.getDirectionalDerivative(unknown, known, list(seed), len(unknown)))

    def set_states(self, states: np.ndarray) -> None:
        self.fmu.setContinuousStates((c_double * len(states))(*states), len(states))

    def close(self) -> None:
        self.fmu.freeInstance()


def inputs(machine) -> list[str]:
    return [f"cylinder.{name}.command" for name in machine.cylinder_names]


def commands(count: int, cylinders: int) -> np.ndarray:
    """(count, cylinders) spool commands that move all cylinders to and fro, m."""
    t = np.arange(count)[:, None] * STEP
    return 0.02 * np.sin(2 * np.pi * t * (1.0 + 0.3 * np.arange(cylinders)))

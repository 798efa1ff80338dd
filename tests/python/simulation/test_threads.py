"""A simulation that another thread asks while it steps answers when its step is done."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np
import pytest

import hydrocrane as hc

POSE = {"boom": 1.7, "jib": 1.7, "extension": 0.0}
Q = np.array(list(POSE.values()))


def asked(step: Callable[[], object], questions: list[Callable[[], object]]) -> None:
    """Asks again and again while another thread steps."""
    failed: list[BaseException] = []
    done = threading.Event()

    def stepping() -> None:
        try:
            for _ in range(40):
                step()
        except BaseException as error:
            failed.append(error)
        finally:
            done.set()

    thread = threading.Thread(target=stepping)
    thread.start()
    rounds = 0
    while not done.is_set() or rounds == 0:
        for question in questions:
            question()
        rounds += 1
    thread.join(60.0)
    assert not thread.is_alive() and not failed, failed


def test_simulator() -> None:
    plant = hc.Simulator("rottne-f9-lab", 0.05)
    plant.reset(q=Q)
    asked(
        lambda: plant.step([0.01, 0.0, 0.0]),
        [lambda: plant.state, lambda: plant.time, lambda: plant.warnings, lambda: plant.outcome, lambda: plant.payload],
    )
    assert plant.time == pytest.approx(2.0)


def test_batch() -> None:
    batch = hc.BatchSimulator("rottne-f9-lab", 8, sample_time=0.05, threads=1)
    batch.reset(q=np.tile(Q, (8, 1)))
    asked(
        lambda: batch.step(np.full((8, 3), 0.005)),
        [lambda: batch.state, lambda: batch.time, lambda: batch.outcomes, lambda: batch.payload],
    )
    assert batch.time == pytest.approx(np.full(8, 2.0))


class Own:
    """A controller that looks at the simulation which it is part of."""

    period = 0.01

    def __init__(self, look: Callable[[], object] = lambda: None) -> None:
        self.look = look

    def reset(self, machine: hc.Machine, obs: hc.Observation) -> None:
        pass

    def step(self, obs: hc.Observation, command: object) -> list[float]:
        self.look()
        return [0.0, 0.0, 0.0]


def test_live_with_a_controller_of_ones_own() -> None:
    live = hc.LiveSimulator(hc.Scenario(machine="rottne-f9-lab", joints=POSE, controller=Own()))
    asked(live.step, [lambda: live.state, lambda: live.time, lambda: live.observation, lambda: live.events])


def test_a_controller_cannot_ask_the_simulation_that_waits_for_it() -> None:
    own = Own()
    live = hc.LiveSimulator(hc.Scenario(machine="rottne-f9-lab", joints=POSE, controller=own))
    own.look = lambda: live.time
    with pytest.raises(hc.SimulationError, match="from within its own step"):
        live.step()

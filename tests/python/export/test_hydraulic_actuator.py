"""The loop of docs/howto/mujoco-actuator.md: pressures stepped here, links in MuJoCo, against the simulator."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import hydrocrane as hc

PAGE = Path(__file__).parents[3] / "docs/howto/mujoco-actuator.md"


@pytest.mark.evidence
def test_the_loop_of_the_page_moves_as_the_simulator(tmp_path, monkeypatch):
    pytest.importorskip("mujoco")
    monkeypatch.chdir(tmp_path)
    code = re.search(
        r"((?:    .*\n|\n)+)", PAGE.read_text(encoding="utf-8").split("friction and end stops included.")[1]
    )
    names: dict[str, object] = {}
    exec("\n".join(line[4:] for line in code[1].splitlines()), names)
    crane, data, command = names["crane"], names["data"], names["command"]
    simulator = hc.Simulator(crane, sample_time=0.5)
    start = simulator.reset(q=crane.home)
    there = simulator.step(command)
    moved = np.abs(there.q - start.q).max()
    assert moved > 0.01
    np.testing.assert_allclose(data.qpos, there.q, atol=0.01 * moved)
    np.testing.assert_allclose(data.qvel, there.qd, atol=0.05 * np.abs(there.qd).max())

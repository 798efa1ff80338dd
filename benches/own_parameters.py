"""What own values of twenty machine keys cost the cranes of a batch: time per sample by turns with cranes without.

`python -m benches.own_parameters` prints the figures of docs/theory/batch.md.
"""

from __future__ import annotations

import time

import numpy as np

import hydrocrane as hc

# From all parts of a crane, each drawn within 3 % of its nominal value.
KEYS = (
    "environment.gravity", "link.boom.mass", "link.jib.inertia", "cylinder.lift.bore", "cylinder.jib.bore",
    "cylinder.jib.rod-diameter", "cylinder.lift.dead-length", "cylinder.extension.leakage-gap",
    "cylinder.jib.linkage.rocker-length", "cylinder.lift.end-stop.stiffness", "valve.lift.stroke",
    "valve.jib.nominal-flow", "valve.extension.natural-frequency", "friction.lift.bristle-stiffness",
    "friction.jib.bristle-stiffness", "friction.extension.bristle-stiffness", "fluid.density",
    "fluid.bulk-modulus-max", "supply.pressure", "equilibrium.back-pressure",
)  # fmt: skip
SIZES, SECONDS, SAMPLES = (1_000, 10_000), 40.0, 10


def seconds(batch: hc.BatchSimulator, commands: np.ndarray) -> float:
    """Processor time of one thread for some samples, per crane and sample, s."""
    began = time.thread_time()
    for _ in range(SAMPLES):
        batch.step(commands)
    return (time.thread_time() - began) / (SAMPLES * batch.n)


def main() -> None:
    crane = hc.load_machine("rottne-f9-lab")
    random = np.random.default_rng(0)
    for n in SIZES:
        drawn = {key: crane.value(key).si * random.uniform(0.97, 1.03, n) for key in KEYS}
        batches = [hc.BatchSimulator(crane, n, parameters=own, threads=1) for own in (None, drawn)]
        for name, opening in (("at rest", 0.0), ("in motion", 0.5)):
            for batch in batches:
                batch.reset(q=crane.home)
            times: list[list[float]] = []
            end = time.monotonic() + SECONDS
            # There and back.
            commands = opening * crane.spool_strokes * random.uniform(-1.0, 1.0, (n, 3))
            while time.monotonic() < end:
                times.append([seconds(batch, commands) for batch in batches])
                commands = -commands
            common, own = np.array(times).T
            more, least = np.median(own / common) - 1, own.min() / common.min() - 1
            print(
                f"{n} cranes {name}: {1e6 * np.median(common):.2f} us a crane, with own values {100 * more:.1f} % more "
                f"(of the least times {100 * least:.1f} %)"
            )


if __name__ == "__main__":
    main()

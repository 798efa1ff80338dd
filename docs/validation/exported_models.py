"""The exported model in JAX: the gradient of a rollout, and many cranes; writes the numbers of exported-models.md.

Run with a Python that has hydrocrane and jax; takes some minutes, on one core. `--short` takes a shorter motion and
fewer cranes, writes nothing, and fails where a gradient misses its bound.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

# One core for both programs, before they start threads.
if __name__ == "__main__" and hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import marked_page  # noqa: E402
import numpy as np  # noqa: E402

import hydrocrane as hc  # noqa: E402

sys.path.append(str(Path(__file__).resolve().parents[2]))

from benches.measures.batch import HOLD, SAMPLE, exact_tips, manoeuvres  # noqa: E402

PAGE = Path(__file__).with_name("exported-models.md")
CRANE = hc.load_machine("rottne-f9-lab")
START = {"boom": np.deg2rad(100.0), "jib": np.deg2rad(100.0), "extension": 0.0}
PAYLOAD = 50.0
# Spools open over RAMP, s, to these places, m, and stay there, so that pistons hardly change direction.
OPENED, RAMP = np.array([0.015, 0.012, 0.01]), 0.4
KEYS = (
    "payload.mass", "supply.pressure", "cylinder.lift.bore", "friction.lift.viscous[0]", "friction.jib.coulomb[0]",
    "friction.lift.bristle-stiffness", "fluid.bulk-modulus-max",
)  # fmt: skip
DURATION, STEPS = 2.0, (2e-4, 5e-5)
# Relative difference of a gradient that is allowed, and the tolerance of what it is compared with.
BOUND, EXACT = 1e-6, 1e-12
# Cranes, their steps by JAX, s, and rounds by turns.
CRANES, BATCH_STEPS, ROUNDS = 1000, (2e-3, 1e-3), 5
# Manoeuvres whose errors are measured, and how long the cranes of both programs move, s.
CHECKED, MOVED = 50, 1.0
Pair = tuple[jax.Array, jax.Array]
# Classical Runge-Kutta: where each stage looks, and its weight.
LOOKS, WEIGHTS = np.array([0.0, 0.5, 0.5, 1.0]), np.array([1.0, 2.0, 2.0, 1.0]) / 6.0


def runge_kutta(rates: Callable[..., jax.Array], x: jax.Array, h: float) -> jax.Array:
    """A step of four stages, in a loop so that the model is compiled once; `rates(x, share of the step)`."""

    def stage(carry: Pair, of: Pair) -> tuple[Pair, None]:
        before, total = carry
        slope = rates(x + of[0] * h * before, of[0])
        return (slope, total + of[1] * slope), None

    (_, total), _ = jax.lax.scan(stage, (jnp.zeros_like(x), jnp.zeros_like(x)), (LOOKS, WEIGHTS))
    return x + h * total


def scenario(duration: float) -> tuple[hc.Scenario, np.ndarray]:
    """The motion, which starts with stated pressures so that its start depends on no parameter; and its start state."""
    state = CRANE.equilibrium([START[joint] for joint in CRANE.joint_names], payload=PAYLOAD)
    at = dict(zip(CRANE.state_names, state, strict=True))
    times = [0.0, RAMP, duration]
    plan = hc.Scenario(
        machine=CRANE,
        joints=START,
        pressures={c: (at[f"cylinder.{c}.p1"], at[f"cylinder.{c}.p2"]) for c in CRANE.cylinder_names},
        commands={
            c: hc.Command(times, [0.0, own, own], "linear") for c, own in zip(CRANE.cylinder_names, OPENED, strict=True)
        },
        payload=PAYLOAD,
        duration=duration,
        record_interval=duration,
    )
    return plan, plan.initial_state(CRANE)


def gradients(duration: float, steps: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of the tip's last height by KEYS: by `hc.sensitivities`, and by JAX (steps, keys)."""
    plan, start = scenario(duration)
    by = hc.sensitivities(plan, KEYS, method="rodas5p", rtol=EXACT)
    assert by.outcome.kind == "completed", by.outcome
    expected = by.data["tip.z"].isel(time=-1).values
    model = CRANE.jax(parameters=KEYS, outputs=["tip.z"])
    values = jnp.array(model.VALUES).at[model.PARAMETERS.index("payload.mass")].set(PAYLOAD)

    def height(p: jax.Array, h: float, count: int) -> jax.Array:
        @jax.checkpoint
        def step(x: jax.Array, k: jax.Array) -> tuple[jax.Array, None]:
            def rates(at: jax.Array, share: jax.Array) -> jax.Array:
                return model.derivative(at, OPENED * jnp.minimum((k + share) * h / RAMP, 1.0), p)

            return runge_kutta(rates, x, h), None

        last, _ = jax.lax.scan(step, jnp.array(start), jnp.arange(count))
        return model.outputs(last, OPENED, p)[0]

    found = np.array([jax.jit(jax.grad(lambda p: height(p, h, round(duration / h))))(values) for h in steps])
    return expected, found[:, [model.PARAMETERS.index(key) for key in KEYS]]


def off(found: np.ndarray, expected: np.ndarray) -> np.ndarray:
    return np.abs(found - expected) / np.abs(expected)


def many(h: float) -> Callable[[jax.Array, jax.Array], jax.Array]:
    """One sample of many cranes, compiled: states (cranes, states) and spools (cranes, cylinders) to states."""
    model = CRANE.jax(parameters=[], outputs=[])
    every = jax.vmap(model.derivative)

    def sample(x: jax.Array, u: jax.Array) -> jax.Array:
        def step(x: jax.Array, _: None) -> tuple[jax.Array, None]:
            return runge_kutta(lambda at, _: every(at, u), x, h), None

        return jax.lax.scan(step, x, None, length=round(SAMPLE / h))[0]

    return jax.jit(sample)


def tips(x: np.ndarray) -> np.ndarray:
    """Where the tips are (cranes, 2); infinitely far off where steps were too long and a crane is lost."""
    q = np.asarray(x)[:, : len(CRANE.joint_names)]
    lost = ~(np.abs(q) < 10.0).all(axis=1)
    return np.where(lost[:, None], np.inf, CRANE.tip(np.where(lost[:, None], CRANE.home, q)))


def path(sample: Callable[..., jax.Array], start: np.ndarray, commands: np.ndarray) -> np.ndarray:
    """Tips (samples, cranes, 2) while the commands (changes, cranes, cylinders) are held for HOLD each."""
    x, found = jnp.array(start), [tips(start)]
    for spools in commands:
        for _ in range(round(HOLD / SAMPLE)):
            x = sample(x, spools)
            found.append(tips(x))
    return np.stack(found)


def off_their_paths(made: np.ndarray, exact: list[np.ndarray]) -> list[float]:
    """How far the tips made (samples, cranes, 2) are at most from the exact ones, m, for each crane."""
    return [float(np.hypot(*(made[: len(own), k] - own[: len(made)]).T).max()) for k, own in enumerate(exact)]


class Batch:
    """`BatchSimulator` as a function like that of JAX: states and spools to states."""

    def __init__(self, count: int) -> None:
        self.cranes = hc.BatchSimulator(CRANE, count, sample_time=SAMPLE, threads=1)

    def begin(self, start: np.ndarray) -> None:
        self.cranes.reset(state=start)

    def __call__(self, _: np.ndarray, spools: np.ndarray) -> np.ndarray:
        self.cranes.step(spools)
        return self.cranes.state


def batches(count: int, checked: int, steps: tuple[float, ...], moved: float, rounds: int) -> list[str]:
    """A row for each way to step many cranes: its worst and median tip error, and its speed beside the batch's."""
    changes = round(moved / HOLD)
    start, commands = manoeuvres(CRANE, checked)
    commands = commands[:changes]
    exact = exact_tips(CRANE, start, commands)
    rows_of = np.arange(count) % checked
    ways: dict[str, Callable[..., object]] = {"`hc.BatchSimulator`, default": Batch(count)}
    ways |= {f"JAX, steps of {1e3 * h:g} ms": many(h) for h in steps}
    errors, compiled = {}, {}
    for name, way in ways.items():
        alone = Batch(checked) if isinstance(way, Batch) else way
        if isinstance(alone, Batch):
            alone.begin(start)
        began = time.process_time()
        way_start = jnp.array(start[rows_of])
        if not isinstance(way, Batch):
            jax.block_until_ready(way(way_start, commands[0][rows_of]))
        compiled[name] = time.process_time() - began
        apart = off_their_paths(path(alone, start, commands), exact)
        errors[name] = (np.max(apart), np.median(apart))
    took: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(rounds):
        for name, way in ways.items():
            x: object = jnp.array(start[rows_of])
            if isinstance(way, Batch):
                way.begin(start[rows_of])
            began = time.process_time()
            for spools in commands:
                held = np.ascontiguousarray(spools[rows_of])
                for _ in range(round(HOLD / SAMPLE)):
                    x = way(x, held)
            jax.block_until_ready(x)
            took[name].append(time.process_time() - began)
    ours = took["`hc.BatchSimulator`, default"]
    lines = []
    for name, own in took.items():
        worst, middle = errors[name]
        ratio = median(t / o for t, o in zip(own, ours, strict=True))
        cells = [
            name,
            f"{1e3 * worst:.2g}" if worst < np.inf else "lost",
            f"{1e6 * middle:.2g}",
            f"{count * moved / median(own):.0f}",
        ]
        cells += [f"{ratio:.1f}", f"{compiled[name]:.0f}" if "JAX" in name else ""]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def numbers() -> list[str]:
    expected, found = gradients(DURATION, STEPS)
    errors = off(found, expected)
    missed = [key for key, error in zip(KEYS, errors[-1], strict=True) if error > BOUND]
    lines = [
        "## Demands that are missed",
        "",
        *([f"* The gradient by `{key}` differs by more than {BOUND:g}." for key in missed] or ["None."]),
        "",
        f"## Gradient of a rollout of {DURATION:g} s",
        "",
        "| parameter | derivative of the last height of the tip, `hc.sensitivities` | "
        + " | ".join(f"JAX, steps of {1e3 * h:g} ms: relative difference" for h in STEPS)
        + " |",
        "|" + "---|" * (2 + len(STEPS)),
    ]
    for key, slope, own in zip(KEYS, expected, errors.T, strict=True):
        lines.append(f"| `{key}` | {slope:.6e} | " + " | ".join(f"{error:.1e}" for error in own) + " |")
    return lines + [
        "",
        "## Many cranes",
        "",
        f"{CRANES} cranes for {MOVED:g} s, one core, median of {ROUNDS} rounds by turns. On a GPU: "
        "[there](models-on-a-gpu.md).",
        "",
        "| | worst tip error, mm | median, um | crane-seconds per second of processor time "
        "| time, `hc.BatchSimulator` = 1 | compiling, s |",
        "|" + "---|" * 6,
        *batches(CRANES, CHECKED, BATCH_STEPS, MOVED, ROUNDS),
    ]


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--short", action="store_true", help="a short motion and few cranes; write nothing")
    if parser.parse_args(arguments).short:
        expected, found = gradients(0.5, STEPS[-1:])
        print(off(found, expected), *batches(16, 4, BATCH_STEPS[-1:], HOLD, 1), sep="\n")
        sys.exit(bool((off(found, expected) > BOUND).any()))
    marked_page.write(PAGE, numbers())


if __name__ == "__main__":
    main(sys.argv[1:])

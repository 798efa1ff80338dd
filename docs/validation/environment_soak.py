"""Steps learning environments for long under actions that a learner takes, and fails where one step takes too long.

    python docs/validation/environment_soak.py                  # 10^8 steps, docs/validation/environment-soak.md
    python docs/validation/environment_soak.py --steps 1e6 --no-page

Actions are normal numbers clipped to full stroke, full strokes at random, full strokes held for a second, and, with the
extra ``rl``, those of a policy that has begun to learn.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
from tip_rest import in_processes

from hydrocrane.gym import CraneTipVectorEnv

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from benches.computer import processor  # noqa: E402
from benches.tables import table  # noqa: E402

PAGE = Path(__file__).with_name("environment-soak.md")
MACHINES = ("rottne-f9-lab", "hiab-xs031", "rottne-f9-mobile", "rottne-f9-ls")
CRANES = 64
# Processor time that no step of all cranes may take, s.
LONGEST = 50e-3
# Samples for which full strokes are held, and the steps of the policy's training.
HELD, TRAINED = 20, 100_000

Policy = Callable[[np.ndarray], np.ndarray]


def normal(rng: np.random.Generator, shape: tuple[int, int]) -> Policy:
    return lambda _: np.clip(rng.normal(size=shape), -1.0, 1.0)


def saturated(rng: np.random.Generator, shape: tuple[int, int]) -> Policy:
    return lambda _: rng.choice([-1.0, 1.0], size=shape)


def held(rng: np.random.Generator, shape: tuple[int, int]) -> Policy:
    actions, age = rng.choice([-1.0, 1.0], size=shape), rng.integers(0, HELD, size=shape)

    def act(_: np.ndarray) -> np.ndarray:
        nonlocal actions, age
        age = age + 1
        actions = np.where(age % HELD == 0, rng.choice([-1.0, 1.0], size=shape), actions)
        return actions

    return act


DRAWN = {"normal": normal, "saturated": saturated, "held": held}
CASES = list(product(MACHINES, (*DRAWN, "learned")))


def learned(cranes: CraneTipVectorEnv) -> Policy | None:
    """The actions, with exploration, of a policy that has begun to learn; None without the extra ``rl``."""
    try:
        import torch
        from stable_baselines3 import PPO

        from hydrocrane.gym.stable_baselines import Cranes, features
    except ImportError:
        return None
    torch.set_num_threads(1)
    school = Cranes(CraneTipVectorEnv(CRANES, cranes.task.machine, threads=1))
    model = PPO("MlpPolicy", school, seed=0, n_steps=100, batch_size=3200, device="cpu").learn(TRAINED)
    return lambda seen: np.clip(model.predict(features(cranes.task, seen))[0], -1.0, 1.0)


def soaked(steps: int, case: int) -> list[str] | None:
    """A row of the table, with `steps` steps of one of `CASES`; None where its actions cannot be had."""
    machine, kind = CASES[case]
    cranes, rng = CraneTipVectorEnv(CRANES, machine, threads=1), np.random.default_rng(0)
    shape = (CRANES, len(cranes.task.machine.cylinder_names))
    act = DRAWN[kind](rng, shape) if kind in DRAWN else learned(cranes)
    if act is None:
        print(machine, kind, "needs the extra `rl`", sep="\t", flush=True)
        return None
    seen, _ = cranes.reset(seed=0)
    lost, ended, spent, finite = 0, 0, [], True
    for _ in range(max(1, steps // CRANES)):
        actions = act(seen)
        began = time.process_time()
        seen, _, gone, late, _ = cranes.step(actions)
        spent.append(1e3 * (time.process_time() - began))
        lost, ended = lost + int(gone.sum()), ended + int((gone | late).sum())
        finite &= bool(np.isfinite(seen).all())
    cranes.close()
    took = np.array(spent)
    good = finite and took.max() < 1e3 * LONGEST
    figures = [f"{1e-6 * len(took) * CRANES:.3g}", f"{ended}", f"{lost}", f"{np.median(took):.2f}", f"{took.max():.1f}"]
    row = [machine, kind, *figures, "yes" if good else "**no**"]
    print(*row, sep="\t", flush=True)
    return row


TEXT = """# Learning environments for long

Written by `python docs/validation/environment_soak.py --steps {steps:g}`: {cranes} cranes `hydrocrane/CraneTip-v0` a
step, on {computer}. Every observation is a number, and no step of all cranes takes more than {longest:.0f} ms of
processor time.

Failures first.

{table}

`steps` counts those of single cranes, in millions. *Lost*: episodes that ended because a joint went far beyond its
limits. Actions: normal numbers clipped to full stroke; full strokes drawn for each sample; full strokes held for a
second; and those of a policy of PPO after {trained:,} steps, with exploration.
"""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=float, default=1e8, help="steps of single cranes in all")
    parser.add_argument("--no-page", action="store_true", help="write nothing")
    chosen = parser.parse_args()
    found = in_processes(partial(soaked, int(chosen.steps / len(CASES))), range(len(CASES)))
    rows = [row for row in found if row]
    rows.sort(key=lambda row: row[-1] == "yes")
    heads = ["machine", "actions", "steps, 10^6", "episodes", "lost", "median, ms", "longest, ms", "holds"]
    if not chosen.no_page:
        facts = {
            "cranes": CRANES,
            "computer": processor(),
            "steps": chosen.steps,
            "longest": 1e3 * LONGEST,
            "trained": TRAINED,
        }
        PAGE.write_text(TEXT.format(table=table(heads, rows), **facts), encoding="utf-8")
    return int(any(row[-1] != "yes" for row in rows))


if __name__ == "__main__":
    sys.exit(main())

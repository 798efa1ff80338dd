"""Steps learning environments for long under actions that a learner takes, and fails where one step takes too long.

    python docs/validation/environment_soak.py                  # 10^8 steps, docs/validation/environment-soak.md
    python docs/validation/environment_soak.py --steps 1e6 --no-page
    python docs/validation/environment_soak.py --parts soak.jsonl --seconds 300     # again and again until all is done

Actions are normal numbers clipped to full stroke, full strokes at random, full strokes held for a second, and, with the
extra ``rl``, those of a policy that has begun to learn.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from concurrent.futures import as_completed
from itertools import product
from pathlib import Path

import numpy as np
from workers import processes

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
# The slowest first, so that no process is left alone with one at the end.
CASES = list(product(reversed(MACHINES), (*DRAWN, "learned")))
# Parts of a case, each with random numbers of its own.
PARTS = 4


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


def soaked(steps: int, machine: str, kind: str, part: int, by: float) -> dict[str, object] | None:
    """`steps` steps in a part of a case: what is counted, and the processor time of each step of all cranes, ms.

    None where its actions cannot be had, and where it is later than `by` already.
    """
    if time.time() > by:
        return None
    cranes, rng = CraneTipVectorEnv(CRANES, machine, threads=1), np.random.default_rng(part)
    shape = (CRANES, len(cranes.task.machine.cylinder_names))
    act = DRAWN[kind](rng, shape) if kind in DRAWN else learned(cranes)
    if act is None:
        print(machine, kind, "needs the extra `rl`", sep="\t", flush=True)
        return None
    seen, _ = cranes.reset(seed=part)
    lost, ended, spent, finite = 0, 0, [], True
    for _ in range(max(1, steps // CRANES)):
        actions = act(seen)
        began = time.process_time()
        seen, _, gone, late, _ = cranes.step(actions)
        spent.append(1e3 * (time.process_time() - began))
        lost, ended = lost + int(gone.sum()), ended + int((gone | late).sum())
        finite &= bool(np.isfinite(seen).all())
    cranes.close()
    what = {"machine": machine, "kind": kind, "part": part, "computer": processor()}
    times = {"steps": len(spent) * CRANES, "median": float(np.median(spent)), "longest": max(spent)}
    return what | {"lost": lost, "ended": ended, "finite": finite} | times


def row(parts: list[dict]) -> list[str]:
    """The row of a case."""
    total = {key: sum(part[key] for part in parts) for key in ("steps", "ended", "lost")}
    longest = max(part["longest"] for part in parts)
    good = all(part["finite"] for part in parts) and longest < 1e3 * LONGEST
    figures = [f"{1e-6 * total['steps']:.3g}", f"{total['ended']}", f"{total['lost']}"]
    times = [f"{np.median([part['median'] for part in parts]):.2f}", f"{longest:.1f}"]
    return [parts[0]["machine"], parts[0]["kind"], *figures, *times, "yes" if good else "**no**"]


TEXT = """# Learning environments for long

Written by `python docs/validation/environment_soak.py`, {steps:.3g} steps of single cranes: {cranes} cranes
`hydrocrane/CraneTip-v0` a step, on {computer}. Every observation is a number, and no step of all cranes takes
more than {longest:.0f} ms of processor time.

Failures first.

{table}

`steps` counts those of single cranes, in millions. *Lost*: episodes that ended because a joint went far beyond its
limits. Actions: normal numbers clipped to full stroke; full strokes drawn for each sample; full strokes held for a
second; and those of a policy of PPO after {trained:,} steps, with exploration.
"""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=float, default=1e8, help="steps of single cranes in all")
    parser.add_argument("--parts", type=Path, help="file that keeps finished parts; those in it are not run again")
    parser.add_argument("--seconds", type=float, default=np.inf, help="begin no part later than this")
    parser.add_argument("--no-page", action="store_true", help="write nothing")
    chosen = parser.parse_args()
    kept = chosen.parts.read_text(encoding="utf-8").splitlines() if chosen.parts and chosen.parts.exists() else []
    found = [json.loads(line) for line in kept]
    done = {(part["machine"], part["kind"], part["part"]) for part in found}
    steps, by = int(chosen.steps / len(CASES) / PARTS), time.time() + chosen.seconds
    left = [key for key in ((*case, part) for case in CASES for part in range(PARTS)) if key not in done]
    for future in as_completed([processes().submit(soaked, steps, *key, by) for key in left]):
        if part := future.result():
            found.append(part)
            print(json.dumps(part), flush=True)
            if chosen.parts:
                with chosen.parts.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(part) + "\n")
    cases = [[part for part in found if (part["machine"], part["kind"]) == case] for case in CASES]
    rows = sorted(map(row, filter(None, cases)), key=lambda row: row[-1] == "yes")
    heads = ["machine", "actions", "steps, 10^6", "episodes", "lost", "median, ms", "longest, ms", "holds"]
    if not chosen.no_page:
        facts = {
            "cranes": CRANES,
            "computer": " and ".join(sorted({part["computer"] for part in found})),
            "steps": sum(part["steps"] for part in found),
            "longest": 1e3 * LONGEST,
            "trained": TRAINED,
        }
        PAGE.write_text(TEXT.format(table=table(heads, rows), **facts), encoding="utf-8")
    return int(any(row[-1] != "yes" for row in rows))


if __name__ == "__main__":
    sys.exit(main())

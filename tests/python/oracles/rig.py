"""The friction rig in NumPy, from the numbers of its machine file, for SciPy to integrate: no code of the core."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

FILE = Path(__file__).resolve().parents[3] / "machines/rig-rottne.toml"
UNITS = {"mm": 1e-3, "um": 1e-6, "bar": 1e5, "GPa": 1e9, "l/min": 1e-3 / 60, "mm/s": 1e-3, "Hz": 2 * np.pi, "m": 1.0}
STATES = ("joint.slide.q", "joint.slide.qd", *(f"cylinder.test.{name}" for name in ("p1", "p2", "xs", "vs", "z")))


def disc(diameter):
    """Area of a circle."""
    return np.pi / 4 * diameter**2


def number(entry):
    """A value of the file in SI."""
    value = entry["value"] if isinstance(entry, dict) else entry
    if isinstance(value, list):
        return [number(item) for item in value]
    if not isinstance(value, str):
        return float(value)
    size, unit = value.split(maxsplit=1)
    return float(size) * UNITS.get(unit, 1.0)


class Rig:
    """Hanging cylinder: (83)-(99), (115)-(117), and the valve of (64)-(74), (76)."""

    def __init__(self, payload=0.0, **changes):
        text = tomllib.loads(FILE.read_text(encoding="utf-8"))
        self.oil = {k: number(v) for k, v in text["fluid"].items() if k not in ("source", "cavitation")}
        valve = {
            k: number(v) for k, v in text["valve"]["test"].items() if k not in ("class", "source", "cylinder", "type")
        }
        seal = {
            k: number(v)
            for k, v in text["friction"]["test"].items()
            if k not in ("class", "source", "cylinder", "model")
        }
        body = {
            k: number(v) for k, v in text["cylinder"]["test"].items() if k not in ("joint", "barrel", "rod", "end-stop")
        }
        for section in (self.oil, valve, seal, body):
            section.update({name: value for name, value in changes.items() if name in section})
        self.mass = number(text["link"]["load"]["body"]["piston-and-rod"]["mass"]) + payload
        self.gravity, self.supply = number(text["environment"]["gravity"]), number(text["supply"]["pressure"])
        self.valve, self.seal, self.body = valve, seal, body
        self.set_up(body)

    def set_up(self, body):
        bore, rod, port = body["bore"], body["rod-diameter"], disc(body["port-diameter"])
        self.a1, self.a2 = disc(bore), disc(bore) - disc(rod)
        half, dead = 0.5 * (body["barrel-length"] - body["piston-length"]), body["dead-length"] * port
        self.v1, self.v2 = dead + self.a1 * half, dead + self.a2 * half
        gap, mu = body["leakage-gap"], self.oil["viscosity"]
        self.k_int = np.pi * (bore / 2 + gap) * gap**3 / (6 * mu * body["piston-length"])
        self.k_ext = np.pi * (rod / 2 + gap) * gap**3 / (6 * mu * body["gland-length"])
        self.rise = [0.5 * self.oil["density"] * ((a / port) ** 2 - 1) for a in (self.a1, self.a2)]
        drop = 0.5 * self.valve["nominal-pressure-drop"]
        self.c0 = self.valve["nominal-flow"] / (self.valve["stroke"] * np.sqrt(drop))

    def modulus(self, p):
        oil = self.oil
        return (
            0.5
            * oil["bulk-modulus-max"]
            * np.log10(oil["bulk-c1"] * p / oil["bulk-reference-pressure"] + oil["bulk-c2"])
        )

    def edge(self, opening, drop):
        p_tr = self.valve["transition-pressure"]
        if abs(drop) >= p_tr:
            return self.c0 * opening * np.sign(drop) * np.sqrt(abs(drop))
        return self.c0 * opening * drop * (3 - abs(drop) / p_tr) / (2 * np.sqrt(p_tr))

    def friction(self, v, z):
        """Force (N) and rate of the bristles (m/s)."""
        s, side = self.seal, 0 if v >= 0 else 1
        f_c, f_s = s["coulomb"][side], s["breakaway"][side]
        g = f_c + (f_s - f_c) * np.exp(-((abs(v) / s["stribeck-velocity"][side]) ** s["stribeck-exponent"]))
        rate = v - s["bristle-stiffness"] * abs(v) * z / g
        damping = s["bristle-damping"] * np.exp(-((v / s["bristle-damping-velocity"]) ** 2))
        viscous = s["viscous"][side] * np.sign(v) * abs(v) ** s["viscous-exponent"]
        return s["bristle-stiffness"] * z + damping * rate + viscous, rate

    def rates(self, t, y, command):
        x, v, p1, p2, xs, vs, z = y
        pa, pb = p1 - self.rise[0] * v**2, p2 - self.rise[1] * v**2
        if xs >= 0:
            q1, q2 = self.edge(xs, self.supply - pa), self.edge(xs, pb)
        else:
            q1, q2 = -self.edge(-xs, pa), -self.edge(-xs, self.supply - pb)
        leak = self.k_int * (p1 - p2)
        force, bristle = self.friction(v, z)
        w, zeta = self.valve["natural-frequency"], self.valve["damping-ratio"]
        return [
            v,
            (p1 * self.a1 - p2 * self.a2 - force) / self.mass + self.gravity,
            self.modulus(p1) / (self.v1 + self.a1 * x) * (q1 - leak - self.a1 * v),
            self.modulus(p2) / (self.v2 - self.a2 * x) * (leak - self.k_ext * p2 - q2 + self.a2 * v),
            vs,
            w**2 * (command(t) - xs) - 2 * zeta * w * vs,
            bristle,
        ]

    def integrate(self, start, times, spools, record, tolerance=1e-10):
        """States (k, 7) at the times `record`, from command change to command change."""
        scale = np.array([0.1, 0.1, 1e6, 1e6, 5e-3, 1.0, 1e-3])
        y, rows = np.array(start), [np.array(start)]
        for begin, end in zip(times[:-1], times[1:], strict=True):
            inside = record[(record > begin + 1e-12) & (record <= end + 1e-12)]
            at = inside if inside.size and inside[-1] == end else np.append(inside, end)
            command = (lambda t: np.interp(t, times, spools),)
            span, atol = (begin, end), tolerance * scale
            solved = solve_ivp(self.rates, span, y, "LSODA", at, args=command, rtol=tolerance, atol=atol)
            assert solved.success, solved.message
            y = solved.y[:, -1]
            rows += list(solved.y[:, : inside.size].T)
        return np.array(rows)

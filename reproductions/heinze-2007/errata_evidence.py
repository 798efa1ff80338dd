"""The numbers behind ERRATA.md that follow from the printed data alone.

Every function settles one row of the table with the re-stated printed program
(`tests/python/oracles`) and elementary algebra; hydrocrane itself is not involved. What a
correction changes in hydrocrane is measured in `tests/python/reproduction/test_errata.py`.
"""

from __future__ import annotations

import numpy as np
from common import printed_controller as controller
from common import printed_program as program
from scipy.optimize import brentq

POSE = np.array([np.deg2rad(100.0), np.deg2rad(100.0), 0.0])
PER_MINUTE = 6e4  # m^3/s to l/min
ROTTNE_EXTENDING = (160.0, 180.0, 8000.0, 0.002)  # Table 3: alpha0, alpha1, alpha2, v_sigma
# Kalmar, extending: alpha0 + alpha1 and alpha2 of Table 3 with 0 and 115 kg.
KALMAR_EXTENDING = ((455.0, 1250.0), (450.0, 1200.0))
# Break-away alpha0 + alpha1 of Table 3, N, and sigma_0 of Table 4, N/m: Rottne, extending and retracting.
ROTTNE_BREAKAWAY = {"0kg": (340.0, 400.0), "115kg": (620.0, 800.0)}
ROTTNE_STIFFNESS = (1.2e5, 1.0e5)


def e1_gravity() -> dict[str, float]:
    """Generalised gravity of the program at the published start, and the force it needs at rest."""
    mass, _, gravity = program.mechanics(POSE, np.zeros(3))
    _, slope = program.strokes(POSE)
    return {
        "program_gravity_alpha_nm": gravity[0],
        "program_gravity_beta_nm": gravity[1],
        "program_gravity_x3_n": gravity[2],
        "program_acceleration_alpha_rad_s2": np.linalg.solve(mass, gravity)[0],
        "static_force_1_with_gravity_down_n": gravity[0] / slope[0],
    }


def e2_inertia() -> dict[str, float]:
    """Inertia about the centre of gravity if the printed tensor is about the link frame."""
    about_centre = program.INERTIAS - program.MASSES * np.abs(program.CENTRES) ** 2
    # A body between its two end pins cannot exceed m d1 d2 about its centre of gravity.
    ends = (program.JIB_JOINT, 0.98 + 0j, program.TIP_ON_BEAM)
    bound = [m * c.real * (e.real - c.real) for m, c, e in zip(program.MASSES, program.CENTRES, ends)]
    return {
        f"link{i + 2}_{key}": float(value[i])
        for i in range(3)
        for key, value in (("about_centre_kg_m2", about_centre), ("slender_bound_kg_m2", bound))
    }


def e3_e4_orifice() -> dict[str, float]:
    """Flow per unit opening at low pressure: program, smooth two-regime law, turbulent law."""
    tr = program.TRANSITION
    unit = program.DISCHARGE
    out = {}
    for bar in (1, 2, 3):
        dp = bar * 1e5
        out[f"program_{bar}bar"] = program.edge_flow(1.0, np.nextafter(dp, 0), False) / unit
        out[f"smooth_{bar}bar"] = dp / (2 * np.sqrt(tr)) * (3 - dp / tr)
        out[f"turbulent_{bar}bar"] = np.sqrt(dp)
    out["jump_at_3bar"] = program.edge_flow(1.0, tr, False) / program.edge_flow(1.0, np.nextafter(tr, 0), False)
    out["eq69_over_turbulent_at_3bar"] = np.sqrt(tr)
    return out


def e5_to_e8_text() -> dict[str, float]:
    """Text equations (71), (72), (74), (104) read literally."""
    nu = 46e-6
    squared = (3 * 2000**2 * nu / (4 * program.DISCHARGE)) ** 2
    return {
        "eq72_over_eq73": 3 * np.sqrt(program.TRANSITION),
        "eq71_printed_bar": squared / 1e5,
        "eq71_linear_re_bar": (3 * 2000 * nu / (4 * program.DISCHARGE)) ** 2 / 1e5,
        "eq74_weight_at_minus_3bar": abs((-3 - 2) / (4 - 2)),
        "eq104_dynamic_pressure_pa": program.DENSITY / 2 * 0.5**2,
        "eq104_rise_ratio_10_bar": program.DENSITY / 2 * 0.5**2 * (10**4 - 1) / 1e5,
    }


def e9_to_e11_leakage() -> dict[str, float]:
    """Leakage of the program with 0.6 taken as viscosity, and its slips at cylinder 3."""
    lift, extension = program.CYLINDERS[0], program.CYLINDERS[2]
    dead = extension.port_area * 0.02
    return {
        "extension_external_from_p1_180bar_l_min": extension.leakages[1] * 180e5 * PER_MINUTE,
        "extension_external_from_p2_100bar_l_min": extension.leakages[1] * 100e5 * PER_MINUTE,
        "extension_dead_volume_printed_m3": dead * extension.dead_factor,
        "extension_dead_volume_m3": dead,
        "lift_internal_100bar_l_min": lift.leakages[0] * 100e5 * PER_MINUTE,
        "lift_external_100bar_l_min": lift.leakages[1] * 100e5 * PER_MINUTE,
    }


def e13_e14_strokes() -> dict[str, float]:
    """Strokes at Table 1's angles, angles at the true ends, and how far the stop springs yield."""
    x1, x2 = program.lift_stroke(np.deg2rad([45, 172])), program.jib_stroke(np.deg2rad([178, 5]))
    ends = [(c.barrel - c.piston) / 2 for c in program.CYLINDERS]
    out = {
        "x1_at_45deg_m": x1[0],
        "x1_at_172deg_m": x1[1],
        "x2_at_178deg_m": x2[0],
        "x2_at_5deg_m": x2[1],
        "offset_1_m": np.mean([-0.155, 0.217] - x1),
        "offset_2_m": np.mean([-0.101, 0.210] - x2),
        "alpha_at_stroke_end_deg": np.rad2deg(brentq(lambda a: program.lift_stroke(a) - ends[0], 1.0, 3.0)),
        "beta_at_rod_contact_deg": np.rad2deg(
            brentq(lambda b: program.jib_stroke(b) - (ends[1] - program.CYLINDERS[1].rod), 2.0, 3.12)
        ),
    }
    for task in controller.TASKS:
        target = controller.ik(program.tip(POSE) + np.array(controller.TASKS[task]))
        out[f"{task}_target_x1_m"] = program.lift_stroke(target[0])
        out[f"{task}_target_x2_m"] = program.jib_stroke(target[1])
    for name, c in zip(("lift", "jib", "extension"), program.CYLINDERS):
        out[f"{name}_stop_yield_m"] = program.SUPPLY * c.areas[0] / program.STOP_STIFFNESS
        out[f"{name}_stop_zone_m"] = c.barrel / 20
    return out


def e15_e16_friction() -> dict[str, float]:
    """Break-away of the program's map; equation (119) without sign() on its first two terms."""
    a0, a1, a2, vs = ROTTNE_EXTENDING
    v = -0.05
    stribeck = a0 + a1 * np.exp(-(abs(v / vs) ** 2))
    viscous = a2 * abs(v) ** 1.5
    return {
        "program_breakaway_n": float(program.friction(1e-12)),
        "program_at_100mm_s_n": float(program.friction(0.1)),
        "table3_at_100mm_s_n": a0 + a2 * 0.1**1.5,
        "eq119_printed_at_minus_50mm_s_n": stribeck - viscous,
        "eq119_odd_at_minus_50mm_s_n": -stribeck - viscous,
    }


def e20_deflection() -> dict[str, float]:
    """Bristle deflection at break-away by Tables 3 and 4, "x 10e5" read as 10^5, and as 10^6."""
    out = {}
    for load, forces in ROTTNE_BREAKAWAY.items():
        for direction, force, stiffness in zip(("extending", "retracting"), forces, ROTTNE_STIFFNESS, strict=True):
            out[f"{load}_{direction}_m"] = force / stiffness
    return out | {"0kg_retracting_read_literally_m": ROTTNE_BREAKAWAY["0kg"][1] / (10 * ROTTNE_STIFFNESS[1])}


def e23_to_e28_geometry() -> dict[str, float]:
    """Inverse kinematics behind the pillar, and equations (12), (36), (40) read literally."""
    # The corner of Table 1's box that folds the tip behind the pillar.
    low, high = [np.deg2rad(45), np.deg2rad(20), 0.2], [np.deg2rad(50), np.deg2rad(65), 0.315]
    poses = np.random.default_rng(0).uniform(low, high, (5000, 3))
    behind = [q for q in poses if program.tip(q)[0] < 0]
    before = [q for q in poses if program.tip(q)[0] >= 0]
    wrong = {
        name: max(abs(controller.ik(program.tip(q), q[2]) - q).max() for q in group)
        for name, group in (("behind", behind), ("before", before))
    }
    tip, pin = program.tip(POSE), program.JIB_CYLINDER_ON_BOOM
    to_pillar = abs(program.LIFT_ON_PILLAR - program.PILLAR_JOINT)
    lift = program.CYLINDERS[0]
    length = lift.mid_length + program.lift_stroke(POSE[0])
    return {
        "poses_behind_pillar": len(behind),
        "ik_worst_error_behind_deg": np.rad2deg(wrong["behind"]),
        "ik_worst_error_before_deg": np.rad2deg(wrong["before"]),
        "eq36_printed_m": abs(
            complex(*tip) - (program.PILLAR_JOINT + np.exp(1j * (POSE[0] - np.pi / 2)) * program.JIB_JOINT)
        ),
        "eq36_m": abs(complex(*tip) - program.PILLAR_JOINT),
        "eq40_printed_x1_m": length - 0.05 + lift.rod + 0.01 + (lift.barrel + lift.piston) / 2,
        "eq12_printed_acos_argument": (to_pillar**2 + abs(pin) ** 2 - length**2) / (2 * to_pillar * abs(pin)),
    }


def e40_e42_size() -> dict[str, float]:
    """No-load speeds at full spool, and the largest reach of the printed chain."""
    out = {}
    full = program.DISCHARGE * program.SPOOL_STROKE
    for name, c in zip(("lift", "jib"), program.CYLINDERS):
        a1, a2 = c.areas
        out[f"{name}_extending_m_s"] = full * np.sqrt(program.SUPPLY / (a1**2 + a2**3 / a1))
        out[f"{name}_retracting_m_s"] = full * np.sqrt(program.SUPPLY / (a2**2 + a1**3 / a2))
    arm = program.beam_offset(0.315) + program.TIP_ON_BEAM
    out["straight_reach_from_joint_2_m"] = abs(program.JIB_JOINT) + abs(arm)
    out["printed_mass_kg"] = 50 + float(program.MASSES.sum())
    return out


def e51_regenerative() -> dict[str, float]:
    """No-load speed of the extending telescope at full spool, turbulent edges, with either valve."""
    a1, a2 = program.CYLINDERS[2].areas
    full = program.DISCHARGE * program.SPOOL_STROKE
    return {
        "regenerative_m_s": full * np.sqrt(program.SUPPLY * (a1 - a2) / (a1**3 + a2**3)),
        "plain_m_s": full * np.sqrt(program.SUPPLY / (a1**2 + a2**3 / a1)),
    }


def e52_viscous() -> dict[str, float]:
    """The viscous term of 8000 at 0.1 m/s, linear and with the exponent 1.5."""
    alpha2 = ROTTNE_EXTENDING[2]
    return {"linear_at_100mm_s_n": alpha2 * 0.1, "power_at_100mm_s_n": alpha2 * 0.1**1.5}


def e54_slopes() -> dict[str, float]:
    """Slopes dx/dq where the text calls the strokes linear; cylinder 2 also with the length of E13."""
    alpha, beta = (np.deg2rad(np.linspace(*limits, 20001)) for limits in ((45.0, 172.0), (5.0, 178.0)))
    x1, x2 = program.lift_stroke(alpha), program.jib_stroke(beta)
    first = np.gradient(x1, alpha)[(x1 > -0.1) & (x1 <= 0.15)]
    second = -np.gradient(x2, beta)
    out = {"x1_least_m_rad": first.min(), "x1_most_m_rad": first.max()}
    for name, shift in (("x2", 0.0), ("x2_with_670mm", 0.7125 - 0.670)):
        here = second[x2 + shift < 0.150]
        out |= {
            f"{name}_least_m_rad": here.min(),
            f"{name}_most_m_rad": here.max(),
            f"{name}_ratio": here.max() / here.min(),
        }
    return out


def e55_load_cell() -> dict[str, float]:
    """0.5 % of either nominal force, and the most that the supply can push with on cylinder 3."""
    return {
        "error_of_20kn_n": 0.005 * 20e3,
        "error_of_10kn_n": 0.005 * 10e3,
        "supply_force_n": program.SUPPLY * program.CYLINDERS[2].areas[0],
    }


def e56_loads() -> dict[str, float]:
    """Kalmar, extending: Table 3 with 115 kg less that with 0 kg."""
    (force, viscous), (loaded_force, loaded_viscous) = KALMAR_EXTENDING
    return {"breakaway_n": loaded_force - force, "alpha_2": loaded_viscous - viscous}


CHECKS = (
    e1_gravity,
    e2_inertia,
    e3_e4_orifice,
    e5_to_e8_text,
    e9_to_e11_leakage,
    e13_e14_strokes,
    e15_e16_friction,
    e20_deflection,
    e23_to_e28_geometry,
    e40_e42_size,
    e51_regenerative,
    e52_viscous,
    e54_slopes,
    e55_load_cell,
    e56_loads,
)


def compute() -> dict[str, float]:
    """All numbers, keyed `<check>.<name>`."""
    return {f"{check.__name__}.{key}": float(value) for check in CHECKS for key, value in check().items()}


if __name__ == "__main__":
    for name, number in compute().items():
        print(f"{name:60s} {number: .6g}")

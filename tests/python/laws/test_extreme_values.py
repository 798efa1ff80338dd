"""No value of any key makes a run that completes with numbers that are not finite; frictionless machines run."""

import numpy as np
import pytest

import hydrocrane as hc

pytestmark = pytest.mark.evidence

MACHINES = ("rottne-f9-lab", "hiab-xs031", "single-cylinder", "rig-rottne", "rig-kalmar")
TRIES = 60
FRICTION_FORCES = ("coulomb", "breakaway", "viscous")


def opened(crane, duration):
    """A run with every spool a little open, from the middle of the limits."""
    commands = {name: 0.3 * stroke for name, stroke in zip(crane.cylinder_names, crane.spool_strokes, strict=True)}
    start = dict(zip(crane.joint_names, crane.home, strict=True))
    return hc.simulate(hc.Scenario(machine=crane, joints=start, commands=commands, duration=duration))


def all_finite(run):
    numbers = (values for values in run.data.data_vars.values() if values.dtype.kind == "f")
    return all(np.isfinite(values).all() for values in numbers)


@pytest.mark.parametrize("name", MACHINES)
def test_what_completes_is_finite_whatever_one_value_is(name):
    crane, draw = hc.load_machine(name), np.random.default_rng(25)
    keys = [key for key in crane.keys if np.ndim(crane.value(key).si) == 0]
    for key in draw.choice(keys, TRIES):
        value = (crane.value(key).si or 1.0) * 10.0 ** draw.uniform(-6, 6)
        try:
            run = opened(crane.changed({str(key): value}), 0.05)
        except hc.HydrocraneError:
            continue
        assert all_finite(run) or not run.outcome.completed, (key, value)


def test_oil_that_is_pressed_to_nothing_is_refused():
    for modulus in ("0.1 MPa", "5 MPa"):
        with pytest.raises(hc.MachineFileError, match="bulk-modulus-max"):
            hc.load_machine("rottne-f9-lab", {"fluid.bulk-modulus-max": modulus})
    assert all_finite(opened(hc.load_machine("rottne-f9-lab", {"fluid.bulk-modulus-max": "25 MPa"}), 0.2))
    with pytest.raises(hc.MachineFileError, match="back-pressure"):
        hc.load_machine("rottne-f9-lab", {"equilibrium.back-pressure": "150000 bar"})


@pytest.mark.parametrize("name", hc.bundled_machines())
def test_a_frictionless_machine_runs(name):
    crane = hc.load_machine(name)
    forces = [key for key in crane.keys if key.startswith("friction.") and key.split(".")[-1] in FRICTION_FORCES]
    free = crane.changed({key: 0.0 if np.ndim(crane.value(key).si) == 0 else [0.0, 0.0] for key in forces})
    run = opened(free, 0.3)
    assert run.outcome.completed and all_finite(run)
    force = np.abs([run.data[f"cylinder.{cylinder}.friction"].values for cylinder in crane.cylinder_names])
    assert force.max() == 0.0
    state = free.equilibrium(free.home)
    assert np.isfinite(free.jacobian(state, np.zeros(len(free.cylinder_names)))).all()

"""What Pinocchio and MuJoCo make of exported chains, for tests and for docs/validation/space.py."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

import hydrocrane as hc


class Answers(NamedTuple):
    """Mass matrices (m, n, n), bias forces (m, n) and places of the tip (m, 3) of m motions."""

    mass: np.ndarray
    bias: np.ndarray
    tip: np.ndarray


def pinocchio_model(pin: Any, path: Any, crane: hc.Machine) -> Any:
    """The model of a URDF with the gravity of the machine."""
    model = pin.buildModelFromUrdf(str(path))
    model.gravity.linear = np.array([0.0, 0.0, -crane.value("environment.gravity").si])
    return model


def in_pinocchio(pin: Any, model: Any, q: np.ndarray, qd: np.ndarray) -> Answers:
    data, tip = model.createData(), model.getFrameId("tip")
    mass, bias, place = [], [], []
    for pose, rate in zip(q, qd, strict=True):
        upper = np.triu(pin.crba(model, data, pose))
        mass.append(upper + np.triu(upper, 1).T)
        bias.append(pin.nonLinearEffects(model, data, pose, rate))
        pin.framesForwardKinematics(model, data, pose)
        place.append(data.oMf[tip].translation.copy())
    return Answers(np.array(mass), np.array(bias), np.array(place))


def in_mujoco(mujoco: Any, model: Any, q: np.ndarray, qd: np.ndarray) -> Answers:
    data, n = mujoco.MjData(model), q.shape[1]
    mass, bias, place = [], [], []
    for pose, rate in zip(q, qd, strict=True):
        data.qpos[:], data.qvel[:] = pose, rate
        mujoco.mj_forward(model, data)
        full = np.zeros((n, n))
        for column in range(n):
            mujoco.mj_mulM(model, data, full[column], np.eye(n)[column])
        mass.append(full)
        bias.append(data.qfrc_bias.copy())
        place.append(data.site("tip").xpos.copy())
    return Answers(np.array(mass), np.array(bias), np.array(place))

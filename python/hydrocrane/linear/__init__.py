"""Linear models of a crane about a working point: matrices, responses, margins of the cylinders' loops, mode shapes."""

from hydrocrane.analysis.linear import Modes, mode_map, modes
from hydrocrane.analysis.poses import pose_grid
from hydrocrane.linear.linearise import linearise
from hydrocrane.linear.loops import Loop, PidGains, cylinder_loops, pid_gains
from hydrocrane.linear.period_advice import PeriodAdvice, period_advice
from hydrocrane.linear.shapes import DampingCurves, ModeShapes, damping_curves, mode_shapes
from hydrocrane.state_space.model import LinearModel
from hydrocrane.state_space.responses import StepResponse

ANSWERS = {"linearise": "linearise.linearise"}

__all__ = [
    "DampingCurves",
    "LinearModel",
    "Loop",
    "ModeShapes",
    "Modes",
    "PeriodAdvice",
    "PidGains",
    "StepResponse",
    "cylinder_loops",
    "damping_curves",
    "linearise",
    "mode_map",
    "mode_shapes",
    "modes",
    "period_advice",
    "pid_gains",
    "pose_grid",
]

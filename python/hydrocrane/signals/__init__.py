"""Signal processing of rig logs: resampling, filters, derivatives, friction force, windows of steady motion."""

from hydrocrane.signals.derivative import Derivative, derivative
from hydrocrane.signals.filters import low_pass
from hydrocrane.signals.friction import RigParameters, friction_force, pressure_force, steady_friction
from hydrocrane.signals.resample import resample, sampling_rate
from hydrocrane.signals.search import steady_windows
from hydrocrane.signals.windows import Rejected, SteadyWindows, Window, friction_over_velocity
from hydrocrane.signals.zero import ZeroCalibrated, zero_calibrated

__all__ = [
    "Derivative",
    "Rejected",
    "RigParameters",
    "SteadyWindows",
    "Window",
    "ZeroCalibrated",
    "derivative",
    "friction_force",
    "friction_over_velocity",
    "low_pass",
    "pressure_force",
    "resample",
    "sampling_rate",
    "steady_friction",
    "steady_windows",
    "zero_calibrated",
]

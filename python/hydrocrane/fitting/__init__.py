"""Fit any values of a machine to its logs: :func:`fit`."""

from hydrocrane.fitting.fit import fit
from hydrocrane.fitting.information import SignalQuality
from hydrocrane.fitting.result import Fit

__all__ = ["Fit", "SignalQuality", "fit"]

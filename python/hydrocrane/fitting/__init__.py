"""Any values of a machine fitted to logs of it: :func:`fit`."""

from hydrocrane.fitting.fit import fit
from hydrocrane.fitting.quality import SignalQuality
from hydrocrane.fitting.result import Fit

__all__ = ["Fit", "SignalQuality", "fit"]

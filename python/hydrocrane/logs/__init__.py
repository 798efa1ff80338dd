"""Logs: files of a data logger as checked signals in SI.

:func:`read_log` reads and checks a rig's log; :func:`series_of` gives chosen signals of any log in SI.
"""

from hydrocrane.logs.columns import series_of, table_of
from hydrocrane.logs.log import Log, read_log
from hydrocrane.logs.mapping import LogMapping, Source, log_mapping
from hydrocrane.logs.noise import Noise, noise_of
from hydrocrane.logs.signals import Flag
from hydrocrane.logs.table import TIME_NAMES

__all__ = [
    "TIME_NAMES",
    "Flag",
    "Log",
    "LogMapping",
    "Noise",
    "Source",
    "log_mapping",
    "noise_of",
    "read_log",
    "series_of",
    "table_of",
]

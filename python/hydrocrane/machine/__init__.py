"""Machines: loaded from files, with their geometry, mechanics, hydraulics and sensors."""

from hydrocrane.machine.machine import (
    Machine,
    MachineLike,
    as_machine,
    bundled_machines,
    load_machine,
)
from hydrocrane.machine.overrides import Override, plain_overrides
from hydrocrane.machine.sensors import SensorFault
from hydrocrane.machine.stated import PROVENANCE_CLASSES, Value

__all__ = [
    "PROVENANCE_CLASSES",
    "Machine",
    "MachineLike",
    "Override",
    "SensorFault",
    "Value",
    "as_machine",
    "bundled_machines",
    "load_machine",
    "plain_overrides",
]

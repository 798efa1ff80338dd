"""Machines and controllers for other programs: FMUs, functions in other languages, kinematic chains."""

from hydrocrane.export.controller import export_controller
from hydrocrane.export.fmu import export_fmu
from hydrocrane.export.mjcf import export_mjcf
from hydrocrane.export.model import export_model
from hydrocrane.export.urdf import export_urdf

ANSWERS = {"model-in": "model.model_in"}

__all__ = ["export_controller", "export_fmu", "export_mjcf", "export_model", "export_urdf"]

"""Machines as files of other programs for multibody systems."""

from hydrocrane.export.mjcf import export_mjcf
from hydrocrane.export.urdf import export_urdf

__all__ = ["export_mjcf", "export_urdf"]

"""Identification of friction from measurements: the steady map, comparisons between maps, and the report."""

from hydrocrane.identification.graphical import graphical
from hydrocrane.identification.least_squares import OffsetPrior
from hydrocrane.identification.points import FrictionPoints
from hydrocrane.identification.result import StaticFit
from hydrocrane.identification.static_fit import fit_static
from hydrocrane.identification.static_map import StaticMap

__all__ = ["FrictionPoints", "OffsetPrior", "StaticFit", "StaticMap", "fit_static", "graphical"]

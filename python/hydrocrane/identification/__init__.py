"""Identification of friction from measurements: the steady map, comparisons between maps, bristles, and the report."""

from hydrocrane.identification.bristle import first_readings
from hydrocrane.identification.campaign import identify_friction
from hydrocrane.identification.campaign_result import Identification, Stage
from hydrocrane.identification.comparison import FrictionComparison, compare_friction
from hydrocrane.identification.dynamic import expected, fit_dynamic
from hydrocrane.identification.dynamic_result import DynamicFit
from hydrocrane.identification.graphical import graphical
from hydrocrane.identification.least_squares import OffsetPrior
from hydrocrane.identification.points import FrictionPoints
from hydrocrane.identification.report import Report, Section, Table
from hydrocrane.identification.result import StaticFit
from hydrocrane.identification.static_fit import fit_static
from hydrocrane.identification.static_map import StaticMap, synthetic_points
from hydrocrane.identification.static_stage import StaticIdentification, identify_static

__all__ = [
    "DynamicFit",
    "FrictionComparison",
    "FrictionPoints",
    "Identification",
    "OffsetPrior",
    "Report",
    "Section",
    "Stage",
    "StaticFit",
    "StaticIdentification",
    "StaticMap",
    "Table",
    "compare_friction",
    "expected",
    "first_readings",
    "fit_dynamic",
    "fit_static",
    "graphical",
    "identify_friction",
    "identify_static",
    "synthetic_points",
]

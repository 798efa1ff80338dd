"""What logs say of a machine: friction of a cylinder by :func:`identify_friction`, any values by :func:`fit`.

A model of a log gives residuals, these a fit with its covariance, and both the doubts and the report. The static map of
friction, the rig with its bristles, and any machine with its scenario are such models.
"""

from hydrocrane.identification.bristles.fit import DynamicFit, expected, fit_dynamic
from hydrocrane.identification.bristles.readings import first_readings
from hydrocrane.identification.campaign import identify_friction
from hydrocrane.identification.campaign_result import Identification, Stage
from hydrocrane.identification.report import Report, Section, Table
from hydrocrane.identification.static.comparison import FrictionComparison, compare_friction
from hydrocrane.identification.static.fit import fit_static
from hydrocrane.identification.static.maps import StaticMap, synthetic_points
from hydrocrane.identification.static.points import FrictionPoints
from hydrocrane.identification.static.problem import OffsetPrior
from hydrocrane.identification.static.result import StaticFit
from hydrocrane.identification.static.stage import StaticIdentification, graphical, identify_static
from hydrocrane.identification.values.doubts import SignalQuality
from hydrocrane.identification.values.fit import fit
from hydrocrane.identification.values.result import Fit

__all__ = [
    "DynamicFit",
    "Fit",
    "FrictionComparison",
    "FrictionPoints",
    "Identification",
    "OffsetPrior",
    "Report",
    "Section",
    "SignalQuality",
    "Stage",
    "StaticFit",
    "StaticIdentification",
    "StaticMap",
    "Table",
    "compare_friction",
    "expected",
    "fit",
    "first_readings",
    "fit_dynamic",
    "fit_static",
    "graphical",
    "identify_friction",
    "identify_static",
    "synthetic_points",
]

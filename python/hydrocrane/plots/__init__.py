"""Pictures: each function takes a run or a machine and returns a matplotlib figure; nothing else imports matplotlib."""

from hydrocrane.plots.bode import bode, loop_gains
from hydrocrane.plots.circuit import circuit
from hydrocrane.plots.laws import flow_law, friction_maps
from hydrocrane.plots.maps import damping_curves, joint_stroke, load_chart, mode_map, mode_shapes, workspace
from hydrocrane.plots.runs import (
    comparison_charts,
    cylinder_charts,
    energy_chart,
    overlay,
    overview,
    supply_charts,
    tip_charts,
)
from hydrocrane.plots.sweeps import ranking, sweep

ANSWERS = {
    "comparison": "runs.comparison_charts",
    "dynamic-fit": "fits.dynamic_fit",
    "film": "animation.film",
    "fit": "fits.fit_charts",
    "friction-comparison": "fits.friction_comparison",
    "residual-causes": "fits.residual_causes",
    "run": "runs.of_run",
    "static-fit": "fits.static_fit",
    "steady-windows": "fits.steady_windows_chart",
    "write": "style.write",
    "write-film": "animation.write",
}

__all__ = [
    "bode",
    "circuit",
    "comparison_charts",
    "cylinder_charts",
    "damping_curves",
    "energy_chart",
    "flow_law",
    "friction_maps",
    "joint_stroke",
    "load_chart",
    "loop_gains",
    "mode_map",
    "mode_shapes",
    "overlay",
    "overview",
    "ranking",
    "supply_charts",
    "sweep",
    "tip_charts",
    "workspace",
]

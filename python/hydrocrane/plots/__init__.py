"""Pictures: each function takes a run or a machine and returns a matplotlib figure; nothing else imports matplotlib."""

from hydrocrane.plots.bode import bode, loop_gains
from hydrocrane.plots.charts import cylinder_charts, overview
from hydrocrane.plots.circuit import circuit
from hydrocrane.plots.comparison import comparison_charts
from hydrocrane.plots.energy import energy_chart
from hydrocrane.plots.flow_law import flow_law
from hydrocrane.plots.friction_maps import friction_maps
from hydrocrane.plots.joint_stroke import joint_stroke
from hydrocrane.plots.loadchart import load_chart
from hydrocrane.plots.mode_shapes import damping_curves, mode_shapes
from hydrocrane.plots.modes import mode_map
from hydrocrane.plots.overlay import overlay
from hydrocrane.plots.ranking import ranking
from hydrocrane.plots.supply import supply_charts
from hydrocrane.plots.sweep import sweep
from hydrocrane.plots.tip_path import tip_charts
from hydrocrane.plots.workspace import workspace

ANSWERS = {
    "comparison": "comparison.comparison_charts",
    "dynamic-fit": "dynamic_friction.dynamic_fit",
    "film": "animation.film",
    "fit": "fitting.fit_charts",
    "friction-comparison": "identification.friction_comparison",
    "residual-causes": "residual_causes.residual_causes",
    "run": "run_charts.of_run",
    "static-fit": "identification.static_fit",
    "steady-windows": "windows.steady_windows_chart",
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

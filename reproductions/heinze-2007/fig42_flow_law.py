"""Figure 42: flow through a metering edge over pressure drop and opening."""

from __future__ import annotations

import numpy as np
from common import figure, save

import hydrocrane as hc

LAWS = {"printed": "as-printed", "corrected": "corrected"}
FULL_STROKE = 0.05
LINE_END = 2e5  # the text: an even rise up to 2 bar


def crane_with(law: str):
    return hc.load_machine("heinze-2007", overrides={"errata.orifice-law": law})


def departure_from_line(flow: np.ndarray) -> float:
    """Largest distance from the chord through the first and last point, as a share of the last."""
    return float(np.abs(flow - np.linspace(flow[0], flow[-1], len(flow))).max() / flow[-1])


def compute() -> dict[str, float]:
    numbers = {}
    low = np.linspace(0.0, LINE_END, 201)
    wide = np.linspace(0.0, 10e5, 10001)
    for name, law in LAWS.items():
        crane = crane_with(law)
        flow = crane.orifice_flow(np.full_like(wide, FULL_STROKE), wide)
        half = crane.orifice_flow(np.full_like(wide, FULL_STROKE / 2), wide)
        numbers[f"{name}_departure_from_line"] = departure_from_line(
            crane.orifice_flow(np.full_like(low, FULL_STROKE), low)
        )
        numbers[f"{name}_half_opening_error"] = float(np.abs(2 * half - flow).max() / flow.max())
        numbers[f"{name}_flow_at_10bar_m3_s"] = float(flow[-1])
    return numbers


def draw() -> None:
    fig, axes = figure(1, 2, (9.5, 3.8))
    dp = np.linspace(0.0, 10e5, 800)
    for name, law in LAWS.items():
        axes[0, 0].plot(dp / 1e5, 6e4 * crane_with(law).orifice_flow(np.full_like(dp, FULL_STROKE), dp), label=name)
    axes[0, 0].plot(dp / 1e5, 6e4 * 1e-4 * np.sqrt(dp / 75e5), "k:", label="turbulent")
    axes[0, 0].set(title="Figure 42, full opening", xlabel="pressure drop [bar]", ylabel="flow [l/min]")
    axes[0, 0].legend(frameon=False)
    crane = crane_with("corrected")
    opening = np.linspace(0.0, FULL_STROKE, 60)
    grid, spool = np.meshgrid(dp, opening)
    flow = crane.orifice_flow(spool.ravel(), grid.ravel()).reshape(grid.shape)
    chart = axes[0, 1].contourf(grid / 1e5, 1e3 * spool, 6e4 * flow, levels=12, cmap="viridis")
    fig.colorbar(chart, label="flow [l/min]")
    axes[0, 1].set(title="Figure 42, corrected law", xlabel="pressure drop [bar]", ylabel="spool stroke [mm]")
    save(fig, "fig42_flow_law")

"""Work-precision picture: what the tip error of each solver costs."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from hydrocrane.plots.style import ACCENT, COLOURS, INK, MUTED, one_chart, styled, title

MARKS = ("o", "s", "^", "D", "v", "P")


@styled
def work_precision(curves: dict[str, list[dict[str, Any]]], families: dict[str, str], ours: str) -> Figure:
    """One line per solver: time against tip error, both logarithmic; colours are families, marks the methods."""
    fig, axes = one_chart(8.5, 5.6)
    order = list(dict.fromkeys(families.values()))
    colours = dict(zip(order, (ACCENT, *COLOURS[:4], COLOURS[5]), strict=False))
    drawn: dict[str, int] = dict.fromkeys(order, 0)
    for name, points in curves.items():
        family = families[name]
        mark = MARKS[drawn[family] % len(MARKS)]
        drawn[family] += 1
        errors = [point["tip_error_m"] * 1e6 for point in points]
        times = [point["seconds"] * 1e3 for point in points]
        width = 2.6 if name == ours else 1.1
        axes.loglog(errors, times, marker=mark, ms=4, lw=width, color=colours[family], label=name)
    axes.set_xlim(1e-2, 1e3)
    axes.axvline(10, color=MUTED, lw=0.8, ls=":")
    axes.text(10, axes.get_ylim()[0] * 1.15, " 10 µm", color=INK, fontsize=8.5)
    axes.set_xlabel("largest distance of the tip from the exact path [µm]")
    axes.set_ylabel("time for 5 s of the crane [ms]")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    title(fig, "What exactness costs", "vertical-lift-open-loop, 21 states, one core")
    return fig

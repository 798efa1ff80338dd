"""Line animation of a run, as Figure 89: pillar, links, cylinders, torque linkage and the way of the tip."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FFMpegWriter, FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, ResultFileError
from hydrocrane.plots.style import ACCENT, CRANE_LINES, GRID, MUTED, RC, figure
from hydrocrane.plots.workspace import draw_boundary, metres

if TYPE_CHECKING:
    from hydrocrane.machine import Machine
    from hydrocrane.result import Run


def film(run: Run, *, fps: int = 20, speed: float = 1.0) -> FuncAnimation:
    """The animation of a run; it holds its last picture for half a second."""
    return _film(run, fps, speed)[1]


def _film(run: Run, fps: int, speed: float) -> tuple[Figure, FuncAnimation]:
    if not (fps > 0 and speed > 0):
        raise InputError(f"fps and speed must be greater than zero, got {fps!r}, {speed!r}")
    times, poses, tips = _pictures(run, fps, speed)
    crane = run.machine
    with mpl.rc_context(RC):
        fig, axes = figure(6.6, 5.4)
        _stage(axes, run, crane, poses)
        parts = [axes.plot([], [], **CRANE_LINES[kind])[0] for kind, _, _ in crane.drawing(poses[0])]
        trail = axes.plot([], [], color=ACCENT, lw=1.2, alpha=0.9, zorder=2)[0]
        clock = axes.text(0.985, 0.97, "", transform=axes.transAxes, ha="right", va="top", family="monospace")
        # Settle the layout once; doing it for every picture would shake the axes and take most of the time.
        fig.canvas.draw()
        fig.set_layout_engine("none")

    def show(index: int) -> list[Line2D]:
        for line, (_, _, points) in zip(parts, crane.drawing(poses[index]), strict=True):
            line.set_data(points[:, 0], points[:, 1])
        trail.set_data(tips[: index + 1, 0], tips[: index + 1, 1])
        clock.set_text(f"{times[index]:6.2f} s")
        return [*parts, trail]

    order = [*range(len(times)), *[len(times) - 1] * max(1, fps // 2)]
    return fig, FuncAnimation(fig, show, frames=order, interval=1000 / fps, blit=False)


def write(
    run: Run, path: Path, *, fps: int = 20, speed: float = 1.0, progress: Callable[[int, int], None] | None = None
) -> Path:
    """Write the film of a run as ``.gif``, or as ``.mp4`` where ffmpeg is found."""
    writer = _writer(path, fps)
    path.parent.mkdir(parents=True, exist_ok=True)
    fig, moving = _film(run, fps, speed)
    moving.save(path, writer=writer, dpi=90, progress_callback=progress)
    plt.close(fig)
    return path


def _writer(path: Path, fps: int) -> PillowWriter | FFMpegWriter:
    suffix = path.suffix.lower()
    if suffix == ".gif":
        return PillowWriter(fps=fps)
    if suffix != ".mp4":
        raise ResultFileError(f"cannot write `{path.name}`: choose a suffix from .gif, .mp4")
    if shutil.which("ffmpeg") is None:
        raise ResultFileError(f"cannot write `{path.name}`: ffmpeg is not on the path; a .gif needs no extra tool")
    return FFMpegWriter(fps=fps, bitrate=1800)


def _pictures(run: Run, fps: int, speed: float) -> tuple[Array, Array, Array]:
    """Times, poses and tips of the pictures, read off the recorded run."""
    time = run.data.time.values
    if time.size == 0:
        raise InputError("this run recorded nothing to animate")
    count = max(int(round((time[-1] - time[0]) / speed * fps)), 1)
    times = np.linspace(time[0], time[-1], count + 1)
    poses = np.column_stack([np.interp(times, time, run.data[f"joint.{j}.q"].values) for j in run.joint_names])
    return times, poses, run.machine.tip(poses)


def _stage(axes: Axes, run: Run, crane: Machine, poses: Array) -> None:
    """What stands still: ground, workspace, title, and a window that holds every picture."""
    draw_boundary(axes, crane, colour=GRID)
    shown = poses[np.linspace(0, len(poses) - 1, min(len(poses), 12)).astype(int)]
    points = np.concatenate([line for q in shown for _, _, line in crane.drawing(q)])
    low, high = points.min(axis=0), points.max(axis=0)
    pad = 0.12 * float((high - low).max()) + 0.05
    axes.axhline(float(low[1]), color=MUTED, lw=1.0, zorder=0.5)
    axes.set_xlim(low[0] - pad, high[0] + pad)
    axes.set_ylim(low[1] - pad, high[1] + pad)
    metres(axes, fixed=True)
    axes.set_title(f"{run.data.attrs['scenario']}  ·  {crane.name}")

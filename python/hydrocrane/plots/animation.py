"""Animation of a run, as Figure 89: pillar, links, cylinders with their oil, load and path of the tip."""

from __future__ import annotations

import base64
import html
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FFMpegWriter, FuncAnimation
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle
from PIL import Image

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, ResultFileError
from hydrocrane.files.whole_file import written_whole
from hydrocrane.notebook import in_notebook, progress_bar
from hydrocrane.plots.maps import draw_keep_out, metres
from hydrocrane.plots.style import (
    ACCENT,
    COLOURS,
    CRANE_LINES,
    FIELD,
    INK,
    MUTED,
    PLATE,
    RC,
    draw_crane,
    is_plate,
    shown_once,
)

if TYPE_CHECKING:
    from hydrocrane.machine.machine import Machine
    from hydrocrane.results.record import Record

Progress = Callable[[int, int], None] | None
_SIZE: dict[str, Any] = {"figsize": (6.6, 5.4), "layout": "constrained"}
_DPI = 100
# Density of what hangs at the tip, kg/m^3.
_STEEL = 7850.0
# The title not at the very edge.
_RC = {**RC, "figure.constrained_layout.h_pad": 0.12}


class Film(FuncAnimation):
    """The animation of a run in a separate figure; the last picture stays for half a second. Notebooks play it."""

    def __init__(self, run: Record, fps: int, speed: float) -> None:
        with mpl.rc_context(_RC):
            scene = _Scene(run, fps, speed, plt.figure(**_SIZE))
        shown_once(scene.figure)
        super().__init__(scene.figure, scene.show, frames=scene.order, interval=1000 / fps, blit=False)
        self._of = (run, fps, speed)

    def _repr_html_(self) -> str:
        """The film itself, as GIF within the page."""
        # Marks the animation as used, so that matplotlib does not warn.
        self._draw_was_started = True
        run, fps, speed = self._of
        with tempfile.TemporaryDirectory() as folder:
            data = write(run, Path(folder) / "film.gif", fps=fps, speed=speed).read_bytes()
        words = html.escape(f"{run.columns.attrs['scenario']} on {run.columns.attrs['machine']}")
        return f'<img alt="{words}" src="data:image/gif;base64,{base64.b64encode(data).decode()}">'


def film(run: Record, *, fps: int = 20, speed: float = 1.0) -> Film:
    """The animation of a run."""
    return Film(run, fps, speed)


def write(run: Record, path: Path, *, fps: int = 20, speed: float = 1.0, progress: Progress = None) -> Path:
    """Write the film of a run as ``.gif``, or as ``.mp4`` if ffmpeg is found; atomically."""
    writer = _WRITERS[checked_suffix(path)]
    if progress is None and in_notebook():
        with progress_bar(f"drawing {path.name}") as progress:
            return write(run, path, fps=fps, speed=speed, progress=progress)
    with mpl.rc_context(_RC), written_whole(path) as beside:
        figure = Figure(dpi=_DPI, **_SIZE)
        FigureCanvasAgg(figure)
        scene = _Scene(run, fps, speed, figure)
        writer(scene, beside, fps, progress)
    return path


def checked_suffix(path: Path) -> str:
    """The suffix of a film, or an error that names the possible ones."""
    suffix = path.suffix.lower()
    if suffix not in _WRITERS:
        raise ResultFileError(f"cannot write `{path.name}`: choose a suffix from {', '.join(_WRITERS)}")
    if suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise ResultFileError(f"cannot write `{path.name}`: ffmpeg is not on the path; a .gif needs no extra tool")
    return suffix


class _Scene:
    """The fixed scene and its moving parts; :meth:`show` sets their positions for one picture."""

    def __init__(self, run: Record, fps: int, speed: float, figure: Figure) -> None:
        if not (fps > 0 and speed > 0):
            raise InputError(f"fps and speed must be greater than zero, got {fps!r}, {speed!r}")
        self.times, self.poses, self.tips = _pictures(run, fps, speed)
        self.oil = np.stack(
            [_at(run, self.times, f"cylinder.{c}.p{side}") for c in run.cylinder_names for side in (1, 2)]
        )
        self.order = [*range(len(self.times)), *[len(self.times) - 1] * max(1, fps // 2)]
        self.machine = run.machine
        self.figure = figure
        self.axes = figure.subplots()
        _set_stage(self.axes, run, self.machine, self.poses)
        drawn = self.machine.drawing(self.poses[0])
        self.cylinders, self.names = list(run.cylinder_names), [name for _, name, _ in drawn]
        self.parts = [self.axes.plot([], [], **CRANE_LINES[kind])[0] for kind, _, _ in drawn]
        closed = [i for i, (_, _, points) in enumerate(drawn) if is_plate(points)]
        self.plates = {i: Polygon(drawn[i][2], **PLATE) for i in closed}
        for plate in self.plates.values():
            self.axes.add_patch(plate)
        # The rod side lies over the barrel, whose own line is then that of the piston side.
        above = {**CRANE_LINES["cylinder-barrel"], "zorder": CRANE_LINES["cylinder-barrel"]["zorder"] + 0.1}
        self.rod_sides = [self.axes.plot([], [], **above)[0] for _ in run.cylinder_names]
        self.shade = ScalarMappable(Normalize(0.0, self.machine.supply_pressure * 1e-5), FIELD)
        bar = figure.colorbar(self.shade, ax=self.axes, shrink=0.5, aspect=30, pad=0.02)
        bar.set_label("oil pressure [bar]")
        self.load = _HangingLoad(self.axes, _at(run, self.times, "payload"))
        self.trail = self.axes.plot([], [], color=ACCENT, lw=1.4, zorder=2)[0]
        self.plan = _Plan(self.axes, run.machine.tip(self.poses)) if "y" in run.machine.tip_axes else None
        corner: dict[str, Any] = {"transform": self.axes.transAxes, "ha": "right", "va": "top", "family": "monospace"}
        self.clock = self.axes.text(0.985, 0.975, "", **corner)
        # Solve the layout once; solving it for every picture would move the axes and take most of the time.
        figure.canvas.draw()
        figure.set_layout_engine("none")

    def show(self, index: int) -> list[Artist]:
        drawn = self.machine.drawing(self.poses[index])
        for line, (_, _, points) in zip(self.parts, drawn, strict=True):
            line.set_data(points[:, 0], points[:, 1])
        for i, plate in self.plates.items():
            plate.set_xy(drawn[i][2])
        self._fill_cylinders(index, [i for i, (kind, _, _) in enumerate(drawn) if kind == "cylinder-barrel"])
        self.load.show(index, self.tips[index])
        self.trail.set_data(self.tips[: index + 1, 0], self.tips[: index + 1, 1])
        self.clock.set_text(f"{self.times[index]:6.2f} s")
        if self.plan:
            self.plan.show(index)
        # Drawn from back to front.
        moving = [*self.parts, *self.plates.values(), *self.rod_sides, *self.load.parts]
        plan = self.plan.parts if self.plan else []
        return sorted([self.trail, *moving, self.clock, *plan], key=Artist.get_zorder)

    def _fill_cylinders(self, index: int, barrels: list[int]) -> None:
        """The barrels in the colours of the pressures at both sides of their pistons."""
        low, high = self.machine.stroke_limits.T
        shares = np.clip((self.machine.strokes(self.poses[index]) - low) / (high - low), 0.04, 0.96)
        for i in barrels:
            c = self.cylinders.index(self.names[i])
            share = shares[c]
            foot, mouth = np.column_stack(self.parts[i].get_data())
            piston = foot + share * (mouth - foot)
            self.rod_sides[c].set_data(*np.stack([piston, mouth], axis=1))
            for line, pressure in zip(
                (self.parts[i], self.rod_sides[c]), self.oil[2 * c : 2 * c + 2, index], strict=True
            ):
                red, green, blue, alpha = self.shade.to_rgba(pressure * 1e-5)
                line.set_color((red, green, blue, alpha))


def _write_gif(scene: _Scene, path: Path, fps: int, progress: Progress) -> None:
    """Draw the fixed scene once and only the moving parts per picture; all pictures have the palette of the first
    one."""
    canvas = scene.figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)
    for artist in scene.show(0):
        artist.set_animated(True)
    canvas.draw()
    stage = canvas.copy_from_bbox(scene.figure.bbox)
    pictures: list[Image.Image] = []
    palette: Image.Image | None = None
    for done, index in enumerate(scene.order):
        canvas.restore_region(stage)
        for artist in scene.show(index):
            scene.axes.draw_artist(artist)
        drawn = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
        palette = palette or _palette(drawn)
        pictures.append(drawn.quantize(palette=palette, dither=Image.Dither.NONE))
        if progress:
            progress(done, len(scene.order))
    # The unit of time in a GIF is 0.01 s.
    pause = max(round(100 / fps), 1) * 10
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=pause, loop=0)


def _palette(picture: Image.Image) -> Image.Image:
    """The colours of a picture; its lightest ones become white, because colours are matched coarsely."""
    reduced = picture.quantize(256)
    colours = np.array(reduced.getpalette()).reshape(-1, 3)
    colours[(colours >= 248).all(axis=1)] = 255
    reduced.putpalette(colours.reshape(-1).tolist())
    return reduced


def _write_mp4(scene: _Scene, path: Path, fps: int, progress: Progress) -> None:
    writer = FFMpegWriter(fps=fps, bitrate=1800)
    try:
        with writer.saving(scene.figure, str(path), _DPI):
            for done, index in enumerate(scene.order):
                scene.show(index)
                writer.grab_frame()
                if progress:
                    progress(done, len(scene.order))
    except (subprocess.CalledProcessError, BrokenPipeError):
        raise OSError("ffmpeg could not finish the film; is the disk full?") from None


_WRITERS = {".gif": _write_gif, ".mp4": _write_mp4}


class _HangingLoad:
    """A cube of steel below the tip, with its mass."""

    def __init__(self, axes: Axes, masses: Array) -> None:
        self.masses = masses
        self.cube = axes.add_patch(Rectangle((0, 0), 0, 0, facecolor=COLOURS[1], edgecolor=INK, zorder=5.5))
        self.rope = axes.plot([], [], color=INK, lw=1.2, zorder=5.4)[0]
        self.label = axes.text(0, 0, "", ha="center", va="top", zorder=5.6)
        self.parts: list[Artist] = [self.rope, self.cube, self.label]

    def show(self, index: int, tip: Array) -> None:
        mass, (x, z) = self.masses[index], tip
        side = float(np.cbrt(max(mass, 0.0) / _STEEL))
        self.cube.set(xy=(x - side / 2, z - 1.5 * side), width=side, height=side, visible=mass > 0)
        self.rope.set_data([x, x], [z, z - 0.5 * side])
        self.label.set(position=(x, z - 1.6 * side), text=f"{mass:.0f} kg" if mass > 0 else "")


class _Plan:
    """A machine in space from above, in a corner of the side view: a line to the tip, and the path of the tip."""

    def __init__(self, axes: Axes, tips: Array) -> None:
        self.places = tips[:, :2]
        reach = 1.15 * float(np.linalg.norm(self.places, axis=1).max())
        inset = axes.inset_axes((0.02, 0.66, 0.28, 0.28))
        inset.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", xticks=[], yticks=[])
        inset.set_title("from above", fontsize=8, pad=2)
        inset.plot(0.0, 0.0, "o", ms=4, color=INK)
        self.trail = inset.plot([], [], color=ACCENT, lw=1.2)[0]
        self.arm = inset.plot([], [], color=INK, lw=2.2, solid_capstyle="round")[0]
        self.parts: list[Artist] = [self.trail, self.arm]

    def show(self, index: int) -> None:
        x, y = self.places[: index + 1].T
        self.trail.set_data(x, y)
        self.arm.set_data([0.0, x[-1]], [0.0, y[-1]])


def _pictures(run: Record, fps: int, speed: float) -> tuple[Array, Array, Array]:
    """Times, poses and tips of the pictures, from the recorded run."""
    time = run.columns.time
    if time.size == 0:
        raise InputError(f"this run recorded nothing to animate: {run.outcome.kind}, {run.outcome.message}")
    count = max(int(round((time[-1] - time[0]) / speed * fps)), 1)
    times = np.linspace(time[0], time[-1], count + 1)
    poses = np.column_stack([np.interp(times, time, run.columns[f"joint.{j}.q"].values) for j in run.joint_names])
    return times, poses, np.array([_tip(run.machine, q) for q in poses])


def _tip(machine: Machine, q: Array) -> Array:
    """The tip as it is drawn: of a machine in space from the side."""
    return next(line[0] for kind, _, line in machine.drawing(q) if kind == "tip")


def _at(run: Record, times: Array, name: str) -> Array:
    """A recorded signal at the times of the pictures; loads change at once, not along a line."""
    values, time = run.columns[name].values, run.columns.time
    if name == "payload":
        return values[np.clip(np.searchsorted(time, times, side="right") - 1, 0, None)]
    return np.interp(times, time, values)


def _set_stage(axes: Axes, run: Record, machine: Machine, poses: Array) -> None:
    """The fixed parts: regions or else the ground, a shadow of the start pose, title, a view for all pictures."""
    shown = poses[np.linspace(0, len(poses) - 1, min(len(poses), 12)).astype(int)]
    points = np.concatenate([line for q in shown for _, _, line in machine.drawing(q)])
    low, high = points.min(axis=0), points.max(axis=0)
    pad = 0.10 * float((high - low).max()) + 0.05
    if machine.keep_out:
        draw_keep_out(axes, machine)
    else:
        axes.axhline(float(low[1]), color=MUTED, lw=1.0, zorder=0.5)
    draw_crane(axes, machine.drawing(poses[0]), alpha=0.12)
    axes.set_xlim(low[0] - pad, high[0] + pad)
    axes.set_ylim(low[1] - pad, high[1] + pad)
    metres(axes, fixed=True)
    axes.set_title(f"{run.columns.attrs['scenario']}  ·  {machine.name}")

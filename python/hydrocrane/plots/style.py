"""Common style of all pictures: colours, fonts, and the usual units."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import wraps
from pathlib import Path
from typing import Any, Literal, ParamSpec, TypedDict, Unpack

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.backend_bases import FigureCanvasBase
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.ticker import LogFormatter

from hydrocrane.errors import ResultFileError
from hydrocrane.files.whole_file import written_whole
from hydrocrane.notebook import in_notebook
from hydrocrane.plots.grid_layout import arrange

INK = "#22313f"
MUTED = "#7b8794"
GRID = "#e4e7eb"
ACCENT = "#c8553d"
# Readable on white; distinguishable in grey and with red-green colour blindness.
COLOURS = ("#1f6f8b", "#e08e2b", "#6a4c93", "#3a9d6b", "#c8553d", "#7b8794")
FIELD = "viridis"

RC: Any = {
    "figure.dpi": 110,
    "savefig.dpi": 150,
    "figure.facecolor": "white",
    "font.size": 9.5,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.edgecolor": MUTED,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.prop_cycle": cycler(color=COLOURS),
    "axes.formatter.useoffset": False,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "text.color": INK,
    # Texts come from files: dollar signs in them are no formulas, neither matplotlib's nor TeX's.
    "text.parse_math": False,
    "text.usetex": False,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.size": 3,
    "ytick.major.size": 3,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
}

# SI unit -> (unit on pictures, factor).
SHOWN = {
    "rad": ("deg", 180 / np.pi),
    "rad/s": ("deg/s", 180 / np.pi),
    "m": ("mm", 1e3),
    "m/s": ("mm/s", 1e3),
    "Pa": ("bar", 1e-5),
    "m^3/s": ("l/min", 6e4),
    "W": ("kW", 1e-3),
    "J": ("kJ", 1e-3),
    "N": ("kN", 1e-3),
}

# Options of the writers, by suffix. Compression level 3 in place of the usual 6 saves a third of the time, and files
# are a tenth larger. Without a date and with fixed names files are reproducible.
OPTIONS: dict[str, dict[str, Any]] = {
    ".png": {"pil_kwargs": {"compress_level": 3}},
    ".svg": {"metadata": {"Date": None}},
    ".pdf": {"metadata": {"CreationDate": None}},
}
SAME_EVERY_TIME: Any = {"svg.hashsalt": "hydrocrane"}
# Characters that no XML holds.
NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

P = ParamSpec("P")


def shown(unit: str) -> tuple[str, float]:
    """Unit used on pictures for an SI unit, and the factor to it."""
    return SHOWN.get(unit, (unit, 1.0))


def styled(make: Callable[P, Figure]) -> Callable[P, Figure]:
    """Draw a figure in this style without changing matplotlib's global settings."""

    @wraps(make)
    def in_style(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with mpl.rc_context(RC):
            made = shown_once(_with_plain_decades(make(*args, **kwargs)))
            shows_at_once = mpl.is_interactive()
        # The first figure loads the backend. That of notebooks then switches interactive mode on, which the context
        # must not undo.
        mpl.interactive(shows_at_once)
        return made

    return in_style


def _with_plain_decades(fig: Figure) -> Figure:
    """Numbers at logarithmic axes without powers of ten, which are formulas."""
    for axis in (axis for axes in fig.axes for axis in (axes.xaxis, axes.yaxis) if axis.get_scale() == "log"):
        axis.set_major_formatter(LogFormatter())
        axis.set_minor_formatter(LogFormatter(labelOnlyBase=False))
    return fig


def shown_once(fig: Figure) -> Figure:
    """Removes a figure from pyplot: a notebook shows the result of a cell and all figures of pyplot, which would show
    it twice."""
    if in_notebook():
        plt.close(fig)
    return fig


class Subplots(TypedDict, total=False):
    """Arguments of :func:`matplotlib.pyplot.subplots` besides the number of rows and columns."""

    sharex: bool | Literal["none", "all", "row", "col"]
    sharey: bool | Literal["none", "all", "row", "col"]
    squeeze: bool
    width_ratios: Sequence[float]
    height_ratios: Sequence[float]


def one_chart(width: float, height: float) -> tuple[Figure, Axes]:
    """A figure of width x height inches and its axes."""
    fig = plt.figure(figsize=(width, height), layout="constrained")
    return fig, fig.subplots()


def figure(
    width: float, height: float, *, nrows: int = 1, ncols: int = 1, **subplots: Unpack[Subplots]
) -> tuple[Figure, np.ndarray]:
    """A figure of width x height inches and the axes of its charts, laid out without overlaps."""
    fig = plt.figure(figsize=(width, height), layout="constrained")
    return fig, np.asarray(fig.subplots(nrows, ncols, **subplots))


def title(fig: Figure, text: str, detail: str = "") -> None:
    """A headline, with a quieter detail after it."""
    fig.suptitle(f"{text}  ·  {detail}" if detail else text, fontsize=12, fontweight="bold", color=INK)


def draw_crane(axes: Axes, lines: list[tuple[str, str, np.ndarray]], *, alpha: float = 1.0) -> None:
    """Draw the lines of ``Machine.drawing``; a closed one is a plate."""
    for kind, _, points in lines:
        axes.plot(points[:, 0], points[:, 1], alpha=alpha, **CRANE_LINES[kind])
        if is_plate(points):
            axes.add_artist(Polygon(points, alpha=alpha, **PLATE))


def is_plate(points: np.ndarray) -> bool:
    """Whether a line of a crane is closed."""
    return len(points) > 2 and bool((points[0] == points[-1]).all())


# Style of what a closed line surrounds, and of each kind of line of a crane.
PLATE: dict[str, Any] = {"facecolor": GRID, "lw": 0, "zorder": 2.9}
CRANE_LINES: dict[str, dict[str, Any]] = {
    "link": {"color": INK, "lw": 3.0, "solid_capstyle": "round", "solid_joinstyle": "round", "zorder": 3},
    "cylinder-barrel": {"color": COLOURS[1], "lw": 4.5, "solid_capstyle": "butt", "zorder": 4},
    "cylinder-rod": {"color": MUTED, "lw": 2.0, "solid_capstyle": "round", "zorder": 3.5},
    "torque-link": {"color": COLOURS[2], "lw": 2.0, "solid_capstyle": "round", "zorder": 4.5},
    "joint": {"color": "white", "marker": "o", "ms": 5.5, "mec": INK, "mew": 1.4, "ls": "none", "zorder": 5},
    "tip": {"color": ACCENT, "marker": "o", "ms": 6.5, "mec": "white", "mew": 1.0, "ls": "none", "zorder": 6},
}


def write(fig: Figure, path: Path) -> Path:
    """Save a figure atomically; missing folders are made."""
    checked_suffix(path)
    # Vector formats measure texts differently, and another resolution changes the layout.
    once = path.suffix.lower() == ".png" and mpl.rcParams["savefig.dpi"] == "figure"
    options = OPTIONS.get(path.suffix.lower(), {})
    with written_whole(path) as beside, laid_out(fig) if once else nullcontext(), mpl.rc_context(SAME_EVERY_TIME):
        fig.savefig(beside, **options)
        if path.suffix.lower() == ".svg":
            text = beside.read_text(encoding="utf-8")
            beside.write_text(NO_XML.sub("\ufffd", text), encoding="utf-8", newline="")
    return path


@contextmanager
def laid_out(fig: Figure) -> Iterator[None]:
    """Solve the layout once and keep it; `savefig` would draw twice, first for the layout."""
    engine = fig.get_layout_engine()
    if engine is None:
        yield
        return
    if not arrange(fig):
        engine.execute(fig)
    with mpl.rc_context({"figure.autolayout": False, "figure.constrained_layout.use": False}):
        fig.set_layout_engine(None)
    try:
        yield
    finally:
        fig.set_layout_engine(engine)


def checked_suffix(path: Path) -> Path:
    """The path of a picture, or an error that names the suffixes that can be written."""
    known = FigureCanvasBase.get_supported_filetypes()
    if path.suffix.lower().lstrip(".") not in known:
        raise ResultFileError(f"cannot write `{path.name}`: choose a suffix from .{', .'.join(sorted(known))}")
    return path

"""The result of a run: its data, how it ended, and its methods."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, cast

from hydrocrane.asked import ask
from hydrocrane.errors import ResultFileError
from hydrocrane.files.datasets import load_netcdf, save
from hydrocrane.notebook import of_text
from hydrocrane.results.carried import taken_out
from hydrocrane.results.record import Record
from hydrocrane.results.summary import text

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.figure import Figure

    from hydrocrane.logs.columns import LogLike
    from hydrocrane.results.comparison import Comparison


class Run(Record):
    """The record of a run, with methods for summary, files, pictures and comparison with a log.

    Attributes
    ----------
    data : xarray.Dataset
        Over ``time``: every state by its name, ``tip.x``, ``tip.z``,
        ``cylinder.<c>.{x,v,force,friction,q1,q2,command}``, ``supply.{flow,power}``, ``payload``, ``ledger.*``; each
        with ``units`` and ``long_name``. Closed-loop runs add ``measured.*``, ``stick.*``, ``controller.<c>`` and,
        where the controller has one, ``set_point.{x,z}`` and ``tip.deviation``.

    Examples
    --------
    >>> run = hc.simulate("vertical-lift-open-loop", duration=1.0)
    >>> print(run.columns["tip.z"].values[-1].round(3), run.data["tip.z"].attrs["units"])
    -0.145 m
    >>> path = run.save("lift.csv")
    >>> print(run.summary().splitlines()[0])
    vertical-lift-open-loop on rottne-f9-lab: completed at 1 s
    """

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Run:
        """Read a run saved as NetCDF.

        Examples
        --------
        >>> run = hc.simulate("vertical-lift-open-loop", duration=0.2)
        >>> hc.Run.load(run.save("lift.nc")).outcome.kind
        'completed'
        """
        data = load_netcdf(Path(path))
        run = cls(data, carried=taken_out(data.attrs))
        run._check(str(path))
        return run

    def summary(self) -> str:
        """A few lines of text: outcome, effort, tip, cylinders, energy.

        Examples
        --------
        >>> run = hc.simulate("vertical-lift-open-loop", duration=0.2)
        >>> run.summary().splitlines()[0]
        'vertical-lift-open-loop on rottne-f9-lab: completed at 0.2 s'
        """
        try:
            return text(self)
        except (KeyError, TypeError, ValueError) as error:
            reason = f"has lost or damaged what a summary needs ({type(error).__name__}: {error})"
            raise ResultFileError(f"this run {reason}; its data can be read") from None

    def _repr_html_(self) -> str:
        return of_text(self.summary(), "print(run.summary())")

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the data; the suffix decides: ``.nc``, ``.mat``, ``.csv``, ``.parquet``, ``.xlsx``,
        ``.mf4`` or ``.mcap``.

        Files with attributes carry the text of the machine, ``machine_text``, but no path of its file.
        The last four need an optional package; if it is missing, the error names it.

        Examples
        --------
        >>> run = hc.simulate("vertical-lift-open-loop", duration=0.2)
        >>> run.save("lift.nc").name
        'lift.nc'
        """
        return save(self._carrying_its_machine(), Path(path))

    def plot(self, chart: str | None = None, *, path: str | PathLike[str] | None = None) -> Figure:
        """Charts of the run; with `path` the picture is also written.

        Parameters
        ----------
        chart : str, optional
            Name of a cylinder: its joint, pressures, piston, spool and force, Figures 86-88 of the thesis and more;
            ``tip``: the path of the tip; ``energy``: energy sources and sinks; ``supply``: pump and load sensing. By
            default the charts of all cylinders, side by side.
        path : path, optional
            The suffix decides: ``.png``, ``.svg``, ``.pdf``.

        Raises
        ------
        InputError
            If there is no such chart, or nothing was recorded for it.

        Examples
        --------
        >>> run = hc.simulate("vertical-lift-open-loop", duration=0.2)
        >>> len(run.plot("lift").axes) > 3
        True
        """
        figure = cast("Figure", ask("plots", "run", self, chart))
        if path is not None:
            ask("plots", "write", figure, Path(path))
        return figure

    def animate(
        self,
        path: str | PathLike[str] | None = None,
        *,
        fps: int = 20,
        speed: float = 1.0,
        progress: Callable[[int, int], None] | None = None,
    ) -> Path | FuncAnimation:
        """Animate the crane as in Figure 89: pillar, links, cylinders, torque linkage and the path of the tip.

        Parameters
        ----------
        path : path, optional
            ``.gif``, or ``.mp4`` if ffmpeg is found; without it the matplotlib animation is returned.
        fps : int
            Pictures per second of the film.
        speed : float
            1 is real time, 2 twice as fast.
        progress : callable, optional
            Called with (pictures done, all pictures).

        Examples
        --------
        >>> run = hc.simulate("vertical-lift-open-loop", duration=0.2)
        >>> run.animate("lift.gif", fps=5).name
        'lift.gif'
        """
        if path is None:
            return cast("FuncAnimation", ask("plots", "film", self, fps=fps, speed=speed))
        return cast(Path, ask("plots", "write-film", self, Path(path), fps=fps, speed=speed, progress=progress))

    def compare(self, log: LogLike, columns: Mapping[str, str] | None = None, *, shift: float = 0.0) -> Comparison:
        """Compare this run with a measured log; see ``hydrocrane.results.comparison.compare``. A log with another clock
        than ``time``, or with units that it does not state, is given as ``hc.Log.of(log, mapping)``.

        Examples
        --------
        >>> run = hc.simulate("vertical-lift-open-loop", duration=0.2)
        >>> apart = run.compare({"time": run.columns.time, "tip.z": run.columns["tip.z"].values})
        >>> apart.rms["tip.z"]
        0.0
        """
        from hydrocrane.results.comparison import compare

        return compare(self, log, columns, shift=shift)


def load_run(path: str | PathLike[str]) -> Run:
    """Read a run saved as NetCDF.

    Examples
    --------
    >>> path = hc.simulate("vertical-lift-open-loop", duration=1.0).save("lift.nc")
    >>> print(hc.load_run("lift.nc").outcome.kind)
    completed
    """
    return Run.load(path)

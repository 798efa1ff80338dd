"""Valve parameters that a controller learnt."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LearntValve:
    """Learnt parameters of one valve; see docs/theory/control/estimate.md.

    Attributes
    ----------
    offset, dead_band : float
        m of spool stroke.
    gain : float
        Spool position per command outside the dead band; mean of both directions.
    leakage : float
        Factor on that of the controller model; a signal chain cannot state it.
    """

    offset: float
    gain: float
    dead_band: float
    leakage: float


class LearntValves(dict[str, LearntValve]):
    """Learnt valves by their names in the machine file."""

    def to_toml(self) -> str:
        """The signal chains as a block for a machine file; the controller then uses them from the first sample on.

        Each valve's table `command` replaces that of the file.

        Examples
        --------
        >>> from hydrocrane.results.learnt import LearntValve, LearntValves
        >>> print(LearntValves(lift=LearntValve(0.001, 0.8, 0.0025, 1.0)).to_toml(), end="")
        [valve.lift.command]
        offset = { value = "0.001 m", class = "fitted", source = "learnt by tip control" }
        gain = { value = 0.8, class = "fitted", source = "learnt by tip control" }
        dead-band = { value = "0.0025 m", class = "fitted", source = "learnt by tip control" }
        """
        origin = 'class = "fitted", source = "learnt by tip control"'
        blocks = [
            f"[valve.{name}.command]\n"
            f'offset = {{ value = "{valve.offset:.6g} m", {origin} }}\n'
            f"gain = {{ value = {valve.gain:.6g}, {origin} }}\n"
            f'dead-band = {{ value = "{valve.dead_band:.6g} m", {origin} }}\n'
            for name, valve in self.items()
        ]
        return "\n".join(blocks)

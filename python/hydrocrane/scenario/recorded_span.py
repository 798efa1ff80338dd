"""How long a scenario runs, and what of it is recorded."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hydrocrane.arrays import Array, scenario_quantity
from hydrocrane.scenario.record_size import bytes_of, check_size, row_count


@dataclass(frozen=True, kw_only=True)
class RecordedSpan:
    """Duration and record of a scenario; described there."""

    duration: float = 5.0
    record_interval: float = 0.01
    record_limit: float | str | None = field(default=None, compare=False)

    def _check_record(self) -> None:
        scenario_quantity("scenario.duration", "duration", self.duration)
        scenario_quantity("scenario.record-interval", "record_interval", self.record_interval)
        bytes_of(self.record_limit)

    def record_times(self) -> Array:
        """Times at which the run is recorded, from 0 to `duration`, s.

        Raises
        ------
        InputError
            If the times alone would take more than `record_limit`.

        Examples
        --------
        >>> hc.load_scenario("vertical-lift-open-loop").record_times()[:3]
        array([0.  , 0.01, 0.02])
        """
        count = row_count(self.duration, self.record_interval)
        cure, most = "a longer record_interval or a shorter duration", bytes_of(self.record_limit)
        check_size("the times of this run", count, f"{count:.4g} numbers", cure, most)
        times: Array = np.arange(int(count), dtype=np.float64) * self.record_interval
        if self.duration - times[-1] > 1e-9 * self.duration:
            return np.append(times, self.duration)
        times[-1] = self.duration
        return times

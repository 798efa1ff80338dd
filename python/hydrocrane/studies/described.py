"""The view of a study in notebooks."""

from __future__ import annotations

from hydrocrane.studies.case import Job
from hydrocrane.studies.design import Cases


def varied_and_kept(cases: Cases, job: Job) -> list[str]:
    """Values of each key, measures and signals, a line each: label, two spaces, value."""
    lines = []
    for key, values in zip(cases.keys, cases.axes, strict=True):
        tried = list(dict.fromkeys(map(_shown, values)))
        numbers = [value for value in values if isinstance(value, (int, float))]
        # Drawn numbers come in no order.
        first, last = (min(numbers), max(numbers)) if len(numbers) == len(values) else (values[0], values[-1])
        ends = ", ".join(tried) if len(tried) <= 6 else f"{_shown(first)} ... {_shown(last)}"
        lines.append(f"{key.name}  {len(values)} values: {ends}")
    lines.append(f"measures  {', '.join(measure.name for measure in job.measures)}")
    if job.signals:
        lines.append(f"signals  {', '.join(job.signals)}")
    return lines


def _shown(value: object) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)

"""Studies: one scenario run many times, with other values of some keys each time.

Files: `key` and `keys` define dotted keys, `changes` applies their values, `ranges` and `design` choose the cases,
`measures` and `signals` define what is stored of a run, `record` and `case` run, `local`, `processes`, `worker` and
`cluster` distribute the work, `board` tells what is under way, `store` stores the results, `identity` compares studies,
`study` combines all of these, `study_file` reads a study from TOML.

Modules are imported on first use of a name: a process that computes cases needs few of them.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hydrocrane.studies.store import open_study
    from hydrocrane.studies.study import Study, StudyInterrupted, sweep
    from hydrocrane.studies.study_file import load_study

__all__ = ["Study", "StudyInterrupted", "load_study", "open_study", "sweep"]
_HOME = {"load_study": "study_file", "open_study": "store"}


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module 'hydrocrane.studies' has no attribute {name!r}")
    return getattr(importlib.import_module(f"hydrocrane.studies.{_HOME.get(name, 'study')}"), name)

"""Studies: one scenario run many times, with other values of some keys each time.

Files: `key` and `keys` define dotted keys, `values` and `changes` apply their values, `ranges` and `design` choose the
cases, `measures` and `signals` define what is stored of a run, `record` and `case` run, `local` and `cluster`
distribute the work, `store` stores the results, `identity` compares studies, `study` combines all of these,
`study_file` reads a study from TOML.
"""

from hydrocrane.studies.store import open_study
from hydrocrane.studies.study import Study, StudyInterrupted, sweep
from hydrocrane.studies.study_file import load_study

__all__ = ["Study", "StudyInterrupted", "load_study", "open_study", "sweep"]

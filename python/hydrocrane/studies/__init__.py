"""Studies: one scenario run many times, with other values of some keys each time.

Files: `key` and `keys` say what a dotted key means, `values` and `changes` what becomes of its values, `ranges` and
`design` which of them are run, `measures` and `signals` what is kept of a run, `record` and `case` run, `local` and
`cluster` spread the work, `store` keeps what is done, `identity` tells one study from another, `study` holds it all
together, `study_file` reads it from TOML.
"""

from hydrocrane.studies.store import open_study
from hydrocrane.studies.study import Study, StudyInterrupted, sweep
from hydrocrane.studies.study_file import load_study

__all__ = ["Study", "StudyInterrupted", "load_study", "open_study", "sweep"]

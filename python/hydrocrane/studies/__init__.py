"""Studies: one scenario run many times, with other values of some keys each time.

Files: `keys` says what a dotted key means, `ranges` and `design` which values are run, `measures` what is kept of a
run, `case` runs, `local` and `cluster` spread the work, `store` keeps what is done, `identity` tells one study from
another, `study` holds it all together, `study_file` reads it from TOML.
"""

from hydrocrane.studies.store import open_study
from hydrocrane.studies.study import Study, StudyInterrupted, sweep
from hydrocrane.studies.study_file import load_study

__all__ = ["Study", "StudyInterrupted", "load_study", "open_study", "sweep"]

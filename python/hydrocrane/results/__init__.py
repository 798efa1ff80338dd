"""Results of a run: record, summary, warnings, verification, comparison with a log, citation."""

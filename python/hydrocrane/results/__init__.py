"""What a run leaves: its record, summary, warnings, verification, comparison with a log, citation."""

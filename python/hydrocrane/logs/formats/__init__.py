"""Files of loggers, one file per family of formats."""

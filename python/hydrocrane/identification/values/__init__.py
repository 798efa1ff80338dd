"""Any values of a machine file from logs: unknowns and priors, models of a log, search, intervals, doubts, report."""

"""Solvers of the same crane, ours and others: each file makes them of a problem, as functions of a tolerance."""

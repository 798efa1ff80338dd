"""Solvers of others on the same crane: each file offers ``solvers(problem)``, names with a function of the tolerance."""

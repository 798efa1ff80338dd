"""Friction as a static map of velocity: points, forms of the map, fit, checks, intervals, comparison, report."""

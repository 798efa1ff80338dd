"""Linear models as matrices: responses, oscillations, files for other programs. What makes them of a crane: linear."""

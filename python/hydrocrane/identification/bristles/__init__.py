"""Stiffness and damping of the bristles: the rig is a machine whose simulation is fitted to its logs."""

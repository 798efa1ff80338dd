"""Inputs of a crane: sticks, and controllers by name or your own."""

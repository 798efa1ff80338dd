"""Models of the crane that other tools integrate."""

"""Questions to a machine or a scenario: modes, sensitivities, load charts."""

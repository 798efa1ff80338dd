"""Files: written whole or not at all, TOML with clear errors, runs in the formats of other programs."""

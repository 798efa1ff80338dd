"""Writers of a tape, one per language."""

"""What this package costs by itself: each file offers ``measure``, which returns plain numbers for ``results.json``."""

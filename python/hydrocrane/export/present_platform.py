"""The name of the present platform.

``conda/libraries.py`` runs this file before the package can be imported: it imports the standard library only.
"""

from platform import machine, system

# Other names of the same processors: those of macOS and of Windows.
_PROCESSORS = {"arm64": "aarch64", "amd64": "x86_64"}


def present() -> str:
    """Name of the platform of the present computer, whether or not there is an FMU library for it."""
    processor = machine().lower()
    return f"{system().lower()}-{_PROCESSORS.get(processor, processor)}"

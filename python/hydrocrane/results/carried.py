"""The machine that a saved run carries: the text of one file with everything in it, and never the path of a file."""

from __future__ import annotations

import hashlib
import json
from collections.abc import MutableMapping

from hydrocrane.errors import ResultFileError
from hydrocrane.files.columns import Attributes
from hydrocrane.machine.machine import Machine, bundled_machines, load_machine, machine_of_text

# Attributes of a run.
TEXT, DIGEST = "machine_text", "machine_hash"
# What errors call a machine that has no file. It has a blank, as no bundled name and no path of a machine file.
SOURCE = "the machine of a saved run"


def statement(machine: Machine) -> Attributes:
    """The attributes that a run carries."""
    text = machine.core.file_text
    return {TEXT: text, DIGEST: _digest(text)}


def taken_out(about: MutableMapping[str, object]) -> Attributes:
    """What a run carries, taken out of the attributes of its file."""
    return {name: str(about.pop(name)) for name in (TEXT, DIGEST) if name in about}


def made(about: Attributes, carried: Attributes) -> Machine:
    """The machine that a run with these attributes carries.

    Raises
    ------
    HydrocraneError
        If it carries none, or a damaged one.
    """
    if TEXT not in carried:
        raise ResultFileError(
            f"this run carries no machine, because {about.get('source', 'another program')} saved none with it; its "
            "data can still be read, and hydrocrane.Run(data, machine) takes a machine"
        )
    text = str(carried[TEXT])
    if carried.get(DIGEST) != _digest(text):
        raise ResultFileError("the machine that this run carries was changed since: its text does not match its hash")
    try:
        overrides = json.loads(str(about.get("machine_overrides", "{}")))
    except (ValueError, RecursionError) as error:
        raise ResultFileError(f"what this run says of its `machine_overrides` is damaged: {error}") from None
    name = str(about.get("machine_source"))
    if name in bundled_machines():
        bundled = load_machine(name, overrides)
        if bundled.core.file_text == text:
            return bundled
    return machine_of_text(text, SOURCE, overrides)


def _digest(text: str) -> str:
    return f"sha256 {hashlib.sha256(text.encode()).hexdigest()}"

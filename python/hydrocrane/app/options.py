"""Reading what people type: overrides and poses."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, cast

from hydrocrane import _core
from hydrocrane.errors import InputError, ResultFileError, check_known
from hydrocrane.files.toml_file import parsed
from hydrocrane.machine.poses import SHOWN, poses
from hydrocrane.units import converted, plain_number

if TYPE_CHECKING:
    from hydrocrane.analysis.capacity import Height
    from hydrocrane.arrays import Array
    from hydrocrane.files.toml_file import TomlValue
    from hydrocrane.machine.machine import Machine
    from hydrocrane.machine.overrides import Override


def overrides(settings: list[str]) -> dict[str, Override]:
    """``["supply.pressure=100 bar", "payload.mass=200 kg"]`` as a mapping; what reads as TOML is taken as TOML.

    Numbers stay texts: as in a file, a quantity needs its unit there. (In Python a number is SI.)
    """
    found = {}
    for setting in settings:
        key, sign, text = setting.partition("=")
        if not sign or not key.strip() or not text.strip():
            raise InputError(f'--set takes KEY=VALUE, for example --set supply.pressure="100 bar"; got `{setting}`')
        if key.strip() in found:
            raise InputError(f"--set gives `{key.strip()}` twice; keep one of the two")
        found[key.strip()] = _value(text.strip())
    return found


def _value(text: str) -> Override:
    try:
        value = parsed(f"value = {text}", "--set")["value"]
    except InputError:  # The machine's own check says what is wrong with the text.
        return text
    # A date or a table is no override: leave it to the machine's own check of the text.
    return _as_text(value) if isinstance(value, bool | int | float | str | list) else text


def _as_text(value: TomlValue) -> Override:
    if isinstance(value, list):
        return [_as_text(item) for item in value]
    return value if isinstance(value, bool | str) else repr(value)


def pose(machine: Machine, settings: list[str]) -> Array:
    """Joint coordinates from ``["boom=100 deg", "extension=50 mm"]``; joints left out stay in mid-range."""
    q, given = machine.home.copy(), set()
    for setting in settings:
        name, sign, text = setting.partition("=")
        name = name.strip()
        check_known("joint", name, machine.joint_names)
        if name in given:
            raise InputError(f"--at gives `{name}` twice; keep one of the two")
        given.add(name)
        index = machine.joint_names.index(name)
        unit = machine.joint_units[index]
        try:
            q[index] = converted("--at", text.strip(), unit)
        except InputError as error:
            shown, _ = SHOWN[unit]
            raise InputError(
                f"--at takes JOINT=VALUE with a unit, such as {name}='100 {shown}'; got `{setting}`: {error}"
            ) from None
    return poses(machine, q, "--at", units_stated=True)


def tip_height(text: str | None) -> Height | None:
    """``best``, ``worst``, or a height such as ``1.5 m`` in metres; nothing stays nothing."""
    if text is None:
        return None
    if text in ("best", "worst"):
        return cast("Height", text)
    try:
        return converted("--height", text, "m")
    except InputError:
        message = f"--height takes best, worst, or a length with its unit, such as '1.5 m'; got `{text}`"
        raise InputError(message) from None


def stretch(option: str, text: str | None, example: str) -> tuple[float, float] | None:
    """``0:1`` as two times, s."""
    if text is None:
        return None
    first, _, last = text.partition(":")
    try:
        start, end = plain_number(first), plain_number(last)
    except ValueError:
        raise InputError(f"{option} takes two times in s, FROM:TO, for example {example}; got `{text}`") from None
    if not start < end:
        raise InputError(f"{option} takes FROM:TO with FROM before TO, for example {example}; got `{text}`")
    return start, end


def wanted_suffix(option: str, path: Path | None, *suffixes: str) -> None:
    """Refuse a file of another kind before anything is computed for it."""
    if path is not None and path.suffix.lower() not in suffixes:
        raise ResultFileError(f"{option} takes a file that ends in {suffixes[0]}, unlike `{path.name}`")


def checked_machine(source: str) -> str:
    """`source`, where a machine is wanted; an error that helps where it is a scenario or a saved run."""
    import hydrocrane as hc

    if source.endswith(".nc"):
        raise InputError(f"`{source}` is a saved run, and this takes a machine: a bundled name or a machine file")
    if is_scenario(source):
        raise InputError(
            f"`{source}` is a scenario, and this takes a machine; its machine is `{hc.load_scenario(source).machine}`"
        )
    return source


def checked_scenario(source: str) -> str:
    """`source`, where a scenario is wanted; an error that helps where it is a machine."""
    import hydrocrane as hc

    if source in hc.bundled_machines() or _holds(source, "machine"):
        raise InputError(
            f"`{source}` is a machine, and this takes a scenario or a saved run (.nc); `hydrocrane machines` lists the "
            "bundled scenarios"
        )
    return source


def is_scenario(source: str) -> bool:
    """Whether a name or file is a scenario; a file that cannot be read as TOML goes to the machine check."""
    import hydrocrane as hc

    return source in hc.bundled_scenarios() or _holds(source, "scenario")


def _holds(source: str, table: str) -> bool:
    """Whether a file that can be read as TOML has a table."""
    return table in _core.tables_of(source)

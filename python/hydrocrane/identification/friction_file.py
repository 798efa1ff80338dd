"""What was identified as a file that a machine file includes."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from hydrocrane.errors import InputError
from hydrocrane.identification.block import friction_block, head, interval, signature
from hydrocrane.identification.dynamic_result import DYNAMIC, UNITS
from hydrocrane.identification.records import STEADY

if TYPE_CHECKING:
    from hydrocrane.identification.campaign_result import Identification

FADING = "bristle-damping-velocity"


def friction_file(found: Identification, cylinder: str, *, date: str = "", file_name: str = "friction.toml") -> str:
    """Comments on the origin, then ``[friction.<cylinder>]`` with what was fitted.

    Without a static map the block holds the bristles alone, to be laid over a file that has the rest.
    """
    bristles = _bristles(found)
    static = None if found.static is None else found.static.fit
    if static is None and not bristles:
        reasons = "; ".join(f"{stage.name}: {stage.message}" for stage in found.stages if stage.message)
        raise InputError(f"nothing was identified, so there is nothing to write. {reasons}")
    if static is not None:
        used = static.points.source + _dynamic_names(found)
        block = friction_block(static, cylinder, source=dict.fromkeys(used), date=date, bristles=bristles)
    else:
        source = f"{', '.join(_dynamic_names(found))}; output-error fit, {signature(date)}"
        block = "\n".join([*head(cylinder, cylinder, source, "lugre"), *bristles]) + "\n"
    return "\n".join([*_preface(found, cylinder, file_name), block])


def _preface(found: Identification, cylinder: str, file_name: str) -> list[str]:
    lines = [
        f"# Friction of the cylinder `{cylinder}`, identified on {found.rig.name}. A machine file takes it over with",
        f"#     include = [{json.dumps(file_name, ensure_ascii=False)}]",
        "# above its first table. Comments hold 95 % intervals.",
    ]
    if not _bristles(found):
        lines.append(
            '# The bristles were not identified; without `model = "static"` those of the including file stay in use.'
        )
    lines += [f"# Not finished: {stage.name}: {stage.message}" for stage in found.failures]
    return [line.replace("\n", " ") for line in lines]


def _dynamic_names(found: Identification) -> tuple[str, ...]:
    if found.dynamic is None or found.dynamic.estimate is None:
        return ()
    return tuple(r.name for r in found.records if r.role not in (STEADY, "") and not r.log.fatal)


def _bristles(found: Identification) -> list[str]:
    """Lines of the fitted bristles; the fading of their damping was held."""
    fit = found.dynamic
    if fit is None or fit.estimate is None:
        return []
    ends = fit.intervals(0.95)
    lines = []
    for name in DYNAMIC:
        lines.append(f'{name} = "{fit.params[name]:.5g} {UNITS[name]}"  # 95 %: {interval(*ends[name])}')
    key = f"friction.{found.cylinder}.{FADING}"
    if key in found.rig.keys:
        source = json.dumps(f"held in the fit, from {found.rig.name}")
        value = f"{float(found.rig.value(key).si):.5g} m/s"
        lines.append(f'{FADING} = {{ value = "{value}", class = "assumed", source = {source} }}')
    return lines

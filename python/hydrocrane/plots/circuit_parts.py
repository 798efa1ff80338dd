"""Parts of a circuit diagram; each is a sheet with its symbol and its values in the machine file.

A part below the lines of pump and tank is an entry of `SUPPLY`; a part between the pump and a spool, of `before_spool`;
a part on a line between a valve and a cylinder, of `ON_LINE`. An entry draws its symbol and its labels in about a dozen
lines; the diagram places it.
"""

from __future__ import annotations

from collections.abc import Callable

from hydrocrane.machine.circuit import Circuit, CircuitSection, CircuitTable
from hydrocrane.plots import circuit_symbols as symbols
from hydrocrane.plots.circuit_symbols import LEADING, Sheet

# Heights of the common lines, of the middle of the parts below them, and of the tanks.
TANK_LINE, PRESSURE_LINE, LOAD_LINE = 0.0, 9.0, 22.0
HUNG, TANKS = -22.0, -42.0
# Height of a part before a spool, and on the line to a cylinder.
SLOT, LINE_SLOT = 17.0, 25.0

# SI unit -> unit on the diagram and factor, by quantity.
BAR, FLOW, VOLUME, AREA, LENGTH, SPEED, TIME = (
    (1e-5, "bar"), (6e4, "l/min"), (1e6, "cm³"), (1e6, "mm²"), (1e3, "mm"), (9.549296585513721, "rpm"), (1e3, "ms"),
)  # fmt: skip


def shown(si: float | None, unit: tuple[float, str]) -> str:
    """A value with its unit; empty if the file does not state it."""
    return "" if si is None else f"{si * unit[0]:.4g} {unit[1]}"


def stated(pattern: str, *values: str) -> str:
    """A label if the file states all its values; else empty."""
    return pattern.format(*values) if all(values) else ""


# --- parts below the lines of pump and tank --------------------------------------------------------------------


def source(circuit: Circuit) -> Sheet | None:
    """A supply with a given pressure."""
    if circuit.pump is not None:
        return None
    sheet = Sheet(ports={"P": (0.0, PRESSURE_LINE)})
    sheet.line((0.0, PRESSURE_LINE), (0.0, HUNG), kind="pressure")
    symbols.pressure_source(sheet, 0.0, HUNG - 7.0)
    kind = "measured pressure" if circuit.supply.word("measured") == "yes" else "constant pressure"
    sheet.text(7.0, HUNG - 2.0, [kind, shown(circuit.supply.number("pressure"), BAR)], head=True)
    return sheet


def pumps(circuit: Circuit) -> list[Sheet]:
    """Each pump."""
    return [] if circuit.pump is None else [_pump(circuit, table) for table in (circuit.pump, *circuit.further)]


def _pump(circuit: Circuit, table: CircuitTable) -> Sheet:
    """A pump with its drive, and its control if it has one."""
    kind = table.word("type")
    sheet = Sheet(ports={"P": (0.0, PRESSURE_LINE)})
    symbols.shaft(sheet, -20.0, -8.0, HUNG)
    symbols.prime_mover(sheet, -26.0, HUNG)
    sheet.line((0.0, PRESSURE_LINE), (0.0, HUNG + 8.0), kind="pressure")
    sheet.line((0.0, HUNG - 8.0), (0.0, TANKS + 4.0))
    symbols.tank(sheet, 0.0, TANKS)
    symbols.pump(sheet, 0.0, HUNG, variable=kind != "fixed")
    sheet.text(-26.0, HUNG + 9.0, [shown(table.number("speed"), SPEED)], side="center")
    displacement, speed = table.number("displacement"), table.number("speed")
    flow = "" if displacement is None or speed is None else shown(displacement * speed / 6.283185307179586, FLOW)
    about = [
        f"pump {table.name}",
        kind,
        stated("{} per turn", shown(displacement, VOLUME)),
        stated("{} without leakage", flow),
    ]
    sheet.text(-10.0, HUNG - 10.5, about, side="right", head=True)
    if kind != "fixed":
        _control(sheet, circuit, table)
    return sheet


def _control(sheet: Sheet, circuit: Circuit, table: CircuitTable) -> None:
    """The valve that swivels the pump."""
    x = 22.0
    sheet.line((0.0, HUNG + 12.0), (14.5, HUNG + 12.0), (14.5, HUNG), (x - 4.5, HUNG), kind="pilot")
    sheet.dot(0.0, HUNG + 12.0)
    sheet.line((x - 1.9, HUNG - 4.5), (x - 1.9, HUNG - 9.5), (8.0, HUNG - 9.5), (5.7, HUNG - 5.7), kind="pilot")
    symbols.pump_control(sheet, x, HUNG)
    labels = [stated("at most {}", shown(circuit.supply.number("pressure"), BAR))]
    margin = shown(table.number("ls-margin"), BAR)
    if margin:
        sheet.line((x + 12.0, LOAD_LINE), (x + 12.0, HUNG - 2.8), (x + 4.5, HUNG - 2.8), kind="load")
        sheet.ports["LS"] = (x + 12.0, LOAD_LINE)
        labels.insert(0, f"load + {margin}")
    limit = table.number("torque-limit")
    labels.append("" if limit is None else f"at most {limit:.4g} N m")
    sheet.text(x + 14.5, HUNG + 2.0, ["control", *labels], head=True)


def main_relief(circuit: Circuit) -> Sheet | None:
    """The main relief valve; that of a fixed pump may follow the load."""
    if circuit.pump is None:
        return None
    sheet = Sheet(ports={"P": (0.0, PRESSURE_LINE)})
    sheet.line((0.0, PRESSURE_LINE), (0.0, HUNG + 4.5), kind="pressure")
    symbols.relief_valve(sheet, 0.0, HUNG)
    if circuit.tank_line.is_stated:
        low, aside = HUNG - 9.0, -11.0
        sheet.line((0.0, HUNG - 4.5), (0.0, low), (aside, low), (aside, TANK_LINE), kind="tank")
        sheet.ports["T"] = (aside, TANK_LINE)
    else:
        sheet.line((0.0, HUNG - 4.5), (0.0, TANKS + 4.0))
        symbols.tank(sheet, 0.0, TANKS)
    margin = shown(circuit.pump.number("ls-margin"), BAR)
    labels = ["relief valve", shown(circuit.relief_pressure, BAR)]
    if margin and circuit.pump.word("type") == "fixed":
        sheet.line((12.0, LOAD_LINE), (12.0, HUNG - 2.8), (4.5, HUNG - 2.8), kind="load")
        sheet.ports["LS"] = (12.0, LOAD_LINE)
        labels = ["unloading valve", f"load + {margin}", f"at most {labels[1]}"]
    sheet.text(14.5, HUNG + 2.0, labels, head=True)
    return sheet


def return_tank(circuit: Circuit) -> Sheet:
    """The tank for the return oil of all sections, below the return filter."""
    sheet = Sheet(ports={"T": (0.0, TANK_LINE)})
    sheet.line((0.0, TANK_LINE), (0.0, TANKS + 4.0), kind="tank")
    symbols.tank(sheet, 0.0, TANKS)
    if circuit.tank_line.is_stated:
        _tank_line(sheet, circuit)
    sheet.text(6.5, TANKS + LEADING, ["tank", shown(circuit.supply.number("tank-pressure"), BAR)], head=True)
    return sheet


def _tank_line(sheet: Sheet, circuit: Circuit) -> None:
    """Values of the tank line, and its filter."""
    line, part = circuit.tank_line, circuit.return_filter
    if line.number("nominal-flow") is not None:
        symbols.throttle(sheet, 0.0, TANK_LINE - 5.0)
    at_ports = any(
        table.kind in ("port-relief", "anti-cavitation") for s in circuit.sections for _, table in s.on_lines
    )
    about = [
        stated("tank line, {}", shown(line.number("volume"), VOLUME)),
        _drop(line),
        "port valves join it" if at_ports else "",
    ]
    sheet.text(6.5, TANK_LINE - 5.0, about, head=True)
    if part.is_stated:
        opening = stated("bypass opens at {}", shown(part.number("bypass-pressure"), BAR))
        symbols.return_filter(sheet, 0.0, HUNG - 6.0, bypassed=bool(opening))
        sheet.text(6.5, HUNG - 2.0, ["return filter", _drop(part), opening], head=True)


def _drop(table: CircuitTable) -> str:
    flow, drop = shown(table.number("nominal-flow"), FLOW), shown(table.number("nominal-pressure-drop"), BAR)
    return stated("{} at {}", flow, drop)


def accumulator(circuit: Circuit) -> Sheet | None:
    """Gas on the mains, beside the line that leads down to it."""
    table = circuit.accumulator
    if table is None:
        return None
    sheet = Sheet(ports={"P": (0.0, PRESSURE_LINE)})
    aside, low = 8.0, HUNG - 14.0
    sheet.line((0.0, PRESSURE_LINE), (0.0, low), (aside, low), (aside, HUNG - 9.0), kind="pressure")
    symbols.accumulator(sheet, aside, HUNG)
    exponent = table.number("polytropic-exponent")
    labels = [
        f"accumulator {table.name}",
        shown(table.number("volume"), VOLUME),
        stated("precharge {}", shown(table.number("precharge"), BAR)),
        "" if exponent is None else f"exponent {exponent:.4g}",
    ]
    sheet.text(aside + 7.0, HUNG + 2.0, labels, head=True)
    return sheet


SUPPLY: tuple[Callable[[Circuit], Sheet | None], ...] = (source, main_relief, accumulator, return_tank)


# --- between the pump and a spool, on a line that flows up; the load comes from the right at `load` -----------------


def _edge(sheet: Sheet, x: float, y: float, load: float, section: CircuitSection) -> None:
    """The metering edges of the spool if they lie before its compensator."""
    symbols.throttle(sheet, x, y, variable=True)
    sheet.text(x - 7.5, y, ["metering edge"], side="right")


def _compensator(sheet: Sheet, x: float, y: float, load: float, section: CircuitSection) -> None:
    behind = section.compensator == "behind-spool"
    symbols.compensator(sheet, x, y, behind)
    sheet.line((load, y - 2.2), (x + 4.5, y - 2.2), kind="load")
    sheet.dot(load, y - 2.2)
    labels = ["compensator", "flow sharing" if behind else shown(section.valve.number("compensator-setting"), BAR)]
    sheet.text(x - 9.0, y + 0.5 * LEADING, labels, side="right")


def _priority(sheet: Sheet, x: float, y: float, load: float, section: CircuitSection) -> None:
    symbols.priority_element(sheet, x, y)
    sheet.line((load, y - 2.2), (x + 4.5, y - 2.2), kind="load")
    sheet.dot(load, y - 2.2)
    kept = stated("below load + {}", shown(section.priority.number("margin"), BAR))
    sheet.text(x - 9.0, y + 0.5 * LEADING, ["gives way", kept], side="right")


def _load_check(sheet: Sheet, x: float, y: float, load: float, section: CircuitSection) -> None:
    symbols.check_valve(sheet, x, y)


Inlet = Callable[[Sheet, float, float, float, CircuitSection], None]


def before_spool(section: CircuitSection) -> list[Inlet]:
    """The parts between the pump and the spool, from below."""
    edge = [_edge] if section.compensator == "behind-spool" else []
    return [
        *([_priority] if section.gives_way else []),
        *edge,
        *([_compensator] if section.compensator != "none" else []),
        *([_load_check] if section.has_load_check else []),
    ]


# --- on a line between a valve and a cylinder, from the valve upwards -----------------------------------------------


def _counterbalance(sheet: Sheet, x: float, y: float, out: float, table: CircuitTable) -> None:
    """`out` is the direction from the section's middle to this line; the other line is at the same distance on the
    other side."""
    symbols.counterbalance_valve(sheet, x, y, out)
    _pilot(sheet, x, y - 2.0, y - 10.0 + 0.9 * out, out)
    labels = [
        f"counterbalance {table.name}",
        stated("{}", shown(table.number("setting"), BAR)),
        _ratio(table),
        _passes(table),
    ]
    _beside(sheet, x + out * 11.5, y, out, labels)


def _pilot(sheet: Sheet, x: float, y: float, level: float, out: float) -> None:
    """From the other line to the square of a valve at the height `y`."""
    inside = x - out * (0.5 * symbols.BOX + 2.6)
    sheet.line((-x, level), (inside, level), (inside, y), (x - out * 0.5 * symbols.BOX, y), kind="pilot")
    sheet.dot(-x, level)


def _ratio(table: CircuitTable) -> str:
    ratio = table.number("pilot-ratio")
    return "" if ratio is None else f"pilot ratio {ratio:.4g}"


def _passes(table: CircuitTable) -> str:
    """Flow at a drop."""
    flow, drop = shown(table.number("nominal-flow"), FLOW), shown(table.number("nominal-pressure-drop"), BAR)
    return stated("{} at {}", flow, drop)


def _beside(sheet: Sheet, x: float, y: float, out: float, labels: list[str]) -> None:
    """What the file says, on the outer side."""
    sheet.text(x, y + 1.5 * LEADING, labels, side="left" if out > 0 else "right", head=True)


def _pilot_check(sheet: Sheet, x: float, y: float, out: float, table: CircuitTable) -> None:
    symbols.pilot_check_valve(sheet, x, y, out)
    _pilot(sheet, x, y - 2.6, y - 10.0 + 0.9 * out, out)
    _beside(sheet, x + out * 7.5, y, out, [f"pilot check {table.name}", _ratio(table), _passes(table)])


def _hose_burst(sheet: Sheet, x: float, y: float, out: float, table: CircuitTable) -> None:
    bleed = table.number("bleed")
    symbols.hose_burst_valve(sheet, x, y, out, bool(bleed))
    labels = [
        f"hose burst {table.name}",
        stated("closes above {}", shown(table.number("closing-flow"), FLOW)),
        f"bleed {100.0 * bleed:.4g} %" if bleed else "",
        _passes(table),
    ]
    _beside(sheet, x + out * 9.0, y, out, labels)


def _hose(sheet: Sheet, x: float, y: float, out: float, table: CircuitTable) -> None:
    symbols.hose(sheet, x, y, out, narrow=table.number("nominal-flow") is not None)
    length = table.number("length")
    bore = stated(f"{length or 0.0:.4g} m × Ø {{}}", shown(table.number("inner-diameter"), LENGTH))
    widens = table.number("compliance")
    labels = [
        f"line {table.name}",
        bore or shown(table.number("volume"), VOLUME),
        f"{1e11 * widens:.4g} cm³/bar" if widens else "",
        _passes(table) or stated("walls at {}", shown(table.number("nominal-flow"), FLOW)),
    ]
    _beside(sheet, x + out * 4.0, y, out, labels)


def _hose_leak(sheet: Sheet, x: float, y: float, out: float, table: CircuitTable) -> None:
    symbols.leak(sheet, x, y, out)
    opening = table.number("opening")
    _beside(sheet, x + out * 9.0, y, out, [f"hose leak {table.name}", shown(opening, AREA) if opening else "tight"])


def _port_relief(sheet: Sheet, x: float, y: float, out: float, table: CircuitTable) -> None:
    aside = x + out * 12.0
    symbols.to_tank(sheet, x, y + 9.0, aside)
    symbols.relief_valve(sheet, aside, y + 0.5)
    labels = [f"port relief {table.name}", *_relief_labels(table)]
    _beside(sheet, aside + (12.0 if out > 0 else -9.0), y, out, labels)


def _crossover_relief(sheet: Sheet, x: float, y: float, out: float, table: CircuitTable) -> None:
    """From this line to the other one, between both."""
    inside, level = x - out * 12.0, y - 9.0 + 0.9 * out
    sheet.line((x, y + 9.0), (inside, y + 9.0), (inside, level), (-x, level))
    symbols.relief_valve(sheet, inside, y)
    sheet.dot(x, y + 9.0)
    sheet.dot(-x, level)
    _beside(sheet, x + out * 4.0, y, out, [f"cross-over relief {table.name}", *_relief_labels(table)])


def _relief_labels(table: CircuitTable) -> list[str]:
    flow, rise = shown(table.number("nominal-flow"), FLOW), shown(table.number("overpressure"), BAR)
    return [shown(table.number("setting"), BAR), stated("{} at + {}", flow, rise) or flow]


def _anti_cavitation(sheet: Sheet, x: float, y: float, out: float, table: CircuitTable) -> None:
    aside = x + out * 10.0
    symbols.to_tank(sheet, x, y + 9.0, aside)
    symbols.check_valve(sheet, aside, y + 1.0)
    opens = stated("opens at {}", shown(table.number("opening-pressure"), BAR))
    _beside(sheet, aside + out * 5.0, y, out, [f"anti-cavitation {table.name}", _passes(table), opens])


OnLine = Callable[[Sheet, float, float, float, CircuitTable], None]
ON_LINE: dict[str, OnLine] = {
    "line": _hose,
    "hose-leak": _hose_leak,
    "hose-burst": _hose_burst,
    "pilot-check": _pilot_check,
    "counterbalance": _counterbalance,
    "port-relief": _port_relief,
    "crossover-relief": _crossover_relief,
    "anti-cavitation": _anti_cavitation,
}


# --- labels of valve and cylinder -----------------------------------------------------------------------------------


def valve_labels(section: CircuitSection) -> list[str]:
    valve = section.valve
    drop = shown(valve.number("nominal-pressure-drop"), BAR)
    edge = shown(valve.number("nominal-edge-pressure-drop"), BAR) or (
        "" if drop else shown(valve.number("compensator-setting"), BAR)
    )
    flow = shown(valve.number("nominal-flow"), FLOW)
    overlap, ratios = shown(valve.number("overlap"), LENGTH), valve.numbers.get("return-area-ratio")
    return [
        f"valve {valve.name}, {valve.word('type')}",
        stated("{} at {}", flow, drop) or stated("{} at {} per edge", flow, edge),
        stated("stroke {}", shown(valve.number("stroke"), LENGTH)) + stated(", overlap {}", overlap),
        "" if ratios is None else f"edges to tank × {ratios[0]:.3g}, {ratios[1]:.3g}",
        "served first" if section.is_served_first else "",
    ]


def cylinder_labels(section: CircuitSection) -> list[str]:
    count = section.cylinder.number("count") or 1.0
    several = f"{count:g} × " if count > 1.0 else ""
    if section.motor.is_stated:
        taken, ratio = shown(section.motor.number("displacement"), VOLUME), section.motor.number("gear-ratio")
        return [section.cylinder.name, f"{several}motor {taken} per turn, gear {ratio:.4g} : 1"]
    bore, rod = section.cylinder.number("bore"), section.cylinder.number("rod-diameter")
    across = "" if bore is None or rod is None else f"Ø {1e3 * bore:.4g}/{1e3 * rod:.4g} mm, "
    return [section.cylinder.name, f"{several}{across}stroke {1e3 * section.stroke:.4g} mm"]

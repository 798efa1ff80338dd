"""The path of a command to the spool, which is not among the states of a machine."""

from __future__ import annotations

from dataclasses import dataclass

from hydrocrane.errors import InputError
from hydrocrane.machine.description import described
from hydrocrane.machine.machine import Machine
from hydrocrane.result_warning import ResultWarning


@dataclass(frozen=True)
class CommandPath:
    """The path of one cylinder: dead time of signal chain and valve together (s), and the effect of the chain on the
    value."""

    cylinder: str
    delay: float
    gain: float
    dead_band: float
    offset: float
    # Half width of the hysteresis, m.
    play: float

    @property
    def plain(self) -> bool:
        """Whether the value arrives unchanged."""
        return self.gain == 1.0 and self.dead_band == 0.0 and self.offset == 0.0 and self.play == 0.0


def command_paths(machine: Machine) -> list[CommandPath]:
    """The path of each cylinder's command."""
    found = []
    for record in described(machine.core).records("cylinders"):
        valve = record.record("valve")
        chain = valve.record("command")
        found.append(
            CommandPath(
                record.text("name"),
                valve.number("delay") + chain.number("delay"),
                chain.number("gain"),
                chain.number("dead_band"),
                chain.number("offset"),
                chain.number("play"),
            )
        )
    return found


def path_warnings(machine: Machine) -> tuple[ResultWarning, ...]:
    """Paths that change or delay a command: the model's inputs are commands that have arrived."""
    return tuple(
        ResultWarning(
            "command-path-left-out",
            f"the input is the command that arrives at the spool of {path.cylinder}; its path has a delay of "
            f"{path.delay * 1e3:g} ms, a gain of {path.gain:g}, a dead band of {path.dead_band * 1e3:g} mm, an "
            f"offset of {path.offset * 1e3:g} mm and a hysteresis of {2e3 * path.play:g} mm",
            "add the delay and the gain where the model is used",
        )
        for path in command_paths(machine)
        if path.delay or not path.plain
    )


def common_delay(machine: Machine) -> float:
    """Common delay of all commands, s, if nothing else changes them.

    Raises
    ------
    InputError
        If a signal chain changes the value of a command, or the delays differ.
    """
    paths = command_paths(machine)
    for path in paths:
        if not path.plain:
            raise InputError(
                f"the signal chain of {path.cylinder} has a gain, a dead band, an offset or a hysteresis, which "
                f"the loops do not model; take a machine file without [valve.<name>.command]"
            )
    if len({path.delay for path in paths}) > 1:
        delays = ", ".join(f"{path.cylinder} {path.delay * 1e3:g} ms" for path in paths)
        raise InputError(
            f"the commands of {machine.name} have different delays ({delays}); the loops need a common one"
        )
    return paths[0].delay

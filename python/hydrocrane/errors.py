"""One exception tree for all input errors.

Every exception derives from :class:`HydrocraneError`, which is a ``ValueError``; its text is one message that
states what is wrong, where, and the nearest valid choice.
"""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager

# Number of letters used to find the nearest name, as in the core.
LEAST_BEGINNING = 4


# Most letters of a message, because messages quote values of any length.
LONGEST_MESSAGE = 2000


class HydrocraneError(ValueError):
    """Base of all errors raised by this package; the middle of very long messages is left out.

    Examples
    --------
    >>> try:
    ...     hc.simulate("vertical-lift-open-loop", payload=-1.0)
    ... except hc.HydrocraneError as error:
    ...     print(type(error).__name__)
    InputError
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(shortened(printable(message)))


class InputError(HydrocraneError):
    """An argument has the wrong shape, is not finite, or names something that does not exist.

    Examples
    --------
    >>> try:
    ...     hc.load_machine("rottne-f9-lab").tip([0.0, 0.0])
    ... except hc.InputError as error:
    ...     print(error)
    q must have shape (3,) or (..., 3), one value each of boom, jib, extension; got shape (2,)
    """


class OutOfReachError(HydrocraneError):
    """A pose or stroke that the machine cannot reach.

    Examples
    --------
    >>> try:
    ...     hc.load_machine("rottne-f9-lab").joints_from_strokes([9.0, 0.0, 0.0])
    ... except hc.OutOfReachError as error:
    ...     print("no such stroke")
    no such stroke
    """


class SimulationError(HydrocraneError):
    """A simulation cannot continue from its state.

    Examples
    --------
    >>> try:
    ...     hc.Simulator("rottne-f9-lab").step([0.0, 0.0, 0.0])
    ... except hc.SimulationError as error:
    ...     print(error)
    call reset(q=...) or reset(state=...) before the first step
    """


class ResultFileError(HydrocraneError):
    """A file of results cannot be read or written.

    Examples
    --------
    >>> try:
    ...     hc.load_run("nowhere.nc")
    ... except hc.ResultFileError as error:
    ...     print("nothing there")
    nothing there
    """


class MachineFileError(HydrocraneError):
    """A machine or scenario file, or an override of one of its keys, is wrong.

    Attributes
    ----------
    slug : str
        Stable short name of the kind of mistake, for example ``unknown-key``.
    file, key : str or None
        Place of the mistake; ``file`` is ``None`` for an override.
    line, column : int or None
        Place in the file, counted from 1.

    Examples
    --------
    >>> try:
    ...     hc.load_machine("rottne-f9-lab", {"supply.presure": "100 bar"})
    ... except hc.MachineFileError as error:
    ...     print(error.slug, error.key)
    unknown-key supply.presure
    """

    def __init__(
        self,
        message: str,
        slug: str = "",
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
        key: str | None = None,
    ) -> None:
        super().__init__(message)
        self.slug, self.file, self.line, self.column, self.key = slug, file, line, column, key

    def __reduce__(self) -> tuple[type, tuple[str | int | None, ...]]:
        return type(self), (str(self), self.slug, self.file, self.line, self.column, self.key)


@contextmanager
def translated(kind: type[HydrocraneError] = InputError) -> Iterator[None]:
    """Turn an error of the compiled core into one of this tree; other ``ValueError``s become `kind`, and so does what
    the core cannot take."""
    from hydrocrane import _core

    try:
        yield
    except HydrocraneError:
        raise
    except _core.MachineFileError as error:
        raise MachineFileError(*error.args) from None
    except _core.PoseFault as error:
        raise OutOfReachError(str(error)) from None
    except (TypeError, UnicodeEncodeError) as error:
        message = _not_taken(error)
        if message is None:
            raise
        raise kind(message) from None
    except ValueError as error:
        raise kind(str(error)) from None


def _not_taken(error: BaseException) -> str | None:
    """What is wrong with an argument that cannot be passed to the core; None if the error is another one."""
    _, field, where = str(error).rpartition("failed to extract field ")
    cause = error
    while cause.__cause__ is not None:
        cause = cause.__cause__
    if isinstance(cause, UnicodeEncodeError):
        strange = ord(cause.object[cause.start])
        return f"`{cause.object}` is no text: U+{strange:04X} in it cannot become UTF-8; leave it out"
    return f"{where.partition('.')[2]}: {cause}" if field else None


def printable(text: str) -> str:
    """A text in which everything that would control a terminal, or cannot be shown, is written as its number."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in "\n\t" else ascii(c)[1:-1] for c in text)


def shortened(message: str) -> str:
    """A long message without the middle of its quotation; begin and end keep the error and the cure."""
    left_out = len(message) - LONGEST_MESSAGE
    if left_out <= 0:
        return message
    half = LONGEST_MESSAGE // 2
    return f"{message[:half]} ... ({left_out} letters left out) ... {message[-half:]}"


def nearest(name: str, known: Iterable[str]) -> str:
    """The nearest of the `known` names as text, ``; did you mean `x`?``, or the list of choices."""
    known = list(known)
    begun = [choice for choice in known if len(name) >= LEAST_BEGINNING and choice.startswith(name)]
    close = begun or difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    if close:
        return f"; did you mean `{close[0]}`?"
    return f"; choose from {', '.join(known)}" if known else ""


def check_known(what: str, name: object, known: Collection[str]) -> None:
    """Raises an :class:`InputError` for a name that is not among the `known` ones."""
    if name not in known:
        raise unknown(what, name, known)


def unknown(what: str, name: object, known: Iterable[str]) -> InputError:
    """An :class:`InputError` for a name that is not among the `known` ones."""
    return InputError(f"unknown {what} `{name}`{nearest(str(name), known)}")

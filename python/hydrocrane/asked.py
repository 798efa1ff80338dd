"""What a room does for objects of rooms to its left when asked: draw a result, linearise a machine.

The room says in its table ``ANSWERS`` where its functions stand, and is imported when it is first asked. So no result
imports what draws it, and no picture is paid for unseen.
"""

from __future__ import annotations

from importlib import import_module


def ask(room: str, what: str, *given: object, **options: object) -> object:
    """What the function that `room` has for `what` returns."""
    place = f"hydrocrane.{room}"
    module, _, function = import_module(place).ANSWERS[what].rpartition(".")
    answer: object = getattr(import_module(f"{place}.{module}"), function)(*given, **options)
    return answer

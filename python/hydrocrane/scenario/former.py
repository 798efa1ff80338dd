"""Former names of fields of scenarios: they are refused, with the present name."""

from __future__ import annotations

from functools import wraps
from typing import TypeVar

from hydrocrane.errors import InputError

C = TypeVar("C", bound=type)

# Former name -> present name.
RENAMED_FIELDS = {"believed": "controller_model"}


def refuses_former_names(cls: C) -> C:
    """A class decorator: a field by its former name raises an error that states the present one."""
    construct = cls.__init__  # type: ignore[misc]

    @wraps(construct)
    def checked(self: object, *args: object, **kwargs: object) -> None:
        for name in RENAMED_FIELDS.keys() & kwargs:
            refuse_former_name(name)
        construct(self, *args, **kwargs)

    cls.__init__ = checked  # type: ignore[misc]
    return cls


def refuse_former_name(field: str) -> None:
    """Raise the error if `field` is a former name.

    Raises
    ------
    InputError
    """
    if field in RENAMED_FIELDS:
        raise InputError(f"`{field}` is called `{RENAMED_FIELDS[field]}` now")

"""Operations of vector registers are instructions in the compiled module, not calls."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hydrocrane import _core

# Of numbers that are made or stored once; each costs no time in a law.
ONCE = {"set1", "loadu", "storeu"}


def operations(module: bytes) -> set[str]:
    """Operations of registers that are functions of their own in a module, by the names in its table of symbols."""
    names = re.findall(rb"core_arch[0-9a-zA-Z_.$]*?_mm(?:256|512)_(\w+?)_(?:pd|epi64|si256|si512)", module)
    return {name.decode() for name in names}


def test_no_arithmetic_of_registers_is_called_as_a_function():
    """A closure that is not inlined into code for AVX calls each of its operations, by way of memory."""
    file = _core.__file__
    assert file is not None
    module = Path(file).read_bytes()
    if b"hydrocrane_num" not in module:
        pytest.skip("this module carries no names of functions")
    assert operations(module) <= ONCE


def test_the_names_are_found():
    name = b"_RNvNtNtNtCsgEmfK2I1SDS_4core9core_arch3x863avx13__mm256_add_pd"
    assert operations(b"\0" + name + b"\0") == {"add"}

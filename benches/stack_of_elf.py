"""The deepest stack below functions of a Thumb program, by its disassembly: frames along the deepest path of calls."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

# Bytes that an instruction takes from the stack.
_REGISTERS = re.compile(r"\{(.*)\}")


def _pushed(registers: str, size: int) -> int:
    """Bytes of a list of registers such as ``r4, r5, lr`` or ``d8-d15``."""
    count = 0
    for part in registers.split(","):
        ends = re.findall(r"\d+", part)
        count += int(ends[1]) - int(ends[0]) + 1 if "-" in part and len(ends) == 2 else 1
    return size * count


def _taken(instruction: str, operands: str) -> int:
    listed = _REGISTERS.search(operands)
    if instruction.startswith("push") or (instruction.startswith("stmdb") and operands.startswith("sp!")):
        return _pushed(listed[1], 4) if listed else 0
    if instruction.startswith("vpush"):
        return _pushed(listed[1], 8 if "d" in listed[1] else 4) if listed else 0
    stored = re.search(r"\[sp, #-(\d+)\]!", operands)
    if instruction.startswith("str") and stored:
        return int(stored[1])
    lowered = re.fullmatch(r"sp, (?:sp, )?#(\d+|0x[0-9a-f]+)", operands)
    return int(lowered[1], 0) if instruction.startswith("sub") and lowered else 0


def disassembled(program: Path) -> tuple[dict[str, int], dict[str, set[str]], set[str]]:
    """Bytes of the frame and calls of each function, and the functions that call what a register holds."""
    command = ["llvm-objdump", "-d", "--no-show-raw-insn", str(program)]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    frames: dict[str, int] = {}
    calls: dict[str, set[str]] = {}
    indirect: set[str] = set()
    name = ""
    for line in text.splitlines():
        head = re.fullmatch(r"[0-9a-f]+ <(.+)>:", line)
        if head and not head[1].startswith("$"):
            name = head[1]
            frames[name], calls[name] = 0, set()
            continue
        code = re.match(r"\s*[0-9a-f]+:\s+(\S+)\s*(.*)", line)
        if not code or not name:
            continue
        instruction, operands = code[1], code[2].split("@")[0].strip()
        frames[name] += _taken(instruction, operands)
        target = re.search(r"<([^>+]+)(?:\+0x[0-9a-f]+)?>", code[2])
        if instruction.startswith("b") and target and target[1] != name and not target[1].startswith("$"):
            calls[name].add(target[1])
        if instruction.startswith("blx") and not target:
            indirect.add(name)
    return frames, calls, indirect


def deepest(program: Path, start: str) -> tuple[int, list[str]]:
    """Bytes of stack below `start`, and the functions on that path.

    Raises
    ------
    ValueError
        A recursion, or a call whose target the disassembly does not tell.
    """
    frames, calls, indirect = disassembled(program)
    known: dict[str, tuple[int, list[str]]] = {}

    def below(name: str, path: tuple[str, ...]) -> tuple[int, list[str]]:
        if name in path:
            raise ValueError(f"{name} calls itself: {path}")
        if name in indirect:
            raise ValueError(f"{name} calls what a register holds")
        if name not in known:
            under = [below(call, (*path, name)) for call in calls.get(name, ()) if call in frames]
            size, way = max(under, default=(0, []))
            known[name] = (size + frames[name], [name, *way])
        return known[name]

    return below(start, ())

"""Write what is declared of the keys of files: ``python docs/reference/keys.py``.

The tables of ``machine-file.md``, ``machine-file-circuit.md`` and ``scenario-file.md`` between their marks, and the
types of the cockpit in ``cockpit/src/file-keys.ts``.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from hydrocrane import _core

ROOT = Path(__file__).resolve().parents[2]
# Kind of file -> its pages.
PAGES = {
    kind: tuple(ROOT / f"docs/reference/{name}.md" for name in names)
    for kind, names in {"machine": ("machine-file", "machine-file-circuit"), "scenario": ("scenario-file",)}.items()
}
TYPES = ROOT / "cockpit/src/file-keys.ts"
# <!-- keys of machine: link --> ... <!-- keys: end -->
BLOCK = re.compile(r"(<!-- keys of (machine|scenario): ([^\n]*) -->\n).*?(<!-- keys: end -->)", re.DOTALL)
NAME = re.compile(r"<[^>]+>")
SIGNS = {"any": "", "zero or greater": " ≥ 0", "greater than zero": " > 0"}


@dataclass(frozen=True)
class Key:
    """A declared key, as the core lists it."""

    path: str
    form: str
    kinds: list[dict[str, str]]
    sign: str
    choices: list[str]
    defaults: list[str]
    otherwise: str
    usual: list[tuple[str, str]]
    means: str
    source: str
    description: str

    @property
    def holds_keys(self) -> bool:
        return self.form in ("table", "tables")


def declared(kind: str) -> list[Key]:
    """Every key of a kind of file, each table before its keys."""
    return [Key(**row) for row in json.loads(_core.key_list(kind))]


def below(path: str, keys: list[Key]) -> list[Key]:
    """The keys inside the table at `path`."""
    return [key for key in keys if key.path.startswith(f"{path}.")]


# --- the page ------------------------------------------------------------------------------------------------------


def value(key: Key) -> str:
    """What a key holds, in few words."""
    kinds = " or ".join(f"{kind['name']} ({kind['unit']})" if kind["unit"] else "number" for kind in key.kinds)
    quantity = (kinds or "quantity") + SIGNS[key.sign]
    choices = ", ".join(f"`{choice}`" for choice in key.choices)
    forms = {
        "quantity": quantity,
        "pair": f"pair: {quantity}",
        "series": f"list: {quantity}",
        "points": "list of points",
        "choice": choices,
        "texts": f"list of {choices or 'texts'}",
        "tables": "tables with names",
        "overrides": "keys with values",
    }
    return forms.get(key.form, key.form)


def meaning(key: Key) -> str:
    """The sentence, with where to read on."""
    if not key.source:
        return key.means
    source = f"[Theory](../{key.source})" if key.source.endswith(".md") else f"Source: {key.source}"
    return f"{key.means} {source}."


def default(key: Key) -> str:
    """What counts without the key."""
    words = [f"`{word}`" if key.form == "choice" else word for word in key.defaults]
    return ", ".join(words) or key.otherwise


def shown(paths: list[str], keys: list[Key]) -> Iterator[tuple[str, Key, str]]:
    """The keys of a block by the names it shows; keys of a table that stands twice are shown once."""
    tables: dict[tuple[str, ...], str] = {}
    hidden: list[str] = []
    for path in paths:
        (table,) = [key for key in keys if key.path == path]
        base = f"{path}.<name>." if table.form == "tables" else f"{path}."
        for key in [*([] if len(paths) == 1 and table.holds_keys else [table]), *below(path, keys)]:
            if any(key.path.startswith(f"{start}.") for start in hidden):
                continue
            name = key.path.removeprefix(base) if len(paths) == 1 else key.path
            inside = tuple(one.description for one in below(key.path, keys))
            same = tables.setdefault(inside, key.path) if key.holds_keys and inside else key.path
            if same != key.path:
                hidden.append(key.path)
            yield name, key, f" Keys as in `{same}`." if same != key.path else ""


def table(keys: list[Key], paths: list[str]) -> str:
    """The table of a block."""
    rows = [
        (
            f"`{name}`",
            meaning(key) + more,
            value(key),
            ", ".join(f"{low} to {high}" for low, high in key.usual),
            default(key),
        )
        for name, key, more in shown(paths, keys)
    ]
    head = ("key", "meaning", "value", "usual", "default")
    columns = [i for i in range(len(head)) if any(row[i] for row in rows)]
    lines = [head, ("---",) * len(head), *rows]
    return "".join("| " + " | ".join(line[i] for i in columns) + " |\n" for line in lines)


def page(kind: str, path: Path) -> str:
    """A page of a kind of file with its tables brought up to date; every key must have a place on one of the pages."""
    texts = {one: one.read_text(encoding="utf-8") for one in PAGES[kind]}
    blocks = [paths.split(", ") for text in texts.values() for _, _, paths, _ in BLOCK.findall(text)]
    missing = {key.path.split(".")[0] for key in declared(kind)} - {one for paths in blocks for one in paths}
    if missing:
        raise SystemExit(f"{PAGES[kind][0].name} has no place for the keys {sorted(missing)}")

    def written(match: re.Match[str]) -> str:
        begin, _, paths, end = match.groups()
        own = paths.split(", ")
        # Tables inside these that have a block of their own.
        inner = [p for others in blocks for p in others if any(p.startswith(f"{one}.") for one in own)]
        keys = [key for key in declared(kind) if not any(key.path.startswith(f"{path}.") for path in inner)]
        return f"{begin}\n{table(keys, own)}\n{end}"

    return BLOCK.sub(written, texts[path])


# --- the types of the cockpit --------------------------------------------------------------------------------------

HEAD = """\
/** Words of machine and scenario files. Written by docs/reference/keys.py from their declarations; do not edit. */
"""


def union(name: str, about: str, members: list[str]) -> str:
    """A type that is one of some texts; a name in angle brackets stands for any text."""
    any_name = [f"`{NAME.sub('${string}', one)}`" if "<" in one else json.dumps(one) for one in members]
    lines = "".join(f"\n  | {member}" for member in any_name)
    return f"\n/** {about} */\nexport type {name} ={lines};\n"


def types() -> str:
    """The types as text."""
    # A machine takes what it extends from its file alone.
    values = [
        key.path
        for key in declared("machine")
        if not key.holds_keys and key.path not in ("extends", "include", "without")
    ]
    (controller,) = [key for key in declared("scenario") if key.path == "controller.name"]
    return (
        HEAD
        + union("Controller", controller.means, controller.choices)
        + union("MachineKey", "Keys of a machine that can be overridden.", values)
    )


FILES: dict[Path, Callable[[], str]] = {
    path: partial(page, kind, path) for kind, paths in PAGES.items() for path in paths
} | {TYPES: types}

if __name__ == "__main__":
    for path, text in FILES.items():
        path.write_text(text(), encoding="utf-8")

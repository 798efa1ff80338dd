"""C99: one file without heap, with the bits of the core, or with the platform's elementary functions."""

from __future__ import annotations

from pathlib import Path

from hydrocrane._core_types import FunctionEntry
from hydrocrane.export.tape import ARITHMETIC, Language, Tape, calls, head, names, wrapped

# An operation of C alone.
_OVER = "divide by a constant"
C = Language(
    {
        **ARITHMETIC,
        _OVER: "hydrocrane_over({0}, {1})",
        **calls("", root="sqrt", magnitude="fabs"),
        **calls("hydrocrane_", exp="exp", ln="ln", sin="sin", cos="cos", tanh="tanh"),
        "positive": "{0} < 0.0 ? 0.0 : {0}",
        "and": "{0} & {1}",
        "or": "{0} | {1}",
        "not": "!{0}",
        "select": "{0} ? {1} : {2}",
        "place": "hydrocrane_place(starts_{0}, (int)(sizeof starts_{0} / sizeof *starts_{0}), {1})",
        "entry": "column_{0}_{1}[{2}]",
    },
    infinity="INFINITY",
    nan="NAN",
)
_TYPES = {"m": "int", "i": "int", "t": "double"}
_FILES = Path(__file__).parent
_LINKAGE = """\
#ifdef __cplusplus
extern "C" {
#endif"""


def c_text(tape: Tape) -> str:
    """The file."""
    arguments = "const double *x, const double *u, const double *p"
    declared = [
        f"int hydrocrane_derivative({arguments}, double *dx);",
        f"int hydrocrane_linearise({arguments}, double *dx, double *dfdx);",
        f"int hydrocrane_sparse({arguments}, double *dx, double *values);",
        f"int hydrocrane_outputs({arguments}, double *y);",
    ]
    if not tape.places:
        del declared[1:3]
    about = (_FILES / "c_contract.txt").read_text(encoding="utf-8").rstrip()
    return "\n".join(
        [
            comment(head(tape), about),
            sizes(tape),
            f"{_LINKAGE}\n",
            *declared,
            "extern const char *const hydrocrane_states[], *const hydrocrane_inputs[];",
            "extern const char *const hydrocrane_parameters[], *const hydrocrane_output_names[];",
            "extern const double hydrocrane_values[];",
            *(["extern const int hydrocrane_columns[], hydrocrane_rows[];"] if tape.places else []),
            "#ifdef __cplusplus\n}\n#endif\n",
            "#ifndef HYDROCRANE_DECLARATIONS",
            (_FILES / "elementary.c").read_text(encoding="utf-8"),
            bodies(tape),
            name_tables(tape),
            public(tape),
            "#endif\n",
        ]
    )


def comment(lines: list[str], about: str = "") -> str:
    """Lines as a comment of C, which nothing in them ends or begins anew."""
    texts = [line.replace("*/", "* /").replace("/*", "/ *") for line in [*lines, "", *about.splitlines()]]
    return "/* " + "\n".join(f" * {line}".rstrip() for line in texts)[3:] + "\n */"


def sizes(tape: Tape) -> str:
    """Numbers of states, spool commands, parameters, outputs and derivatives, as macros."""
    counts = {
        "STATES": tape.states,
        "INPUTS": tape.commands,
        "PARAMETERS": tape.parameters,
        "OUTPUTS": tape.outputs,
        "NONZEROS": tape.places,
    }
    return "\n".join(f"#define HYDROCRANE_{name} {len(items)}" for name, items in counts.items())


def bodies(tape: Tape) -> str:
    """Tables and functions without the contract's names."""
    texts = []
    for i, (starts, columns) in enumerate(tape.tables):
        for name, column in [(f"starts_{i}", starts), *((f"column_{i}_{k}", own) for k, own in enumerate(columns))]:
            texts.append(f"HYDROCRANE_TABLE {name}[] = {{{wrapped([repr(value) for value in column])}}};")
    if tape.kept:
        texts.append(f"HYDROCRANE_TABLE file_values[] = {{\n    {wrapped([repr(value) for value in tape.kept])}}};")
        kept = [f"c[{i}]" for i in range(len(tape.kept))]
        texts.append(_function("prologue", {"p": len(tape.parameters)}, kept, tape.prologue))
    counts = {"x": len(tape.states), "u": len(tape.commands), "c": len(tape.kept)}
    n = len(tape.states)
    rates = [f"dx[{i}]" for i in range(n)]
    texts.append(_function("derivative", counts, rates, tape.derivative))
    if tape.places:
        slopes = [f"values[{k}]" for k in range(len(tape.places))]
        texts.append(_function("linearised", counts, [*rates, *slopes], tape.linearise))
    texts.append(_function("outputs", counts, [f"y[{i}]" for i in range(len(tape.outputs))], tape.output))
    return "\n".join(texts)


def _function(name: str, given: dict[str, int], results: list[str], function: FunctionEntry) -> str:
    """A function of arrays of so many numbers each, by their letters, that writes `results`."""
    # Without outputs the array is not used.
    written = dict.fromkeys(result.partition("[")[0] for result in results) or {"y": None}
    arguments = [f"const double *restrict {letter}" for letter in given] + [f"double *restrict {y}" for y in written]
    lines = [f"HYDROCRANE_FUNCTION void {name}({', '.join(arguments)})", "{"]
    lines += [f"    (void){argument};" for argument in [*given, *([] if results else written)]]
    # Inputs are read where they are needed first and results written where they are known: few numbers to keep.
    unread = {f"{letter}{i}": f"{letter}[{i}]" for letter, count in given.items() for i in range(count)}
    unwritten: dict[str, list[str]] = {}
    for result, source in zip(results, function[1], strict=True):
        unwritten.setdefault(source, []).append(result)

    def read(names: list[str]) -> None:
        lines.extend(f"    const double {name} = {unread.pop(name)};" for name in names if name in unread)

    own = _over_constants(function)
    for (name, text), (_, _, operands) in zip(C.steps(own), own[0], strict=True):
        read(operands)
        lines.append(f"    const {_TYPES[name[0]]} {name} = {text};")
        lines.extend(f"    {result} = {name};" for result in unwritten.pop(name, []))
    read(list(unwritten))
    lines += [f"    {result} = {C.spelt(source)};" for source, places in unwritten.items() for result in places]
    return "\n".join([*lines, "}\n"])


def _over_constants(function: FunctionEntry) -> FunctionEntry:
    """The same with divisions by constants as an operation of their own."""

    def operation(name: str, operands: list[str]) -> str:
        return _OVER if name == "divide" and operands[1][0] in "-0123456789" else name

    return [(result, operation(name, operands), operands) for result, name, operands in function[0]], function[1]


def name_tables(tape: Tape) -> str:
    """Names, values and places as arrays; each has an entry more than it needs, since C has no empty ones."""

    def texts(name: str, items: list[str]) -> str:
        quoted = [f'"{item}"' for item in items] + ["0"]
        return f"const char *const {name}[] = {{\n    {wrapped(quoted)}}};"

    lines = [
        texts("hydrocrane_states", names(tape.states)),
        texts("hydrocrane_inputs", names(tape.commands)),
        texts("hydrocrane_parameters", names(tape.parameters)),
        texts("hydrocrane_output_names", names(tape.outputs)),
        f"const double hydrocrane_values[] = {{{wrapped([*map(repr, tape.values), '0.0'])}}};",
    ]
    if tape.places:
        n = len(tape.states)
        starts = [sum(column < i for _, column in tape.places) for i in range(n + 1)]
        integers = {
            "const int hydrocrane_columns": starts,
            "const int hydrocrane_rows": [row for row, _ in tape.places],
            "static const int in_dense": [row * n + column for row, column in tape.places],
        }
        lines += [f"{name}[] = {{{wrapped([*map(str, items)])}}};" for name, items in integers.items()]
    return "\n".join(lines) + "\n"


def public(tape: Tape) -> str:
    """The functions of the contract."""
    text = (_FILES / "c_public.c").read_text(encoding="utf-8")
    begin, derivatives = text.split("/* ---- */\n")
    prepared = "double own[1]; const double *c = own; (void)p; own[0] = 0.0;"
    if tape.kept:
        prepared = (
            f"double own[{len(tape.kept)}]; const double *c = file_values; if (p) {{ prologue(p, own); c = own; }}"
        )
    return (begin + (derivatives if tape.places else "")).replace("PREPARE", prepared)

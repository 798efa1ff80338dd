"""The house stands as ARCHITECTURE.md says: who imports whom, what lies where, how long a file may be."""

from __future__ import annotations

import ast
import graphlib
import importlib
import re
import subprocess
import sys
import tomllib
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PHYSICS = ROOT / "crates/physics/src"
PACKAGE = ROOT / "python/hydrocrane"
LONGEST = 600
# Most files of a folder of the product. In these folders a file is one law, or one table of a machine file.
FULLEST = 14
ONE_BY_ONE = {"crates/physics/src/hydraulics", "crates/machine/src/sections"}

# Each crate and what it may use of the others.
MAY_USE = {
    "num": set(),
    "logs": set(),
    "machine": {"num", "logs"},
    "ode": {"num"},
    "physics": {"num"},
    "plant": {"num", "ode", "machine", "physics"},
    "control": {"num", "physics"},
    "lanes": {"num", "ode", "plant"},
    "tape": {"num", "machine", "plant"},
    "sim": {"num", "ode", "machine", "physics", "plant", "lanes", "control"},
    "web": {"machine", "ode", "sim"},
    "evidence": {"num", "ode", "machine", "sim", "web"},
    "fmu": {"machine", "ode", "sim"},
    "fmi": {"fmu"},
    "embedded": {"physics", "control"},
    "python": {"logs", "machine", "ode", "sim", "fmu", "tape"},
}

# Each room of the Python package, and each module beside the rooms, with what it may use of the others. They stand from
# left to right: what a room may use stands before it.
BASE = {"_core_types", "asked", "errors", "arrays", "result_warning", "units", "notebook"}
ROOMS = {
    "_core_types": set(),
    "asked": set(),
    "errors": set(),
    "arrays": {"errors"},
    "result_warning": set(),
    "notebook": set(),
    "units": {"errors"},
    "files": BASE,
    "logs": BASE | {"files"},
    "state_space": BASE | {"files"},
    "machine": BASE | {"state_space"},
    "control": BASE | {"logs", "machine"},
    "scenario": BASE | {"files", "logs", "machine", "control"},
    "results": BASE | {"files", "logs", "machine", "control", "scenario"},
    "simulation": BASE | {"machine", "control", "scenario", "results"},
    "analysis": BASE | {"state_space", "machine", "scenario", "results", "simulation"},
    "linear": BASE | {"state_space", "machine", "control", "analysis"},
    "benchmark": BASE | {"files", "machine", "control", "scenario", "results", "simulation"},
    "rig": BASE | {"logs", "machine", "scenario", "results", "simulation"},
    "signals": BASE | {"logs", "machine"},
    "identification": BASE
    | {"files", "logs", "machine", "scenario", "results", "simulation", "analysis", "rig", "signals"},
    "studies": BASE | {"files", "machine", "scenario", "results", "simulation"},
    "gym": BASE | {"machine", "simulation", "studies"},
    "export": BASE | {"files", "machine", "control", "scenario"},
    "plots": BASE
    | {"files", "state_space", "machine", "results", "analysis", "linear", "benchmark"}
    | {"signals", "identification"},
}  # fmt: skip
# The app imports every room and is imported by none.
APP = {"app", "__main__", "__init__"}


def source_files(folder: str, suffix: str) -> list[Path]:
    return [p for p in sorted((ROOT / folder).rglob(f"*{suffix}")) if "target" not in p.relative_to(ROOT).parts]


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def without_tests(text: str) -> str:
    return text.split("#[cfg(test)]")[0]


def without_comments(text: str) -> str:
    return re.sub(r"//.*", "", text)


SERVING = ("mod.rs", "lib.rs", "parameters.rs", "parts.rs", "edge_flows.rs", "planar.rs", "space.rs")


def laws() -> list[Path]:
    """Files of the physics crate that hold a law: their head names a theory page. The others serve several laws."""
    return [p for p in sorted(PHYSICS.rglob("*.rs")) if p.name not in SERVING]


# --- crates ---------------------------------------------------------------------------------------------------------


def test_crates_use_only_what_stands_left_of_them():
    crates = {p.parent.name: tomllib.loads(p.read_text(encoding="utf-8")) for p in ROOT.glob("crates/*/Cargo.toml")}
    assert set(crates) == set(MAY_USE)
    for name, manifest in crates.items():
        own = {d.removeprefix("hydrocrane-") for d in manifest["dependencies"] if d.startswith("hydrocrane-")}
        assert own <= MAY_USE[name], f"{name} uses {own - MAY_USE[name]}"


@pytest.mark.parametrize("crate", ["num", "ode", "physics", "control"])
def test_numerics_need_no_other_library(crate):
    """The laws are plain arithmetic: what they use of others is at most an error type, portable functions, lists
    without a heap and a checksum."""
    manifest = tomllib.loads((ROOT / f"crates/{crate}/Cargo.toml").read_text(encoding="utf-8"))
    others = {d for d in manifest["dependencies"] if not d.startswith("hydrocrane-")}
    assert others <= {"thiserror", "libm", "arrayvec", "crc"}


def test_the_core_neither_prints_nor_reads_files():
    """Only the description crate opens files; nothing prints."""
    for crate in ("num", "logs", "ode", "physics", "plant", "lanes", "control", "sim"):
        for path in source_files(f"crates/{crate}/src", ".rs"):
            code = without_comments(path.read_text(encoding="utf-8"))
            assert not re.search(r"std::fs|std::net|println!|eprintln!|dbg!", code), name_of(path)


# --- laws -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", laws(), ids=name_of)
def test_a_law_has_its_theory_page(path):
    """docs/theory mirrors the crate, and the file's head names the page."""
    page = f"docs/theory/{path.relative_to(PHYSICS).with_suffix('.md').as_posix()}"
    assert (ROOT / page).is_file(), page
    head = path.read_text(encoding="utf-8")[:400]
    assert f"theory: {page}" in head or page in head, f"{name_of(path)} does not name {page}"


def test_theory_pages_and_code_name_each_other():
    """Every page of a law names a source file that exists, and every page named in a source exists."""
    for page in (ROOT / "docs/theory").rglob("*.md"):
        if page.name != "README.md":
            code = re.search(r"^Code: `([^`]+)`", page.read_text(encoding="utf-8"), re.MULTILINE)
            assert code and (ROOT / code[1]).exists(), name_of(page)
    for path in source_files("crates", ".rs"):
        for page in re.findall(r"docs/[\w/.-]+\.md", path.read_text(encoding="utf-8")):
            assert (ROOT / page).is_file(), f"{name_of(path)} names {page}"


@pytest.mark.parametrize("path", laws(), ids=name_of)
def test_a_law_cites_its_source(path):
    text = path.read_text(encoding="utf-8")
    assert re.search(r"thesis \(\d|[A-Z][a-z]+ \((19|20)\d\d\)", text) or path.name == "end_stop.rs"


# Powers and fused products differ between platforms and number types; the smooth functions replace them.
FORBIDDEN = re.compile(r"\.powf\(|\.mul_add\(|\.signum\(|\bunsafe\b|\bVec<|\bvec!|Box<|\.to_vec\(|println!|std::fs")
# Tables are made once, before any run.
MAKES_TABLES = {"fluid.rs"}
# Roots that are kept away from zero where they stand, and magnitudes that the source's own law takes.
ROOTS = {"four_bar.rs": 1, "hose_leak.rs": 1, "line.rs": 3, "orifice.rs": 3}


@pytest.mark.parametrize("path", sorted(PHYSICS.rglob("*.rs")), ids=name_of)
def test_laws_are_plain_arithmetic(path):
    """No allocation, no platform-dependent powers, no sign function with a jump; `f64` helpers stand apart."""
    code = without_comments(without_tests(path.read_text(encoding="utf-8")))
    found = FORBIDDEN.findall(code)
    if path.name in MAKES_TABLES:
        found = [f for f in found if f not in ("Vec<", ".signum(")]
    assert not found, f"{name_of(path)}: {found}"


@pytest.mark.parametrize("path", sorted(PHYSICS.rglob("*.rs")), ids=name_of)
def test_roots_are_taken_by_the_smooth_functions(path):
    """A bare root has an infinite slope at zero; each one that stands in a law is listed here."""
    code = without_comments(without_tests(path.read_text(encoding="utf-8")))
    assert code.count(".sqrt()") == ROOTS.get(path.name, 0), name_of(path)


# Methods of `f64` that call the platform's library, whose last bit differs between platforms.
PLATFORM = "acos|asin|atan|atan2|cbrt|cos|cosh|exp_m1|hypot|ln_1p|log|log10|log2|powf|sinh|tan"
# These are methods of `Real` too: on a number that is certainly an `f64` they must not be called.
AMBIGUOUS = "exp|ln|sin|cos|sin_cos|tanh"
# Crates and files whose numbers are all `f64`, and the second, independent right-hand side, which is a test's oracle.
PLAIN = ("crates/machine/", "crates/control/", "crates/web/")
ORACLES = {f"crates/plant/src/reference{file}.rs" for file in ("", "/laws", "/space", "/supply")}


def test_runs_have_the_same_bits_on_every_platform():
    """Elementary functions come from `hydrocrane_num`, or from `libm`, never from the platform."""
    for crate in ("num", "logs", "ode", "physics", "machine", "plant", "lanes", "control", "sim", "web"):
        for path in source_files(f"crates/{crate}/src", ".rs"):
            if name_of(path) in ORACLES or path.name.endswith("_tests.rs"):
                continue
            code = without_comments(without_tests(path.read_text(encoding="utf-8")))
            methods = f"{PLATFORM}|{AMBIGUOUS}" if name_of(path).startswith(PLAIN) else PLATFORM
            found = re.findall(rf"\.(?:{methods})\(", code)
            assert not found, f"{name_of(path)}: {found}"


# --- Python ---------------------------------------------------------------------------------------------------------


def module_name(path: Path) -> str:
    return ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")


MODULES = {module_name(path): path for path in PACKAGE.rglob("*.py")}


def module_of(name: str) -> str:
    """The module of the package that holds a dotted name."""
    while name not in MODULES:
        name = name.rpartition(".")[0]
    return name


def package_imports(path: Path) -> set[str]:
    """Modules of the package that a file imports: at its head, inside functions, and for type checkers."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name_of(path)} imports relatively"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    # The package itself is imported for its version and the compiled core alone.
    own = {name for name in names if name.startswith("hydrocrane.")}
    found = {name for name in own if module_of(name) != "hydrocrane"}
    assert own - found <= {"hydrocrane._core", "hydrocrane.__version__"}, name_of(path)
    return {module_of(name) for name in found}


IMPORTS = {module: package_imports(path) for module, path in MODULES.items()}


def room_of(module: str) -> str:
    return module.split(".")[1] if "." in module else "__init__"


def test_modules_of_the_package_import_each_other_in_no_circle():
    """Imports inside functions and for type checkers count as well."""
    sorter = graphlib.TopologicalSorter({m: {i for i in found if i != m} for m, found in IMPORTS.items()})
    try:
        sorter.prepare()
    except graphlib.CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


def test_rooms_import_only_what_stands_left_of_them():
    left: set[str] = set()
    for room, allowed in ROOMS.items():
        assert allowed <= left, f"{room} may use {allowed - left}, which stands right of it"
        left.add(room)
    assert {room_of(module) for module in MODULES} == set(ROOMS) | APP
    for module, imports in IMPORTS.items():
        room = room_of(module)
        if room not in APP:
            used = {room_of(name) for name in imports} - {room}
            assert used <= ROOMS[room], f"{module} uses {used - ROOMS[room]}"


def test_rooms_answer_what_they_are_asked():
    asked = set()
    for path in MODULES.values():
        asked |= set(re.findall(r'\bask\("([\w-]+)", "([\w-]+)"', path.read_text(encoding="utf-8")))
    rooms = {room for room, _ in asked}
    answers = {room: importlib.import_module(f"hydrocrane.{room}").ANSWERS for room in rooms}
    assert asked == {(room, what) for room, table in answers.items() for what in table}
    for room, table in answers.items():
        for place in table.values():
            module, _, function = place.rpartition(".")
            assert callable(getattr(importlib.import_module(f"hydrocrane.{room}.{module}"), function))


def test_rooms_are_listed_in_the_architecture():
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    for room in (r for r in ROOMS if (PACKAGE / r).is_dir()):
        assert f"| `python/hydrocrane/{room}` |" in text, room


def test_the_stub_of_the_package_names_what_the_package_has():
    """Type checkers read `__init__.pyi`, programs the table in `__init__.py`."""
    import hydrocrane

    stub = ast.parse((PACKAGE / "__init__.pyi").read_text(encoding="utf-8"))
    said = {}
    for node in stub.body:
        if isinstance(node, ast.ImportFrom):
            assert all(alias.asname == alias.name for alias in node.names)
            said |= {alias.name: node.module for alias in node.names}
    assert said == {
        **{name: f"hydrocrane.{home}" for name, home in hydrocrane._HOME.items()},
        **dict.fromkeys(hydrocrane._ROOMS, "hydrocrane"),
    }


def imported_at_top(path: Path) -> set[str]:
    """Modules that a file imports when it is imported itself; those for type checkers do not count."""
    names = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module or "")
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def test_only_the_app_imports_the_app_and_only_plots_import_matplotlib():
    for path in PACKAGE.rglob("*.py"):
        room = path.relative_to(PACKAGE).parts[0]
        names = imported_at_top(path)
        if room not in ("app", "__main__.py"):
            assert not any(name.startswith("hydrocrane.app") for name in names), name_of(path)
        if room != "plots":
            assert not any(name.startswith(("matplotlib", "hydrocrane.plots")) for name in names), name_of(path)


def modules_after(code: str) -> set[str]:
    """Modules in memory after `code` in a fresh interpreter."""
    script = f"import sys\n{code}\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines()[-1].split())


HEAVY = {"matplotlib", "xarray", "scipy", "pandas", "h5netcdf", "PIL"}


def test_import_costs_next_to_nothing():
    assert not modules_after("import hydrocrane") & (HEAVY | {"numpy", "typer"})


def test_a_machine_needs_neither_plots_nor_results():
    assert not modules_after("import hydrocrane as hc; hc.load_machine('rottne-f9-lab').tip([1.7, 1.7, 0])") & HEAVY


def test_a_run_with_its_files_and_charts_needs_no_labels(tmp_path):
    """xarray brings pandas along, and Dask with much of SciPy where it is there: longer to import than all the rest."""
    arguments = ["simulate", "vertical-lift-open-loop", "--duration", "0.1", "--film", "none", "-o", str(tmp_path)]
    code = f"from hydrocrane.app.cli import main\ntry:\n    main({arguments})\nexcept SystemExit:\n    pass"
    loaded = modules_after(code)
    assert {path.suffix for path in tmp_path.iterdir()} == {".nc", ".png"}
    assert not loaded & {"xarray", "pandas", "dask", "scipy", "h5netcdf"}


def test_help_of_the_command_line_loads_nothing_heavy():
    code = "from hydrocrane.app.cli import main\ntry:\n    main(['--help'])\nexcept SystemExit:\n    pass"
    assert not modules_after(code) & (HEAVY | {"numpy"})


# --- types ----------------------------------------------------------------------------------------------------------


def said_of_nothing(annotation: ast.expr | None) -> bool:
    """Whether an annotation is `Any`, as a whole or in a part that is said of no library's type."""
    if annotation is None:
        return False
    if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str):
        annotation = ast.parse(annotation.value, mode="eval").body
    # `zarr.Array` must be said to be of something.
    inside = [n for n in ast.walk(annotation) if isinstance(n, ast.Subscript) and ast.unparse(n) == "zarr.Array[Any]"]
    names = [n for n in ast.walk(annotation) if isinstance(n, ast.Name) and n.id == "Any"]
    return len(names) > len(inside)


@pytest.mark.parametrize("path", [*MODULES.values(), *PACKAGE.glob("*.pyi")], ids=name_of)
def test_no_signature_says_any(path):
    """What may be anything is an `object`, which the type checker lets nobody use before it is looked at."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            given = node.args
            every = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]
            annotations = [argument.annotation for argument in every if argument is not None] + [node.returns]
            assert not any(said_of_nothing(annotation) for annotation in annotations), f"{name_of(path)}: {node.name}"
        if isinstance(node, ast.ClassDef):
            fields = [entry.annotation for entry in node.body if isinstance(entry, ast.AnnAssign)]
            assert not any(said_of_nothing(annotation) for annotation in fields), f"{name_of(path)}: {node.name}"


def test_what_can_be_changed_of_a_scenario_is_what_it_has():
    """Type checkers know the keywords of `Scenario.changed` from a table of their own."""
    import dataclasses

    from hydrocrane.scenario import Scenario, Solver, changes

    fields, settings = ({f.name for f in dataclasses.fields(kind)} for kind in (Scenario, Solver))
    assert set(changes.ScenarioFields.__annotations__) == fields
    assert set(changes.SolverFields.__annotations__) == settings
    assert set(changes.RunChanges.__annotations__) == (fields | settings) - {"machine"}


# A struct, a class of data or a class that its constructor fills: more values than this belong in groups with names.
MOST_FIELDS = 20
STRUCT = re.compile(r"^([ \t]*)(?:pub(?:\([^)]*\))? )?struct (\w+)[^;{(]*\{\n(.*?)^\1\}", re.MULTILINE | re.DOTALL)
FIELD = re.compile(r"^\s*(?:pub(?:\([^)]*\))? )?(?:r#)?\w+:\s", re.MULTILINE)


def fields_of(node: ast.ClassDef) -> int:
    """Annotated fields of a class, and attributes that its methods set."""
    stated = {entry.target.id for entry in node.body
              if isinstance(entry, ast.AnnAssign) and isinstance(entry.target, ast.Name)}  # fmt: skip
    stores = [at for at in ast.walk(node) if isinstance(at, ast.Attribute) and isinstance(at.ctx, ast.Store)]
    return len(stated | {at.attr for at in stores if isinstance(at.value, ast.Name) and at.value.id == "self"})


def test_no_struct_has_many_fields():
    counts = {}
    for path in source_files("crates", ".rs"):
        for _, name, body in STRUCT.findall(without_comments(path.read_text(encoding="utf-8"))):
            counts[f"{name_of(path)}: {name}"] = len(FIELD.findall(body))
    for path in source_files("python/hydrocrane", ".py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                counts[f"{name_of(path)}: {node.name}"] = fields_of(node)
    assert len(counts) > 800, "the search finds structs and classes"
    assert not {place: count for place, count in counts.items() if count > MOST_FIELDS}


def test_a_class_has_its_name_for_itself():
    """No two files have a class of the same name, so that a name in a message, a page or a search means one thing."""
    places: dict[str, list[str]] = {}
    for path in source_files("python/hydrocrane", ".py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name, []).append(name_of(path))
    assert not {name: found for name, found in places.items() if len(found) > 1}


# --- sizes, words ---------------------------------------------------------------------------------------------------


def own_files() -> list[Path]:
    folders = [("crates", ".rs"), ("python", ".py"), ("tests", ".py"), ("reproductions", ".py"), ("benches", ".py"),
               ("docs", ".py"), ("docs", ".md"), ("cockpit/src", ".ts"), ("machines", ".toml"),
               ("scenarios", ".toml")]  # fmt: skip
    return [p for folder, suffix in folders for p in source_files(folder, suffix)] + sorted(ROOT.glob("*.md"))


@pytest.mark.parametrize("path", own_files(), ids=name_of)
def test_no_file_is_long(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST


def test_no_folder_is_crowded():
    files = [*ROOT.glob("crates/*/src/**/*.rs"), *PACKAGE.rglob("*.py")]
    folders = Counter(name_of(path.parent) for path in files)
    assert not {folder: count for folder, count in folders.items() if count > FULLEST and folder not in ONE_BY_ONE}
    assert all(folders[folder] > FULLEST for folder in ONE_BY_ONE)


@pytest.mark.parametrize("path", own_files(), ids=name_of)
def test_nothing_is_left_undone(path):
    """No marks of unfinished work; this file names them, so it is exempt."""
    if path != Path(__file__).resolve():
        assert not re.search(r"\b(TODO|FIXME|XXX|HACK)\b|todo!\(|unimplemented!\(", path.read_text(encoding="utf-8"))

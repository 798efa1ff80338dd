"""The house stands as ARCHITECTURE.md says: who imports whom, what lies where, how long a file may be."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PHYSICS = ROOT / "crates/physics/src"
PACKAGE = ROOT / "python/hydrocrane"
LONGEST = 600

# Each crate and what it may use of the others.
MAY_USE = {
    "num": set(),
    "machine": set(),
    "ode": {"num"},
    "physics": {"num"},
    "plant": {"num", "ode", "machine", "physics"},
    "control": {"num", "physics"},
    "sim": {"num", "ode", "machine", "physics", "plant", "control"},
    "web": {"machine", "ode", "sim"},
    "evidence": {"num", "ode", "machine", "sim", "web"},
    "python": {"machine", "ode", "sim"},
}


def source_files(folder: str, suffix: str) -> list[Path]:
    return [p for p in sorted((ROOT / folder).rglob(f"*{suffix}")) if "target" not in p.relative_to(ROOT).parts]


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def without_tests(text: str) -> str:
    return text.split("#[cfg(test)]")[0]


def without_comments(text: str) -> str:
    return re.sub(r"//.*", "", text)


def laws() -> list[Path]:
    """Files of the physics crate that hold a law: their head names a theory page."""
    return [p for p in sorted(PHYSICS.rglob("*.rs")) if p.name not in ("mod.rs", "lib.rs", "parameters.rs")]


# --- crates ---------------------------------------------------------------------------------------------------------


def test_crates_use_only_what_stands_left_of_them():
    crates = {p.parent.name: tomllib.loads(p.read_text(encoding="utf-8")) for p in ROOT.glob("crates/*/Cargo.toml")}
    assert set(crates) == set(MAY_USE)
    for name, manifest in crates.items():
        own = {d.removeprefix("hydrocrane-") for d in manifest["dependencies"] if d.startswith("hydrocrane-")}
        assert own <= MAY_USE[name], f"{name} uses {own - MAY_USE[name]}"


@pytest.mark.parametrize("crate", ["num", "ode", "physics", "control"])
def test_numerics_need_no_other_library(crate):
    """The laws are plain arithmetic: what they use of others is at most an error type and portable functions."""
    manifest = tomllib.loads((ROOT / f"crates/{crate}/Cargo.toml").read_text(encoding="utf-8"))
    assert {d for d in manifest["dependencies"] if not d.startswith("hydrocrane-")} <= {"thiserror", "libm"}


def test_the_core_neither_prints_nor_reads_files():
    """Only the description crate opens files; nothing prints."""
    for crate in ("num", "ode", "physics", "plant", "control", "sim"):
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
    assert re.search(r"thesis \(\d", path.read_text(encoding="utf-8")) or path.name == "end_stop.rs"


# Powers and fused products differ between platforms and number types; the smooth functions replace them.
FORBIDDEN = re.compile(r"\.powf\(|\.mul_add\(|\.signum\(|\bunsafe\b|\bVec<|\bvec!|Box<|\.to_vec\(|println!|std::fs")
# Tables are made once, before any run.
MAKES_TABLES = {"fluid.rs"}
# Roots that are kept away from zero where they stand, and magnitudes that the source's own law takes.
ROOTS = {"four_bar.rs": 1, "orifice.rs": 2}


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
ORACLES = {"crates/plant/src/reference.rs"}


def test_runs_have_the_same_bits_on_every_platform():
    """Elementary functions come from `hydrocrane_num`, or from `libm`, never from the platform."""
    for crate in ("num", "ode", "physics", "machine", "plant", "control", "sim", "web"):
        for path in source_files(f"crates/{crate}/src", ".rs"):
            if name_of(path) in ORACLES or path.name.endswith("_tests.rs"):
                continue
            code = without_comments(without_tests(path.read_text(encoding="utf-8")))
            methods = f"{PLATFORM}|{AMBIGUOUS}" if name_of(path).startswith(PLAIN) else PLATFORM
            found = re.findall(rf"\.(?:{methods})\(", code)
            assert not found, f"{name_of(path)}: {found}"


# --- Python ---------------------------------------------------------------------------------------------------------


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


def test_help_of_the_command_line_loads_nothing_heavy():
    code = "from hydrocrane.app.cli import main\ntry:\n    main(['--help'])\nexcept SystemExit:\n    pass"
    assert not modules_after(code) & (HEAVY | {"numpy"})


# --- sizes, words ---------------------------------------------------------------------------------------------------


def own_files() -> list[Path]:
    folders = [("crates", ".rs"), ("python", ".py"), ("tests", ".py"), ("reproductions", ".py"), ("benches", ".py"),
               ("docs", ".py"), ("docs", ".md"), ("cockpit/src", ".ts"), ("machines", ".toml"),
               ("scenarios", ".toml")]  # fmt: skip
    return [p for folder, suffix in folders for p in source_files(folder, suffix)] + sorted(ROOT.glob("*.md"))


@pytest.mark.parametrize("path", own_files(), ids=name_of)
def test_no_file_is_long(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST


@pytest.mark.parametrize("path", own_files(), ids=name_of)
def test_nothing_is_left_undone(path):
    """No marks of unfinished work; this file names them, so it is exempt."""
    if path != Path(__file__).resolve():
        assert not re.search(r"\b(TODO|FIXME|XXX|HACK)\b|todo!\(|unimplemented!\(", path.read_text(encoding="utf-8"))

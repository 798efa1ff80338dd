"""Build the libraries that an installation carries beside its module: that inside FMUs, and that of controllers in C.

Run it before the package is built; it needs nothing but cargo::

    python conda/libraries.py
"""

from __future__ import annotations

import json
import runpy
import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Arguments of cargo, name of the library there, folder of the installation, kind of the file.
LIBRARIES = (
    (("--package", "hydrocrane-fmi"), "hydrocrane_fmu", "fmu_library", "cdylib"),
    (("--manifest-path", "crates/embedded/Cargo.toml"), "hydrocrane_controller", "controller_library", "staticlib"),
)


def made(root: Path, arguments: tuple[str, ...], name: str, kind: str) -> Path:
    """Compiles a library; cargo says where it lies, since an environment can choose that."""
    command = ["cargo", "build", "--release", "--locked", *arguments, "--message-format=json-render-diagnostics"]
    done = subprocess.run(command, cwd=root, stdout=subprocess.PIPE, check=True, text=True)
    for line in done.stdout.splitlines():
        artifact = json.loads(line)
        target = artifact.get("target", {})
        if artifact["reason"] == "compiler-artifact" and target["name"] == name and kind in target["crate_types"]:
            suffixes = (".so", ".dylib", ".dll") if kind == "cdylib" else (".a", ".lib")
            return next(Path(file) for file in artifact["filenames"] if file.endswith(suffixes))
    raise SystemExit(f"cargo built no library {name}")


def build(root: Path) -> list[Path]:
    """Puts both libraries where the package is built from."""
    put = []
    # The package cannot be imported yet.
    platform = runpy.run_path(str(ROOT / "python/hydrocrane/export/present_platform.py"))["present"]()
    for arguments, name, folder, kind in LIBRARIES:
        library = made(root, arguments, name, kind)
        # In FMUs the library has the same name on every system.
        own = f"{name}{library.suffix}" if kind == "cdylib" else library.name
        to = root / "python" / "hydrocrane" / folder / platform / own
        to.parent.mkdir(parents=True, exist_ok=True)
        put.append(Path(shutil.copy(library, to)))
    return put


if __name__ == "__main__":
    for path in build(ROOT):
        print(path)

"""BibTeX for the sources of a machine or a run."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING

from hydrocrane.errors import InputError

if TYPE_CHECKING:
    from hydrocrane.machine.machine import MachineLike
    from hydrocrane.results.record import Record

ENTRIES = {
    "heinze2007": """@mastersthesis{heinze2007,
  author = {Heinze, Alexander},
  title  = {Modelling, Simulation and Control of a Hydraulic Crane},
  school = {V{\\"a}xj{\\"o} University, School of Technology and Design},
  year   = {2007},
}""",
    "canudas1995": """@article{canudas1995,
  author  = {Canudas de Wit, C. and Olsson, H. and {\\AA}str{\\"o}m, K. J. and Lischinsky, P.},
  title   = {A New Model for Control of Systems with Friction},
  journal = {IEEE Transactions on Automatic Control},
  volume  = {40},
  number  = {3},
  pages   = {419--425},
  year    = {1995},
  doi     = {10.1109/9.376053},
}""",
    "steinebach2023": """@article{steinebach2023,
  author  = {Steinebach, Gerd},
  title   = {Construction of {R}osenbrock--{W}anner method {R}odas5{P} and numerical benchmarks within the {J}ulia
             {D}ifferential {E}quations package},
  journal = {BIT Numerical Mathematics},
  volume  = {63},
  pages   = {27},
  year    = {2023},
  doi     = {10.1007/s10543-023-00967-x},
}""",
    "tsitouras2011": """@article{tsitouras2011,
  author  = {Tsitouras, Ch.},
  title   = {{R}unge--{K}utta pairs of order 5(4) satisfying only the first column simplifying assumption},
  journal = {Computers \\& Mathematics with Applications},
  volume  = {62},
  number  = {2},
  pages   = {770--775},
  year    = {2011},
  doi     = {10.1016/j.camwa.2011.06.002},
}""",
    "luan2017": """@article{luan2017,
  author  = {Luan, Vu Thai},
  title   = {Fourth-order two-stage explicit exponential integrators for time-dependent {PDE}s},
  journal = {Applied Numerical Mathematics},
  volume  = {112},
  pages   = {91--103},
  year    = {2017},
  eprint  = {1606.05417},
  archiveprefix = {arXiv},
}""",
    "hairer1996": """@book{hairer1996,
  author    = {Hairer, E. and Wanner, G.},
  title     = {Solving Ordinary Differential Equations II. Stiff and Differential-Algebraic Problems},
  publisher = {Springer},
  edition   = {2},
  year      = {1996},
  doi       = {10.1007/978-3-642-05221-7}
}""",
}

# Sources of each method, and the methods of this package.
_METHODS = {
    "rodas5p": "steinebach2023",
    "hc-exponential-4": "luan2017",
    "tsit5": "tsitouras2011",
    "hc-rosenbrock-3": "hairer1996",
}
_OWN_METHODS = ("hc-exponential-4", "hc-rosenbrock-3")


def cite(subject: MachineLike | Record) -> str:
    """BibTeX of this package, the laws and the method that `subject` uses, and the sources of its machine's values.

    Parameters
    ----------
    subject : Machine, str, path or Run
        A run adds its integration method. Sources that a machine file states as text are comments.

    Examples
    --------
    >>> print(hc.cite("rottne-f9-lab").splitlines()[0])
    @software{hydrocrane,
    """
    from hydrocrane.machine.machine import as_machine
    from hydrocrane.results.record import Record

    if not isinstance(subject, Record | str | PathLike) and not hasattr(subject, "provenance"):
        raise InputError(f"cite takes a machine, its name or path, or a Run; got {type(subject).__name__}")
    machine = subject.machine if isinstance(subject, Record) else as_machine(subject)
    keys = ["heinze2007"]
    if any(name.endswith(".z") for name in machine.state_names):
        keys.append("canudas1995")
    noted = []
    if isinstance(subject, Record):
        method = str(subject.columns.attrs["solver_method"])
        keys.append(_METHODS[method])
        if method in _OWN_METHODS:
            noted.append(f"% integrated by {method}, a method of hydrocrane that is based on {_METHODS[method]}")
    sources = sorted({source for _, _, source in machine.provenance if source})
    noted += [f"% values of {machine.name}: {' '.join(source.split())}" for source in sources]
    return "\n\n".join([_software(), *(ENTRIES[key] for key in keys), *(["\n".join(noted)] if noted else [])])


def _software() -> str:
    from hydrocrane import __version__

    return f"""@software{{hydrocrane,
  title   = {{hydrocrane: modelling and simulation of hydraulic cranes}},
  version = {{{__version__}}},
}}"""

"""CUDA C: the functions of the C file on the device, and kernels over many cranes."""

from __future__ import annotations

from pathlib import Path

from hydrocrane.export.languages.c import bodies, comment, sizes
from hydrocrane.export.tape import Tape, head

_FILES = Path(__file__).parent
_QUALIFIERS = """\
#define HYDROCRANE_FUNCTION static __device__ inline
#define HYDROCRANE_TABLE static __device__ const double"""
_ABOUT = """\
Kernels for many cranes at a time, a thread each: number i of crane k stands at [i * cranes + k] in every array, so
that the threads of a warp read neighbours. p is the same for every crane if `shared` is not zero, p[i], and may be a
null pointer: then the parameters have the values of the file. Compile with --fmad=false for the bits of hydrocrane."""
_KERNEL = """\
extern "C" __global__ void hydrocrane_{name}_many(int cranes, int shared, const double *x, const double *u,
                                                  const double *p, {arguments})
{{
    const int k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= cranes)
        return;
    double own_x[HYDROCRANE_STATES], own_u[HYDROCRANE_INPUTS], {locals};
    for (int i = 0; i < HYDROCRANE_STATES; i++)
        own_x[i] = x[(size_t)i * cranes + k];
    for (int i = 0; i < HYDROCRANE_INPUTS; i++)
        own_u[i] = u[(size_t)i * cranes + k];
    {prepare}
    {function}(own_x, own_u, c, {results});
{stores}
}}
"""
_PARAMETERS = """\
double own_p[HYDROCRANE_PARAMETERS], own_c[{count}];
    const double *c = file_values;
    if (p) {{
        for (int i = 0; i < HYDROCRANE_PARAMETERS; i++)
            own_p[i] = shared ? p[i] : p[(size_t)i * cranes + k];
        prologue(own_p, own_c);
        c = own_c;
    }}"""


def cuda_text(tape: Tape) -> str:
    """The file."""
    elementary = (_FILES / "elementary.c").read_text(encoding="utf-8")
    kernels = [_kernel("derivative", "derivative", {"dx": "STATES"}, tape)]
    if tape.places:
        kernels.append(_kernel("sparse", "linearised", {"dx": "STATES", "values": "NONZEROS"}, tape))
        indices = {"row": 0, "column": 1}
        about = "/* Row and column of each of the values of hydrocrane_sparse_many. */"
        kernels += [about, *(_places(name, [place[k] for place in tape.places]) for name, k in indices.items())]
    if tape.outputs:
        kernels.append(_kernel("outputs", "outputs", {"y": "OUTPUTS"}, tape))
    return "\n".join([comment(head(tape), _ABOUT), sizes(tape), _QUALIFIERS, elementary, bodies(tape), *kernels])


def _kernel(name: str, function: str, results: dict[str, str], tape: Tape) -> str:
    loop = "    for (int i = 0; i < HYDROCRANE_{size}; i++)\n        {name}[(size_t)i * cranes + k] = own_{name}[i];"
    prepare = _PARAMETERS.format(count=len(tape.kept)) if tape.kept else "const double *c = 0; (void)p; (void)shared;"
    return _KERNEL.format(
        name=name,
        function=function,
        prepare=prepare,
        arguments=", ".join(f"double *{result}" for result in results),
        locals=", ".join(f"own_{result}[HYDROCRANE_{size}]" for result, size in results.items()),
        results=", ".join(f"own_{result}" for result in results),
        stores="\n".join(loop.format(size=size, name=result) for result, size in results.items()),
    )


def _places(name: str, items: list[int]) -> str:
    return f"const int hydrocrane_{name}s[] = {{{', '.join(map(str, items))}}};"

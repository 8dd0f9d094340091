"""What decides the last bits of results on this machine."""

import platform
from functools import cache
from pathlib import Path

import numpy as np
from llvmlite.binding import get_host_cpu_name
from threadpoolctl import threadpool_info

OURS = ("numpy.libs", "scipy.libs")  # folders of libraries that wheels bring along


@cache
def arithmetic() -> str:
    """Processor, C library, NumPy, and the kernels of NumPy and of BLAS that run here."""
    simd = np.show_config(mode="dicts")["SIMD Extensions"]
    kernel = [*simd["baseline"], *simd.get("found", ())][-1]
    pools = [each for each in threadpool_info() if each["user_api"] == "blas" and _is_ours(each)]
    blas = {each.get("architecture", each["internal_api"]) for each in pools}  # MKL has none
    return (
        f"{platform.machine()} {get_host_cpu_name()}, {' '.join(platform.libc_ver())}, "
        f"NumPy {np.__version__} {kernel}, BLAS {' '.join(sorted(blas))}"
    )


def _is_ours(pool: dict[str, str]) -> bool:
    """Whether a library is not one that the wheel of another package, such as OpenCV, uses."""
    folder = Path(pool["filepath"]).parent.name
    return folder in OURS or not folder.endswith(".libs")

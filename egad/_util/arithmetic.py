"""What decides the last bits of results on this machine."""

import platform
from functools import cache

import numpy as np
from llvmlite.binding import get_host_cpu_name
from threadpoolctl import threadpool_info


@cache
def arithmetic() -> str:
    """Processor, C library, NumPy, and the kernels of NumPy and of BLAS that run here."""
    simd = np.show_config(mode="dicts")["SIMD Extensions"]
    kernel = [*simd["baseline"], *simd.get("found", ())][-1]
    pools = [each for each in threadpool_info() if each["user_api"] == "blas"]
    blas = {each.get("architecture", each["internal_api"]) for each in pools}  # MKL has none
    return (
        f"{platform.machine()} {get_host_cpu_name()}, {' '.join(platform.libc_ver())}, "
        f"NumPy {np.__version__} {kernel}, BLAS {' '.join(sorted(blas))}"
    )

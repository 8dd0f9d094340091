"""Compiled kernels, cached on disk under the version of all of their sources.

numba looks only at the file of a kernel when it decides whether its cached machine code is still
good, not at the kernels of other files that were compiled into it. So the cache gets a folder of its
own for every state of the sources.
"""

import hashlib
from pathlib import Path

import numba

PACKAGE = Path(__file__).parent


def sources_version(package: Path = PACKAGE) -> str:
    """A fingerprint of all source files of the package."""
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


numba.config.CACHE_DIR = str(PACKAGE / "__pycache__" / f"kernels-{sources_version()}")
kernel = numba.njit(cache=True)

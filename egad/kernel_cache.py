"""Where numba keeps compiled kernels: a folder of its own for every state of their sources.

numba looks only at the file of a kernel when it decides whether its cached machine code is still
good, not at the kernels of other files that were compiled into it. After an edit or an update it
would run stale code with new data. Nor does it look at whether the code checks its indices.
"""

import hashlib
import os
from pathlib import Path

PACKAGE = Path(__file__).parent


def kernel_sources_version(package: Path = PACKAGE) -> str:
    """A fingerprint of all source files of the package that hold kernels."""
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        text = path.read_bytes()
        if b"@numba.njit" in text:
            digest.update(path.name.encode() + text)
    return digest.hexdigest()[:16]


def use_own_cache() -> None:
    """Tell numba, before it is imported, unless the user has told it already."""
    checked = "-bounds" if os.environ.get("NUMBA_BOUNDSCHECK", "0") != "0" else ""
    folder = PACKAGE / "__pycache__" / f"kernels-{kernel_sources_version()}{checked}"
    os.environ.setdefault("NUMBA_CACHE_DIR", str(folder))

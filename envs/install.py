"""Install a lock file, and this project, into the environment of the Python that runs this.

    .venv/bin/python envs/install.py requirements.lock --project .

uv installs, from where pip would take the packages: a tenth of the time that pip needs. It is taken
from the machine, or else fetched for the time that this runs. Where it cannot be had or fails, pip
installs the same. Needs nothing but Python and pip.
"""

import argparse
import ast
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

HERE = Path(__file__).parent
NEEDED = 1_500_000_000  # bytes, while packages are unpacked
PIP = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
# Variables by which uv takes what pip reads from its own configuration; uv has other separators.
UV_SETTINGS = {
    "index-url": ("UV_DEFAULT_INDEX", " "),
    "extra-index-url": ("UV_INDEX", " "),
    "find-links": ("UV_FIND_LINKS", ","),
    "trusted-host": ("UV_INSECURE_HOST", " "),
    "cert": ("SSL_CERT_FILE", " "),
    "proxy": ("ALL_PROXY", " "),
}


def main() -> None:
    """Install what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("lock", type=Path, help="packages with their hashes")
    parser.add_argument("--project", type=Path, help="folder to install too, editable")
    wanted = parser.parse_args()
    # A lock file names all packages, but for those of one that was installed before.
    locked = ["install", "--no-deps", "--require-hashes", "--requirement", str(wanted.lock)]
    steps = [locked]
    if wanted.project:
        steps.append(["install", "--no-deps", "--no-build-isolation", "-e", str(wanted.project)])
    if not with_uv(steps):
        with_pip(steps)


def with_uv(steps: list[list[str]]) -> bool:
    """Install with uv; whether that was possible.

    What uv unpacks lies on the disk of the environment, which gets links to it and no copies, and
    not in the home directory, which may be small or read-only.
    """
    with TemporaryDirectory(dir=sys.prefix) as folder:
        program = shutil.which("uv") or fetched_uv(Path(folder) / "uv")
        if not program:
            return False
        settings = uv_settings(pip_settings(output([*PIP, "config", "list"])))
        own = {"UV_CACHE_DIR": f"{folder}/cache", "UV_INDEX_STRATEGY": "unsafe-best-match"}
        environment = own | settings | os.environ
        done = all(
            subprocess.run(
                [program, "pip", *step, "--python", sys.executable], env=environment, check=False
            ).returncode
            == 0
            for step in steps
        )
        if not done and shutil.disk_usage(sys.prefix).free < NEEDED / 10:
            sys.exit(
                f"The disk of {sys.prefix} is full: the setup needs {NEEDED / 1e9:.1f} GB, and "
                "leaves 1 GB taken"
            )
    if not done:
        print("uv could not install the packages; pip does it, which takes longer")
    return done


def with_pip(steps: list[list[str]]) -> None:
    """Install with pip; compiling all modules takes as long as all the rest, so it is left out."""
    for step in steps:
        status = subprocess.run([*PIP, *step, "--no-compile"], check=False).returncode
        if status:
            sys.exit(status)


def fetched_uv(folder: Path) -> str | None:
    """Fetch the uv of `installer.lock` with pip; None if there is none for this machine."""
    options = ["--require-hashes", "--no-deps", "--no-compile", "--quiet", "--only-binary", ":all:"]
    lock = str(HERE / "installer.lock")
    command = [*PIP, "install", *options, "--target", str(folder), "--requirement", lock]
    status = subprocess.run(command, check=False).returncode
    return None if status else str(folder / "bin" / "uv")


def output(command: list[str]) -> str:
    """What a command says; nothing if it fails."""
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False).stdout


def pip_settings(listed: str) -> dict[str, str]:
    """The settings by which `pip install` goes.

    Args:
        listed: What `pip config list` says: `section.name='value'`, line by line.
    """
    found: dict[str, dict[str, str]] = {"global": {}, "install": {}, ":env:": {}}
    for line in listed.splitlines():
        key, separator, value = line.partition("=")
        section, _, name = key.rpartition(".")
        if separator and section in found:
            found[section][name] = ast.literal_eval(value)
    return {name: value for section in found.values() for name, value in section.items()}


def uv_settings(pip: Mapping[str, str]) -> dict[str, str]:
    """The same for uv, as environment variables."""
    return {
        variable: separator.join(pip[name].split())
        for name, (variable, separator) in UV_SETTINGS.items()
        if pip.get(name)
    }


if __name__ == "__main__":
    main()

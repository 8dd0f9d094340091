"""The files that a detector is made of, besides the library: the user's code, and weights."""

import zipfile
from pathlib import Path

from egad import own_code
from egad.errors import UserError
from egad.settings import Policy

WHERE = "policies"
MOST_BYTES = 1 << 24  # some 50 times those that were published
GGCNN_WEIGHTS = (
    "`egad train` makes weights; the published ones are in the releases of the project "
    "dougsm/ggcnn, as files named "
    "ggcnn_epoch_23_cornell_statedict.pt (GG-CNN) and epoch_50_cornell_statedict.pt (GG-CNN2)"
)


def fingerprint(policy: Policy) -> list[str]:
    """What else than the library and the settings decides the answers; the detector is not run.

    Raises:
        UserError: A file is missing.
    """
    if policy.detector == "ggcnn":
        check_ggcnn(policy.weights)
    own = [own_code.source_hash(policy.detector, WHERE)] if ":" in policy.detector else []
    weights = [own_code.file_hash(policy.weights, WHERE)] if policy.weights else []
    return [*own, *weights]


def check_ggcnn(weights: str | None) -> str:
    """The path of GG-CNN's weights, if they are there.

    Raises:
        UserError: None are named, there is no such file, or it is far too large; the text says
            where to get them.
    """
    if weights is None:
        raise UserError(f"{WHERE}: ggcnn needs `weights: FILE`; {GGCNN_WEIGHTS}")
    if not Path(weights).is_file():
        raise UserError(f"{WHERE}: there is no file {weights}; {GGCNN_WEIGHTS}")
    if _size(Path(weights)) > MOST_BYTES:
        raise UserError(f"{WHERE}: {weights} is too large to be weights of GG-CNN; {GGCNN_WEIGHTS}")
    return weights


def _size(path: Path) -> int:
    """Bytes of a file, or of all that is in it if it is a zip, as those of PyTorch are."""
    size = path.stat().st_size
    if size > MOST_BYTES or not zipfile.is_zipfile(path):
        return size
    try:
        with zipfile.ZipFile(path) as archive:
            return sum(entry.file_size for entry in archive.infolist())
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        return size

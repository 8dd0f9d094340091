"""Whether grasps of a file are read right: the usual mistakes, each tried on the object (ours)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple, Unpack

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from egad._util.arrays import Flags, Floats, Ints
from egad._util.display import Picture, draw, facts_html
from egad._util.files import as_path, atomic_output
from egad._util.progress import phase_if_slow
from egad.errors import UserError
from egad.exchange.grasp_files import FileGrasps
from egad.exchange.grasps.graspgen import graspgen_hand
from egad.exchange.reading import TOLERANCE, Said, read_file, read_options
from egad.geometry import RayCaster, center_of_mass, check_solid
from egad.grasps import are_rigid, close_fingers, touching_turns
from egad.grippers import Gripper, check_jaws, hand_body
from egad.io import METRES

Verdict = Literal["consistent", "mistake", "undecided", "unexplained"]
AS_READ = "as read"
FACING = np.cos(np.radians(45))  # between the closing axis and the normals
DEPTHS = np.arange(-50.0, 51.0) / 200  # metres along the approach that are tried
WORDS = {"mm": "millimetres", "cm": "centimetres", "inch": "inches"}
SCALES = 1.1 ** np.arange(-35.0, 36.0)
UNITS = {name: METRES[unit] for unit, name in WORDS.items()}
MANY = 50_000  # grasps that are changed
MOST, SOME, FEW, SHOWN = 2000, 200, 60, 10  # grasps that explanations are tried on, or drawn
WORK = 2e7  # triangles times grasps of one explanation, at most
LEAST, GAIN = 0.3, 0.1  # share that fits if it is read right, and by which a mistake must raise it
PLATEAU = 0.05  # of the share, within which depths and scales are as good
CERTAIN, UNTURNED = 20, np.eye(3)  # grasps below which nothing is decided
ONE_FINGER = "the widths are those of one finger: multiply them by 2"


class Explanation(NamedTuple):
    """A mistake, and the grasps without it."""

    name: str
    file: FileGrasps
    matrix: Floats | None = None  # what corrects the matrices of the file as a factor, if anything
    side: str = ""  # of the matrices on which it is multiplied: `left` or `right`


@dataclass(frozen=True, repr=False)
class GraspCheck:
    """What is wrong with the grasps of a file, if anything.

    Attributes:
        verdict: `consistent`, `mistake`, `undecided` (several explain it as well) or `unexplained`.
        mistakes: The best explanations; empty if the grasps are consistent.
        shares: Fraction of grasps with both pads on the object, facing each other, and the open
            hand clear of it, by explanation; `as read` is that of the file as it was read.
        count: Number of grasps that were tried.
        matrix: (4, 4) transform that corrects the poses of the file, if there is one.
        side: Side of these poses on which it is multiplied: `left` or `right`.
        corrected: The grasps without mistakes; None if there are several, or over 50,000 grasps.
    """

    verdict: Verdict
    mistakes: list[str]
    shares: dict[str, float]
    count: int
    matrix: Floats | None = None
    side: str = ""
    corrected: FileGrasps | None = None
    # the object, ten of the grasps as read and corrected, (10, 4, 4), and the hand
    drawn: tuple[trimesh.Trimesh, dict[str, Floats], Gripper] | None = None

    def plot(self) -> Picture:
        """Draw ten of the grasps around the object: as read, and corrected if they are."""
        return draw("grasps", "hands_chart", *(self.drawn or ()))

    def __repr__(self) -> str:
        own = f"{self.shares[AS_READ]:.0%} of {self.count} grasps fit as read"
        text = {
            "consistent": f"no mistake found: {own}",
            "unexplained": f"nothing explains it: {own}, and no usual mistake explains many more",
            "undecided": f"undecided: {own}; several explanations, or too few grasps: ",
            "mistake": f"{own}; the mistake: ",
        }[self.verdict]
        known = [f"{name} ({self.shares[name]:.0%} fit then)" for name in self.mistakes]
        told = text + "; ".join(known)
        if self.matrix is None:
            return told
        rows = np.array2string(self.matrix.round(6) + 0.0, separator=", ")
        return f"{told}\nmultiply the poses of the file from the {self.side} by\n{rows}"

    def _repr_html_(self) -> str:
        names = [AS_READ, *sorted(self.shares, key=lambda name: -self.shares[name])[:5]]
        facts = {name: f"{self.shares[name]:.0%} fit" for name in names}
        return facts_html(f"{self.count} grasps: {self.verdict}", facts)

    def save(self, path: str | Path) -> None:
        """Write the grasps as plain poses, corrected, with their frame, depth and unit."""
        if self.corrected is None:
            raise UserError(f"there is no single mistake, or there are over {MANY:,} grasps")
        file = self.corrected
        known: dict[str, ArrayLike] = {"poses": file.poses, "widths": file.widths}
        known |= {"success": file.success, "score": file.score}
        known |= {"frame": "x z", "depth": 0.0, "units": "m"}
        with atomic_output(as_path("path", path)) as temporary, temporary.open("wb") as stream:
            np.savez(stream, allow_pickle=False, **known)


@phase_if_slow("checking grasps")
def check_grasps(
    path: str | Path,
    mesh: trimesh.Trimesh,
    gripper: Gripper | str,
    format: str | None = None,  # noqa: A002 (what users call it)
    **said: Unpack[Said],
) -> GraspCheck:
    """Name what is wrong with a file of grasps: axes, depth, units, frame of the object, and more.

    Each usual mistake is undone, and the grasps that then fit are counted, on at most 2,000 of
    those that the file does not call failures, or of all. A mistake is named only if at least 30 %
    of the grasps fit without it, 10 % more than as read, and more than without every other one.

    Args:
        path: The file.
        mesh: The object, a closed mesh in metres.
        gripper: The gripper, or its name.
        format: Its format, by default that of its content.
        said: What the file leaves open, as for `read_grasps`.

    Raises:
        UserError: The file cannot be read, or leaves something open that is not given.
        RejectedError: The mesh is not a closed solid.
    """
    options = read_options(gripper, **said)
    check_solid(mesh)
    assert options.gripper is not None  # noqa: S101 (it was an argument)
    check_jaws(options.gripper.gripper, "a grasp that is checked")
    whole = read_file(as_path("path", path), format, options)
    trial = _Trial(mesh, options.gripper.gripper)
    stride = -(-len(whole.matrices) // MANY)
    file = _take(whole, slice(None, None, stride))
    place = file.place[0]
    known = [-float(place[:3, 3] @ place[:3, 2]), graspgen_hand(*options.gripper).depth]
    exact = list(_changes(file, mesh))
    fitted = [
        *_best_depth(trial, file, known),
        *_best_scale(trial, file),
        *_turned_and_shifted(trial, file, known),
    ]
    found = _judged(trial, exact, fitted)
    files = {f"{AS_READ}: {found.shares[AS_READ]:.0%} fit": file}
    if found.corrected is not None:
        files[f"corrected: {found.shares[found.mistakes[0]]:.0%} fit"] = found.corrected
    shown = {title: trial.sample(each, SHOWN).poses for title, each in files.items()}
    corrected = found.corrected if stride == 1 else None
    if found.verdict == "consistent":
        corrected = whole
    return replace(found, corrected=corrected, drawn=(mesh, shown, options.gripper.gripper))


def _take(file: FileGrasps, rows: Ints | slice) -> FileGrasps:
    names = ["matrices", "widths", "openings", "success", "score"]
    names += ["place"] if len(file.place) > 1 else []
    return file._replace(**{name: getattr(file, name)[rows] for name in names})


class _Trial:
    """An object and a hand that poses are tried on."""

    def __init__(self, mesh: trimesh.Trimesh, gripper: Gripper) -> None:
        self.caster, self.body = RayCaster(mesh), hand_body(gripper)

    def sample(self, file: FileGrasps, count: int) -> FileGrasps:
        """Some grasps, evenly from those that did not fail, if there are enough, or from all."""
        rows = np.flatnonzero(file.success != 0)
        rows = rows if len(rows) >= CERTAIN else np.arange(len(file.matrices))
        count = min(count, len(rows), max(int(WORK / len(self.caster.triangles)), FEW))
        return _take(file, rows[np.linspace(0, len(rows) - 1, count).round().astype(np.int64)])

    def shares(self, files: Sequence[FileGrasps], count: int) -> Floats:
        """The share of fitting grasps of files of the same grasps, (k,)."""
        poses = [self.sample(file, count).poses for file in files]
        fits, _ = self.fit(np.concatenate(poses))
        return np.asarray(fits.reshape(len(files), -1).mean(axis=1))

    def fit(self, poses: Floats) -> tuple[Flags, Floats]:
        """Which hands at (n, 4, 4) have both pads on the object and are clear of it; widths."""
        fits, widths = np.zeros(len(poses), dtype=bool), np.full(len(poses), np.nan)
        rows, opening = np.flatnonzero(are_rigid(poses, TOLERANCE)), self.body.gripper.opening
        centers, axes, approaches = (poses[rows, :3, column] for column in (3, 0, 2))
        pairs, touching = close_fingers(self.caster, centers, axes, opening)
        cosines = np.einsum("nik,nk->ni", pairs.normals, axes) * [-1, 1]
        inner = np.flatnonzero(touching & (cosines.min(axis=1, initial=1) > FACING))
        held = pairs.take(inner)
        behind = self.body.reach(held.widths) - self.body.reach(np.array([opening]))
        frames = np.ascontiguousarray(held.frames(approaches[inner]))
        origins = np.ascontiguousarray(centers[inner])
        blocked = touching_turns(self.caster, self.body.parts(), origins, frames, behind=behind)
        fits[rows[inner]], widths[rows[inner]] = ~blocked[:, 0], held.widths
        return fits, widths


def _pose(turn: ArrayLike = UNTURNED, point: ArrayLike = 0.0) -> Floats:
    """Poses (..., 4, 4) of rotations (..., 3, 3) and points (..., 3)."""
    turns = np.asarray(turn, np.float64)
    poses = np.zeros((*turns.shape[:-2], 4, 4))
    poses[..., :3, :3], poses[..., :3, 3], poses[..., 3, 3] = turns, point, 1
    return poses


def _changes(file: FileGrasps, mesh: trimesh.Trimesh) -> Iterator[Explanation]:
    """The file as read, then every mistake that has no size to be searched for."""
    yield Explanation(AS_READ, file)
    turns, points = file.matrices[:, :3, :3], file.matrices[:, :3, 3]
    back = np.swapaxes(turns, 1, 2)
    matrices = {
        "the poses are inverse: object to hand": _pose(
            back, -np.einsum("nij,nj->ni", back, points)
        ),
        "the matrices are transposed (column by column)": np.swapaxes(file.matrices, 1, 2),
        "the rotations are transposed (column by column)": _pose(back, points),
    }
    if are_rigid(file.matrices, TOLERANCE).all():
        quaternions = Rotation.from_matrix(turns).as_quat()
        for step, order in ((-1, "w, x, y, z"), (1, "x, y, z, w")):
            turned = Rotation.from_quat(np.roll(quaternions, step, axis=1)).as_matrix()
            matrices[f"the quaternions are {order}"] = _pose(turned, points)
    for factor in UNITS.values():
        matrices[f"the positions were divided by {1 / factor:g}"] = _pose(turns, points / factor)
    rights = dict(_turns(file))
    for name, row in zip("xyz", np.eye(4), strict=False):
        mirror = np.diag(1 - 2 * row)
        rights[f"the hand is mirrored: its {name} is reversed"] = mirror
        mirrored = mirror @ file.matrices @ mirror
        matrices[f"the object is mirrored: its {name} is reversed"] = mirrored
    upright = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    lefts = {
        "y of the object is up": _pose(upright),
        "-y of the object is up": _pose(upright.T),
        "the poses are relative to the center of mass": _pose(point=center_of_mass(mesh)),
        "the poses are relative to the middle of the box": _pose(point=mesh.bounds.mean(axis=0)),
    }
    for unit, factor in UNITS.items():
        yield Explanation(f"the positions are in {unit}", _in_metres(file, factor))
    for name, changed in matrices.items():
        yield Explanation(name, file._replace(matrices=changed))
    for name, right in rights.items():
        yield Explanation(name, file._replace(matrices=file.matrices @ right), right, "right")
    for name, left in lefts.items():
        first = np.linalg.inv(file.reference) @ left @ file.reference
        yield Explanation(name, file._replace(reference=left @ file.reference), first, "left")


def _turns(file: FileGrasps) -> Iterator[tuple[str, Floats]]:
    """Axes that the hand of the file may have, with the turn (4, 4) to those of the format."""
    axes = [f"{sign}{name}" for name in "xyz" for sign in ("", "-")]
    directions = np.repeat(np.eye(3), 2, axis=0) * np.tile([1, -1], 3)[:, None]
    seen = [(file.place[0, :3, 0], file.place[0, :3, 2])]
    for turn in Rotation.create_group("O").as_matrix().round():
        closing, approach = turn @ file.place[0, :3, 0], turn @ file.place[0, :3, 2]
        if any(abs(closing @ one) > 0.99 and approach @ other > 0.99 for one, other in seen):
            continue  # the fingers are exchanged
        seen.append((closing, approach))
        told = [axes[int(np.argmax(directions @ each))] for each in (closing, approach)]
        yield f"the hand closes along {told[0]} and approaches along {told[1]}", _pose(turn)


def _deeper(file: FileGrasps, depth: float) -> FileGrasps:
    return file._replace(place=file.place @ _pose(point=[0, 0, depth]))


def _in_metres(file: FileGrasps, factor: float) -> FileGrasps:
    """Positions times a factor, and widths too if most of them are more than a metre."""
    matrices = file.matrices.copy()
    matrices[:, :3, 3] *= factor
    known = (file.widths, file.openings)
    widths, openings = (factor * each if (each > 1).mean() > 0.5 else each for each in known)
    return file._replace(matrices=matrices, widths=widths, openings=openings)


def _scaled(file: FileGrasps, factor: float) -> FileGrasps:
    poses = file.poses
    poses[:, :3, 3] *= factor
    matrices = np.linalg.inv(file.reference) @ poses @ np.linalg.inv(file.place)
    return file._replace(matrices=matrices, widths=factor * file.widths)


def _plateau(values: Floats, shares: Floats, unchanged: float) -> tuple[float, float] | None:
    """The ends of the values around the best one that are nearly as good; None if one is such."""
    best = int(np.argmax(shares))
    worse = np.flatnonzero(shares < shares[best] - PLATEAU)
    low, high = worse[worse < best].max(initial=-1), worse[worse > best].min(initial=len(values))
    ends = float(values[low + 1]), float(values[high - 1])
    return None if shares[best] == 0 or ends[0] <= unchanged <= ends[1] else ends


def _best_depth(trial: _Trial, file: FileGrasps, known: Sequence[float]) -> Iterator[Explanation]:
    """A shift along the approach, if that of the file is not as good; a known one if it is."""
    shares = trial.shares([_deeper(file, depth) for depth in DEPTHS], SOME)
    if ends := _plateau(DEPTHS, shares, 0.0):
        middle = sum(ends) / 2
        inner = [each for each in known if ends[0] <= each <= ends[1]]
        depth = min(inner, key=lambda each: abs(each - middle), default=middle)
        whence = "base of the hand" if depth > 0 else "contacts or the fingertips"
        name = f"the poses are of the {whence}: they lack {1000 * depth:+.0f} mm along the approach"
        place = file.place[0]
        matrix = place @ _pose(point=[0, 0, depth]) @ np.linalg.inv(place)
        yield Explanation(name, _deeper(file, depth), matrix, "right")


def _best_scale(trial: _Trial, file: FileGrasps) -> Iterator[Explanation]:
    """Another size of the object, if that of the file is not as good."""
    values, ends = SCALES, (1.0, 1.0)
    for _ in range(2):  # coarse, then fine
        shares = trial.shares([_scaled(file, each) for each in values], SOME)
        if (found := _plateau(values, shares, 1.0)) is None:
            return
        ends, values = found, np.linspace(found[0] / 1.1, found[1] * 1.1, 41)
    factor = sum(ends) / 2
    yield Explanation(f"the object is about {factor:.2g} times as large", _scaled(file, factor))


def _turned_and_shifted(
    trial: _Trial, file: FileGrasps, known: Sequence[float]
) -> Iterator[Explanation]:
    """Both other axes and another depth, as in files that are taken for those of another format."""
    best, chosen = 0.0, ("", np.eye(4))
    for name, turn in _turns(file):
        turned = file._replace(matrices=file.matrices @ turn)
        share = trial.shares([_deeper(turned, depth) for depth in DEPTHS], FEW).max()
        if share > best:
            best, chosen = share, (name, turn)
    turned = file._replace(matrices=file.matrices @ chosen[1])
    for each in _best_depth(trial, turned, known) if best else ():
        matrix = None if each.matrix is None else chosen[1] @ each.matrix
        yield Explanation(f"{chosen[0]}, and {each.name}", each.file, matrix, "right")


def _judged(
    trial: _Trial, exact: Sequence[Explanation], fitted: Sequence[Explanation]
) -> GraspCheck:
    """Choose among explanations, the first of which is the file as read."""
    found = [*exact, *fitted]
    coarse = trial.shares([each.file for each in found], SOME)
    least = max(coarse.max() - 3 * PLATEAU, LEAST / 2)
    few = [each for at, each in enumerate(found) if at == 0 or coarse[at] >= least]
    values = trial.shares([each.file for each in few], MOST)
    count = len(trial.sample(few[0].file, MOST).matrices)
    shares = {each.name: float(share) for each, share in zip(few, values, strict=True)}
    own, best, margin = values[0], values.max(), 0.03 + 0.3 / np.sqrt(count)
    if best < own + max(GAIN, margin) or best < LEAST:
        verdict: Verdict = "consistent" if own >= LEAST else "unexplained"
        result = GraspCheck(verdict, [], shares, count)
        return _with_widths(trial, few[0], result) if own >= LEAST else result
    names = {each.name for each in exact}
    rows = [row for row in np.argsort(-values, kind="stable") if values[row] >= best - margin]
    # the others were fitted, and one change comes before two
    rows = [row for row in rows if few[row].name in names] or [min(rows)]
    different: list[Explanation] = []
    for each in (few[row] for row in rows):
        if not any(_same(each.file, other.file) for other in different):
            different.append(each)
    names_of = [each.name for each in different]
    if len(different) > 1 or count < CERTAIN:
        return GraspCheck("undecided", names_of, shares, count)
    chosen = different[0]
    result = GraspCheck("mistake", names_of, shares, count, chosen.matrix, chosen.side, chosen.file)
    return _with_widths(trial, chosen, result)


def _same(one: FileGrasps, other: FileGrasps) -> bool:
    """Whether two explanations give the same grasps, up to an exchange of the fingers."""
    first, second = one.poses, other.poses
    cosines = np.einsum("nki,nki->ni", first[:, :3, :3], second[:, :3, :3])
    near = np.abs(first[:, :3, 3] - second[:, :3, 3]).max() < 1e-4
    return bool(near and np.abs(cosines[:, 0]).min() > 0.9999 and cosines[:, 2].min() > 0.9999)


def _with_widths(trial: _Trial, chosen: Explanation, result: GraspCheck) -> GraspCheck:
    """The result, with what is wrong with the widths of the grasps that fit."""
    file, tried = chosen.file, trial.sample(chosen.file, MOST)
    fits, measured = trial.fit(tried.poses)
    ratios = (np.where(np.isnan(tried.widths), tried.openings, tried.widths) / measured)[fits]
    ratios = ratios[np.isfinite(ratios)]
    if len(ratios) < CERTAIN // 2:
        return result
    if not (np.median(ratios) < 0.9 and (ratios > 0.45).mean() > 0.9):
        return result
    right = file._replace(widths=2 * file.widths, openings=2 * file.openings)
    shares = result.shares | {ONE_FINGER: result.shares[chosen.name]}
    mistakes = [*result.mistakes, ONE_FINGER]
    return replace(result, verdict="mistake", mistakes=mistakes, shares=shares, corrected=right)

"""Grasps that other programs wrote."""

import logging
from pathlib import Path
from typing import TypedDict, Unpack

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from egad._util.arguments import check_array, check_positive
from egad._util.arrays import Flags, Floats
from egad._util.files import as_path
from egad._util.limited import FailedError, LimitError, limited
from egad._util.progress import progress
from egad.errors import MissingPackageError, UserError, check_name
from egad.exchange.grasp_files import (
    ASKED,
    LOADERS,
    MAX_GRASPS,
    UNITS,
    Content,
    FileGrasps,
    ReadOptions,
)
from egad.exchange.parameters import NamedGripper
from egad.exchange.registry import READERS, kind_of_format, reader_of
from egad.geometry import (
    Material,
    RayCaster,
    center_of_mass,
    check_solid,
    check_units,
    mass_properties,
    warn_user,
)
from egad.grasps import (
    Grasps,
    RobustSuction,
    Sampled,
    are_rigid,
    label_at_poses,
    label_cups,
    label_parameters,
)
from egad.grasps.suction import GRAVITY, robust_suction_quality, seal_cups
from egad.grippers import Gripper, HandBody, SuctionCup, as_gripper, hand_body
from egad.random import generator
from egad.tables.columns import vector_names

log = logging.getLogger(__name__)
TOLERANCE = 1e-3  # of rotations in single precision, and of rounded quaternions
FEW = 0.1  # of the grasps touch the object
CHUNK = 10_000  # grasps rated at once, which bounds the memory
ROTATION = "a rotation has orthogonal columns of length 1, and the last row is 0, 0, 0, 1"


class Said(TypedDict, total=False):
    """What callers say about a file: see `read_grasps`."""

    frame: str | None
    depth: float | None
    units: str | None
    reference: ArrayLike | None
    object_id: str | int | None
    max_friction: float | None


def read_grasps(
    path: str | Path,
    format: str | None = None,  # noqa: A002 (what users call it)
    mesh: trimesh.Trimesh | None = None,
    gripper: Gripper | str | None = None,
    *,
    seed: int = 0,
    **said: Unpack[Said],
) -> Grasps:
    """Read grasps that another program wrote, and rate them.

    What a file does not say is asked for by name and never guessed: the error names the argument.
    `docs/grasps-of-others.md` has the conventions of each format.

    Args:
        path: The file.
        format: `acronym`, `contact_graspnet`, `dexnet`, `graspgen`, `graspgen_suction`, `graspnet`,
            `isaac_grasp`, `poses`, `simready` or `vgn`; by default that of the content.
        mesh: The object, a closed mesh in metres, at the size that the grasps are for. With it,
            contacts are measured, and grasps are rated and tested for collisions.
        gripper: The gripper that the grasps are for, or its name.
        seed: Seed of the perturbed copies that `robust_quality` is the mean of.
        said: What the file leaves open. `frame`: the closing axis and the approach in the frame of
            its poses, such as `"y x"` or `"x -z"`, and `depth`: how far ahead of their origin the
            contacts are, metres; both in place of those of the format. `units` of plain poses: `m`,
            `cm` or `mm`. `reference`: (4, 4) pose of the camera or scene that the poses are in, in
            the frame of the mesh. `object_id`: which object, segment or scene. `max_friction`: the
            largest friction coefficient that a labelled grasp of GraspNet may need.

    Returns:
        The grasps in the frame of the mesh, in the order of the file, with its labels:
        `source_success`, 1 or 0, and `source_score`. Without a mesh there are only poses, widths
        and these labels.

    Raises:
        UserError: The file cannot be read, has no grasps, more than a million, or a pose that is
            none; or leaves something open that is not given.
        RejectedError: The mesh is not a closed solid.

    Warns:
        UserWarning: Few of the grasps touch the object.
    """
    options = read_options(gripper, **said)
    where = as_path("path", path)
    file = read_file(where, format, options)
    try:
        return as_grasps(file, mesh, options, seed)
    except UserError as error:
        raise UserError(f"{where}: {error}") from error


def read_options(gripper: Gripper | str | None, **said: Unpack[Said]) -> ReadOptions:
    """What a caller says about a file, checked: arguments as of `read_grasps`."""
    named = None
    if gripper is not None:
        named = NamedGripper(
            gripper if isinstance(gripper, str) else "gripper", as_gripper(gripper)
        )
    if (units := said.get("units")) is not None:
        check_name("units", units, UNITS)
    if (depth := said.get("depth")) is not None:
        depth = float(check_array("depth", depth, (), "a finite number, metres"))
    pose = None
    if (reference := said.get("reference")) is not None:
        pose = check_array("reference", reference, (4, 4), f"a (4, 4) pose; {ROTATION}")
        if not are_rigid(pose[None]).all():
            raise UserError(f"reference is {reference!r}; allowed: a (4, 4) pose; {ROTATION}")
    if (limit := said.get("max_friction")) is not None:
        limit = check_positive("max_friction", limit)
    return ReadOptions(named, said.get("frame"), depth, units, pose, said.get("object_id"), limit)


def read_file(path: Path, name: str | None, options: ReadOptions) -> FileGrasps:
    """The grasps of a file as it has them, their poses not checked; `UserError`."""
    if name is not None:
        check_name("format", name, READERS)
    try:
        file = limited(_read, path, name, options)
        if file.note:
            log.info("%s: %s", path, file.note)
        return file
    except MissingPackageError:
        raise
    except FailedError as error:
        about = "a file of grasps that can be read" if name is None else f"a {name} file"
        raise UserError(f"{path}: not {about} ({error})") from error
    except (UserError, LimitError) as error:
        raise UserError(f"{path}: {error}") from error


def _read(path: Path, name: str | None, options: ReadOptions) -> FileGrasps:
    if not path.is_file():
        raise UserError("there is no such file")
    ending = path.suffix.lower()
    if ending not in LOADERS:
        raise UserError(f"a file of grasps ends in {', '.join(LOADERS)}")
    candidates = [name] if name else [each for each, ends in READERS.items() if ending in ends]
    content = LOADERS[ending](path)
    pairs = [(keys, each) for each in candidates for keys in reader_of(each).KEYS]
    known = [(len(keys), each) for keys, each in pairs if all(_has(content, key) for key in keys)]
    if not known:
        names = ", ".join(list(map(str, content))[:8])
        raise UserError(f"not a file of {' or '.join(candidates)}: it has {names or 'nothing'}")
    chosen = max(known)[1]
    hand = options.gripper
    if hand and (kind := hand.gripper.kind).name != kind_of_format(chosen):
        raise UserError(f"a file of {chosen} is not for {hand.name}, which has {kind.noun}")
    if options.max_friction is not None and "offsets" not in content:
        raise UserError("it has no friction coefficients, which `max_friction` is for")
    file: FileGrasps = reader_of(chosen).read(content, options)
    if not 0 < len(file.matrices) <= MAX_GRASPS:
        raise UserError(f"it has {len(file.matrices):,} grasps; allowed: 1 to {MAX_GRASPS:,}")
    return file if options.reference is None else file._replace(reference=options.reference)


def _has(content: Content, key: str) -> bool:
    """Whether a file has a name, or for `a.b` one within another."""
    first, _, rest = key.partition(".")
    inner = content.get(first, {}) if rest else {}
    return first in content and (not rest or (isinstance(inner, dict) and rest in inner))


def as_grasps(
    file: FileGrasps, mesh: trimesh.Trimesh | None, options: ReadOptions, seed: int = 0
) -> Grasps:
    """The grasps of a file, rated if there is a mesh: see `read_grasps`."""
    check_matrices(file)
    poses, widths = file.poses, file.widths
    poses[:, :3, :3] = Rotation.from_matrix(poses[:, :3, :3]).as_matrix()  # rounded ones
    if mesh is None:
        widths = np.where(np.isnan(widths), file.openings, widths)
        if np.isnan(widths).any():
            raise UserError(f"it does not say how wide grasps are: give `mesh`, {ASKED['mesh']}")
        table = _unrated(poses, widths)
    else:
        hand: NamedGripper = options.needed("gripper", "to rate grasps takes a hand")
        table = _rated(poses, widths, mesh, hand.gripper, seed)
    return Grasps(table.assign(source_success=file.success, source_score=file.score))


def check_matrices(file: FileGrasps) -> None:
    """Raise `UserError`, which names the first, if a pose of a file is none, or a width."""
    matrices = file.matrices
    finite = np.asarray(np.isfinite(file.poses).all(axis=(1, 2)))
    wrong: dict[str, Flags] = {
        "a pose that is not finite": ~finite,
        f"a pose that is no rotation and translation; {ROTATION}": ~are_rigid(matrices, TOLERANCE),
        "a width that is negative": (file.widths < 0) | (file.openings < 0),
        "a label other than 0 and 1": ~(np.isnan(file.success) | np.isin(file.success, (0, 1))),
    }
    for what, where in wrong.items():
        if where.any():
            raise UserError(
                f"{what}: grasp {int(where.argmax())}, and {int(where.sum()) - 1:,} more of "
                f"{len(where):,}; `egad grasps check` names the usual mistakes"
            )


def _unrated(poses: Floats, widths: Floats) -> pd.DataFrame:
    center, axis, approach = poses[:, :3, 3], poses[:, :3, 0], poses[:, :3, 2]
    half = widths[:, None] / 2 * axis
    names = ("center", "axis", "approach", "contact0", "contact1")
    columns = [column for name in names for column in vector_names(name)]
    vectors = np.hstack([center, axis, approach, center - half, center + half])
    return pd.DataFrame(vectors, columns=columns).assign(grasp=range(len(poses)), width=widths)


def _rated(
    poses: Floats, widths: Floats, mesh: trimesh.Trimesh, gripper: Gripper, seed: int
) -> pd.DataFrame:
    check_units(mesh)
    check_solid(mesh)
    caster, com, body = RayCaster(mesh), center_of_mass(mesh), hand_body(gripper)
    settings, tables = label_parameters(gripper, 1, seed), []
    where, more = "between the fingers", " `egad grasps check` names the usual mistakes"
    if gripper.cup is not None:
        where, more = "below the cup", ""
    starts = range(0, len(poses), CHUNK)
    for start in progress(starts, "rating grasps", len(starts)):
        rows, rng = slice(start, start + CHUNK), generator(seed, "read_grasps", start)
        if gripper.cup is None:
            table = label_at_poses(caster, com, poses[rows], widths[rows], settings, rng, body)
        else:
            table = _rated_cups(caster, mesh, poses[rows], body, gripper.cup, (seed, start))
        tables.append(table)
    table = pd.concat(tables, ignore_index=True).assign(grasp=np.arange(len(poses)))
    touching = np.mean(table["normal0_x"].notna() & table["normal1_x"].notna())
    if touching < FEW:
        warn_user(
            f"only {touching:.0%} of the grasps have the object {where}: another object, size, "
            f"frame or hand?{more}",
            UserWarning,
        )
    return table


def _rated_cups(
    caster: RayCaster,
    mesh: trimesh.Trimesh,
    poses: Floats,
    body: HandBody,
    cup: SuctionCup,
    stream: tuple[int, int],
) -> pd.DataFrame:
    """Suction grasps at poses (n, 4, 4), rated as `sample_suction` does, from a seed and number.

    Normals are NaN where the cup does not meet the object.
    """
    solid, origins = mass_properties(mesh, Material().density), poses[:, :3, 3]
    frames = np.ascontiguousarray(poses[:, :3, :3].transpose(0, 2, 1))
    quality = robust_suction_quality(
        caster,
        cup,
        origins,
        frames,
        solid.com,
        GRAVITY * solid.mass * frames[:, 2],
        robust=RobustSuction(),
        seed=stream[0],
        indices=stream[1] + np.arange(len(poses)),
    )
    table = label_cups(caster, Sampled(poses, np.zeros(len(poses)), quality), body, 0.0)
    missed = ~(np.abs(seal_cups(caster, cup, origins, frames).depths) <= cup.height)
    table.loc[missed, vector_names("normal0") + vector_names("normal1")] = np.nan
    return table

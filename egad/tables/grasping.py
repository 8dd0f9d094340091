"""Tables of a gripper: grasps, sampling statistics, and the scales of the objects."""

import pyarrow as pa

from egad.tables.columns import (
    ID,
    LABEL,
    QUALITY,
    ROBUST_QUALITY,
    ROBUST_SUCCESS_RATE,
    Result,
    boolean,
    integer,
    optional,
    real,
    schema,
    text,
    vector,
)
from egad.tables.outcomes import EXECUTION, SHAKEN, SIMULATION_FAILURES, listed

GRASPS = schema(
    ID,
    LABEL,
    integer("grasp", "number of the grasp on its object"),
    *vector("center", "midpoint of the contacts; for a cup, a point on the surface", "m"),
    *vector(
        "axis",
        "unit vector from the first contact to the second; for a cup, any unit vector "
        "perpendicular to the approach",
    ),
    *vector("approach", "unit vector along which the hand moves towards the object"),
    real("width", "distance between the contacts; 0 for a cup", "m"),
    real(
        "needed_opening",
        "smallest opening at which both finger boxes fit beside the object; may exceed that of "
        "the gripper",
        "m",
    ),
    *vector("contact0", "first contact", "m"),
    *vector("contact1", "second contact; for a cup, the first one again", "m"),
    *vector("normal0", "outward unit normal at the first contact"),
    *vector("normal1", "outward unit normal at the second contact"),
    QUALITY,
    ROBUST_QUALITY,
    real("robust_quality_std", "standard deviation of the quality over perturbed copies"),
    ROBUST_SUCCESS_RATE,
    boolean(
        "fits",
        "whether the open hand touches nothing at the grasp, at the best of the approach "
        "angles tried",
    ),
    boolean(
        "collision_free",
        "whether the open hand touches nothing, neither at the grasp nor on its straight "
        "approach, at the best of the approach angles tried",
    ),
    integer("angles_fit", "number of approach angles tried at which the hand fits"),
    integer("angles_collision_free", "number of approach angles tried that are collision-free"),
)


def _motion(phase: str, how: str) -> list[pa.Field]:
    moved = f"how far the object {{}} relative to the hand while {how}"
    return [
        real(f"simulated_{phase}_shift", moved.format("moved"), "m"),
        real(f"simulated_{phase}_turn", moved.format("turned"), "rad"),
    ]


_MOTIONS = [*_motion("closing", "the fingers closed"), *_motion("shaking", "it was shaken")]
MOTIONS = tuple(field.name for field in _MOTIONS)
_SIMULATED = [
    text(
        "simulated_outcome",
        f"outcome of closing in free space, shaking and lifting in simulation: {listed(SHAKEN)}; "
        f"or "
        f"{listed(SIMULATION_FAILURES)}; missing if the grasp was not simulated",
    ),
    boolean(
        "simulated_success",
        "whether the object was still held at the end; missing if the engine could not tell, or if "
        "the grasp was not simulated",
    ),
    *_MOTIONS,
    (_ENGINE := text("simulated_engine", "physics engine")),
]
SIMULATED_GRASPS = schema(*GRASPS, *map(optional, _SIMULATED))
"""Labelled grasps, with simulated labels if `targets.simulated_labels` is true."""

TRIED_GRASPS = schema(
    *SIMULATED_GRASPS,
    text("table_outcome", f"outcome on a table: {listed((*EXECUTION, *SIMULATION_FAILURES))}"),
    real("depth", "how far the fingertips reach below the surface between the fingers", "m"),
    real("friction", "friction of the fingers on the object in simulation"),
    real("mass", "mass of the object in simulation", "kg"),
    real("source_success", "label of the file that the grasp was read from, 1 or 0"),
    real("source_score", "score of that file"),
)
_HELD = [
    integer("n_simulated", "number of simulated antipodal grasps with an outcome"),
    real(
        "antipodal_success_rate",
        "fraction of simulated antipodal grasps that held when shaken and lifted; near 1 for most "
        "objects",
    ),
    real("held_shaking", "fraction of simulated antipodal grasps that held when shaken"),
    _ENGINE,
]
ANTIPODAL_RATES = schema(ID, LABEL, *_HELD)
"""How often the antipodal, collision-free grasps of an object hold."""

NAIVE_GRASPS = schema(
    ID,
    LABEL,
    text("place", "where the object is: free (in free space) or table"),
    integer("number", "number of the grasp on its object, counted for each place"),
    text(
        "outcome",
        f"{listed(EXECUTION)}; no_grasp: no part of the surface faces up; or "
        f"{listed(SIMULATION_FAILURES)}",
    ),
    text("engine", "physics engine"),
)

_RATES = [
    integer("n_free", "number of naive grasps in free space with an outcome"),
    real(
        "simulated_success_rate",
        "fraction of naive grasps in free space that succeeded in simulation; high for easy "
        "objects",
    ),
    real(
        "simulated_success_rate_std",
        "standard error of this rate; 0 if all grasps succeeded, or none",
    ),
    integer("n_table", "number of naive grasps on a table with an outcome"),
    real("table_success_rate", "fraction of naive grasps on a table that succeeded in simulation"),
    real(
        "table_success_rate_std", "standard error of this rate; 0 if all grasps succeeded, or none"
    ),
    text("naive_engine", "physics engine of the naive grasps"),
]
NAIVE_RATES = schema(ID, LABEL, *_RATES)
"""How often naive grasps of an object succeed."""

SIMULATED_OBJECTS = schema(ID, LABEL, *_RATES, *_HELD)
"""How often grasps of an object succeed in simulation."""

SAMPLING = schema(
    ID,
    LABEL,
    integer("n_wanted", "number of grasps requested"),
    integer("n_candidates", "number of candidates sampled"),
    *(
        integer(name, f"number of candidates rejected: {why}")
        for name, why in (
            ("n_too_wide", "no opposite surface within the opening"),
            ("n_not_antipodal", "second contact faces away from the axis"),
            ("n_blocked", "something blocks the open fingers"),
            ("n_too_close", "too similar to a grasp found before"),
        )
    ),
    integer("n_surplus", "number of candidates not needed: enough grasps had been found"),
    integer("n_grasps", "number of candidates kept: the rows in the table of grasps"),
    integer("n_slipping", "number of grasps with quality 0: the axis leaves a friction cone"),
    integer("n_in_collision", "number of grasps in collision at every approach angle"),
    integer("n_unreachable", "number of grasps that fit but have no collision-free approach"),
)

SCALES = schema(
    LABEL,
    text("rule", "scale rule"),
    real("opening", "opening of the gripper", "m"),
    real("factor", "size after scaling / size before"),
    *vector("before", "sides of the minimum-volume box before scaling, ascending", "m", "123"),
    *vector("after", "sides of the minimum-volume box after scaling, ascending", "m", "123"),
    real(
        "graspable_fraction_before",
        "graspable fraction before scaling: fraction of the surface with opposite surface "
        "along the normal within the opening",
    ),
    real("graspable_fraction_after", "graspable fraction after scaling"),
    text("file", "file of the scaled mesh"),
)

SIZE_EFFECT = schema(
    text("name", "name in the evaluation set, or name of the mesh file"),
    real("fraction", "smallest side of the minimum-volume box / opening"),
    integer("repeat", "number of the repetition; each has different random numbers"),
    integer("candidates", "number of candidates sampled"),
    integer(
        "possible",
        "number of candidates that the open fingers reach and hold, including similar ones; "
        "for another sampler, number of grasps that it gives",
    ),
    integer("grasps", "number of grasps that the percentiles were computed from"),
    real("percentile", "percentile of the quality", "%"),
    real("quality", "quality at this percentile; null without grasps"),
)

FILES = [
    Result("D/rescaled/G/LABEL.obj", "meshes scaled to gripper G, in metres"),
    Result("D/rescaled/G/scales.parquet", "scale factors and sizes of the objects", SCALES),
    Result(
        "D/grasps/G.parquet",
        "labelled grasps of the scaled objects; columns `simulated_*` with "
        "`targets.simulated_labels`, or if an export needs them",
        SIMULATED_GRASPS,
    ),
    Result(
        "D/grasps/G.sampling.parquet",
        "how many candidate grasps were sampled, and why some were rejected",
        SAMPLING,
    ),
    Result(
        "D/naive_grasps/G.parquet",
        "naive grasps of the scaled objects, tried in simulation (`targets.simulated_labels`)",
        NAIVE_GRASPS,
    ),
    Result(
        "D/simulated/G.parquet",
        "how often naive and antipodal grasps of each object succeed in simulation "
        "(`targets.simulated_labels`)",
        SIMULATED_OBJECTS,
    ),
    Result(
        "D/size_effect/G.parquet",
        "grasp quality as a function of size, for an easy, a medium and a hard object",
        SIZE_EFFECT,
    ),
]

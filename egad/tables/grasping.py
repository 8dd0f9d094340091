"""Tables of a gripper: grasps, sampling statistics, and the scales of the objects."""

import pyarrow as pa

from egad.tables.columns import (
    BOOL,
    FLOAT,
    ID,
    INT,
    LABEL,
    QUALITY,
    ROBUST_QUALITY,
    ROBUST_SUCCESS_RATE,
    STRING,
    Result,
    column,
    optional,
    vector,
)
from egad.tables.outcomes import EXECUTION, SHAKEN, SIMULATION_FAILURES, listed

GRASPS = pa.schema(
    [
        ID,
        LABEL,
        column("grasp", INT, "number of the grasp on its object"),
        *vector("center", "midpoint of the contacts; for a cup, a point on the surface", "m"),
        *vector(
            "axis",
            "unit vector from the first contact to the second; for a cup, any unit vector "
            "perpendicular to the approach",
        ),
        *vector("approach", "unit vector along which the hand moves towards the object"),
        column("width", FLOAT, "distance between the contacts; 0 for a cup", "m"),
        column(
            "needed_opening",
            FLOAT,
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
        column(
            "robust_quality_std", FLOAT, "standard deviation of the quality over perturbed copies"
        ),
        ROBUST_SUCCESS_RATE,
        column(
            "fits",
            BOOL,
            "whether the open hand touches nothing at the grasp, at the best of the approach "
            "angles tried",
        ),
        column(
            "collision_free",
            BOOL,
            "whether the open hand touches nothing, neither at the grasp nor on its straight "
            "approach, at the best of the approach angles tried",
        ),
        column("angles_fit", INT, "number of approach angles tried at which the hand fits"),
        column(
            "angles_collision_free", INT, "number of approach angles tried that are collision-free"
        ),
    ]
)


def _motion(phase: str, how: str) -> list[pa.Field]:
    moved = f"how far the object {{}} relative to the hand while {how}"
    return [
        column(f"simulated_{phase}_shift", FLOAT, moved.format("moved"), "m"),
        column(f"simulated_{phase}_turn", FLOAT, moved.format("turned"), "rad"),
    ]


_MOTIONS = [*_motion("closing", "the fingers closed"), *_motion("shaking", "it was shaken")]
MOTIONS = tuple(field.name for field in _MOTIONS)
_SIMULATED = [
    column(
        "simulated_outcome",
        STRING,
        f"outcome of closing in free space, shaking and lifting in simulation: {listed(SHAKEN)}; "
        f"or "
        f"{listed(SIMULATION_FAILURES)}; missing if the grasp was not simulated",
    ),
    column(
        "simulated_success",
        BOOL,
        "whether the object was still held at the end; missing if the engine could not tell, or if "
        "the grasp was not simulated",
    ),
    *_MOTIONS,
    (_ENGINE := column("simulated_engine", STRING, "physics engine")),
]
SIMULATED_GRASPS = pa.schema([*GRASPS, *map(optional, _SIMULATED)])
"""Labelled grasps, with simulated labels if `targets.simulated_labels` is true."""

_HELD = [
    column("n_simulated", INT, "number of simulated antipodal grasps with an outcome"),
    column(
        "antipodal_success_rate",
        FLOAT,
        "fraction of simulated antipodal grasps that held when shaken and lifted; near 1 for most "
        "objects",
    ),
    column("held_shaking", FLOAT, "fraction of simulated antipodal grasps that held when shaken"),
    _ENGINE,
]
ANTIPODAL_RATES = pa.schema([ID, LABEL, *_HELD])
"""How often the antipodal, collision-free grasps of an object hold."""

NAIVE_GRASPS = pa.schema(
    [
        ID,
        LABEL,
        column("place", STRING, "where the object is: free (in free space) or table"),
        column("number", INT, "number of the grasp on its object, counted for each place"),
        column(
            "outcome",
            STRING,
            f"{listed(EXECUTION)}; no_grasp: no part of the surface faces up; or "
            f"{listed(SIMULATION_FAILURES)}",
        ),
        column("engine", STRING, "physics engine"),
    ]
)

_RATES = [
    column("n_free", INT, "number of naive grasps in free space with an outcome"),
    column(
        "simulated_success_rate",
        FLOAT,
        "fraction of naive grasps in free space that succeeded in simulation; high for easy "
        "objects",
    ),
    column(
        "simulated_success_rate_std",
        FLOAT,
        "standard error of this rate; 0 if all grasps succeeded, or none",
    ),
    column("n_table", INT, "number of naive grasps on a table with an outcome"),
    column(
        "table_success_rate",
        FLOAT,
        "fraction of naive grasps on a table that succeeded in simulation",
    ),
    column(
        "table_success_rate_std",
        FLOAT,
        "standard error of this rate; 0 if all grasps succeeded, or none",
    ),
    column("naive_engine", STRING, "physics engine of the naive grasps"),
]
NAIVE_RATES = pa.schema([ID, LABEL, *_RATES])
"""How often naive grasps of an object succeed."""

SIMULATED_OBJECTS = pa.schema([ID, LABEL, *_RATES, *_HELD])
"""How often grasps of an object succeed in simulation."""

SAMPLING = pa.schema(
    [
        ID,
        LABEL,
        column("n_wanted", INT, "number of grasps requested"),
        column("n_candidates", INT, "number of candidates sampled"),
        *(
            column(name, INT, f"number of candidates rejected: {why}")
            for name, why in (
                ("n_too_wide", "no opposite surface within the opening"),
                ("n_not_antipodal", "second contact faces away from the axis"),
                ("n_blocked", "something blocks the open fingers"),
                ("n_too_close", "too similar to a grasp found before"),
            )
        ),
        column("n_surplus", INT, "number of candidates not needed: enough grasps had been found"),
        column("n_grasps", INT, "number of candidates kept: the rows in the table of grasps"),
        column(
            "n_slipping", INT, "number of grasps with quality 0: the axis leaves a friction cone"
        ),
        column("n_in_collision", INT, "number of grasps in collision at every approach angle"),
        column(
            "n_unreachable", INT, "number of grasps that fit but have no collision-free approach"
        ),
    ]
)

SCALES = pa.schema(
    [
        LABEL,
        column("rule", STRING, "scale rule"),
        column("opening", FLOAT, "opening of the gripper", "m"),
        column("factor", FLOAT, "size after scaling / size before"),
        *vector("before", "sides of the minimum-volume box before scaling, ascending", "m", "123"),
        *vector("after", "sides of the minimum-volume box after scaling, ascending", "m", "123"),
        column(
            "graspable_fraction_before",
            FLOAT,
            "graspable fraction before scaling: fraction of the surface with opposite surface "
            "along the normal within the opening",
        ),
        column("graspable_fraction_after", FLOAT, "graspable fraction after scaling"),
        column("file", STRING, "file of the scaled mesh"),
    ]
)

SIZE_EFFECT = pa.schema(
    [
        column("name", STRING, "name in the evaluation set, or name of the mesh file"),
        column("fraction", FLOAT, "smallest side of the minimum-volume box / opening"),
        column("repeat", INT, "number of the repetition; each has different random numbers"),
        column("candidates", INT, "number of candidates sampled"),
        column(
            "possible",
            INT,
            "number of candidates that the open fingers reach and hold, including similar ones; "
            "for another sampler, number of grasps that it gives",
        ),
        column("grasps", INT, "number of grasps that the percentiles were computed from"),
        column("percentile", FLOAT, "percentile of the quality", "%"),
        column("quality", FLOAT, "quality at this percentile; null without grasps"),
    ]
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

"""Every setting of the pipeline, as pydantic models.

The models are the only source of names, defaults, bounds and meanings. `egad.config_files`
generates `config/*.yaml` and the JSON schema from them, and turns validation errors into sentences.
Lengths are metres, masses kilograms, densities kg/m3, forces newtons, angles degrees.
"""

from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, model_validator

Name = Annotated[str, StringConstraints(pattern=r"^[a-z0-9][a-z0-9_\-]*$")]
Fraction = Annotated[float, Field(ge=0, le=1)]
PositiveFraction = Annotated[float, Field(gt=0, le=1)]
Length = Annotated[float, Field(gt=0, le=10)]
Sigma = Annotated[float, Field(ge=0)]
Range = tuple[float, float]
FractionRange = tuple[Fraction, Fraction]
Offset = Annotated[float, Field(ge=-0.5, le=0.5)]
Axis = Literal["x", "y", "z"]
Activation = Literal["sin", "sigmoid", "gaussian", "identity"]
ScaleRule = Literal["paper", "egad-script", "exact"]


class Section(BaseModel):
    """A group of settings: immutable, and closed to keys that it does not know."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def _ascending(section: Section, *names: str) -> None:
    for name in names:
        low, high = getattr(section, name)
        if not low < high:
            raise ValueError(f"{name} must go from low to high, got {low} to {high}")


class Dataset(Section):
    """A set of objects: evolved here, from an archive, or meshes that somebody else made."""

    source: Literal["evolved", "archive", "meshes"] = Field(
        description="`evolved` by this pipeline, from an `archive` that was evolved before, or "
        "`meshes` read from a folder"
    )
    archive: str | None = Field(
        None, description="file of the archive, or `released`: the one shipped (source: archive)"
    )
    folder: str | None = Field(None, description="folder of the meshes (source: meshes)")
    units: Literal["m", "mm", "cm", "inch"] | None = Field(
        None, description="unit of the coordinates in these meshes (source: meshes)"
    )
    pattern: str | None = Field(
        None,
        description="glob of the mesh files, relative to the folder; what its wildcards match "
        "names the objects; nothing: `*`, all in the folder itself (source: meshes)",
    )

    @model_validator(mode="after")
    def _keys_belong_to_the_source(self) -> Self:
        needed = {"evolved": (), "archive": ("archive",), "meshes": ("folder", "units")}
        allowed = {**needed, "meshes": ("folder", "units", "pattern")}
        given = [name for name, value in self if name != "source" and value is not None]
        if any(name not in given for name in needed[self.source]):
            keys = " and ".join(f"`{name}`" for name in needed[self.source])
            raise ValueError(f"a dataset with source `{self.source}` needs {keys}")
        if extra := [name for name in given if name not in allowed[self.source]]:
            raise ValueError(f"a dataset with source `{self.source}` takes no `{extra[0]}`")
        return self


class Targets(Section):
    """What `snakemake --cores 2` makes when no file is named."""

    datasets: list[Name] = Field(
        ["egad"],
        description="datasets taken all the way: grasps, scaling, evaluation set, print, trials",
    )
    grippers: list[Name] = Field(
        ["egad_75mm"], min_length=1, description="grippers of the table below to do this for"
    )
    policies: list[Literal["antipodal-depth"]] = Field(
        ["antipodal-depth"], min_length=1, description="grasp detectors to try in simulation"
    )


class Schedule(Section):
    """How evolution is cut into jobs. More epochs than before extend a finished run."""

    islands: int = Field(
        1, ge=1, le=1024, description="archives that evolve apart within an epoch, then merge"
    )
    epochs: int = Field(3, ge=1, le=200, description="rounds of evolving apart and merging")


class Evolution(Section):
    """Breeding: MAP-Elites over CPPN genomes; config/paper.yaml has the paper's values."""

    steps_per_epoch: int = Field(20, ge=1, description="steps of an island in one epoch")
    population: int = Field(100, ge=1, description="children an island evaluates in one step")
    crossover_probability: Fraction = Field(
        0.5, description="chance that a child has two parents; else it is a mutated copy of one"
    )
    parents: Literal["uniform", "sparse"] = Field(
        "sparse",
        description="how parents are drawn: all alike, or the more often the more places are empty "
        "in their cell and the eight around it",
    )
    siblings: int = Field(1, ge=1, description="children of the same parents, one after another")
    restart: Fraction = Field(0.0, description="chance that a child is a random genome instead")
    regrade: int = Field(
        0,
        ge=0,
        description="grasps that a newcomer to a full cell is graded again by, against lucky "
        "elites; 0: not",
    )


class Neat(Section):
    """Mutation of CPPN genomes (NEAT; the values of the released EGAD code)."""

    activations: list[Activation] = Field(
        ["sin", "sigmoid", "gaussian", "identity"],
        min_length=1,
        description="activation functions a node can have: sin(x), sigmoid(5x), exp(-5x^2), x",
    )
    initial_connections: Fraction = Field(
        0.1, description="part of the inputs that a new genome connects to the output"
    )
    weight_sigma: Sigma = Field(1.0, description="standard deviation of a new weight")
    weight_limit: float = Field(30.0, gt=0, description="weights and biases stay within +- this")
    weight_mutation_rate: Fraction = Field(0.8, description="chance to shift a weight")
    weight_mutation_sigma: Sigma = Field(2.5, description="standard deviation of that shift")
    weight_replacement_rate: Fraction = Field(0.1, description="chance to draw a weight anew")
    bias_sigma: Sigma = Field(1.0, description="standard deviation of a new bias")
    bias_mutation_rate: Fraction = Field(0.7, description="chance to shift a bias")
    bias_mutation_sigma: Sigma = Field(1.0, description="standard deviation of that shift")
    bias_replacement_rate: Fraction = Field(0.2, description="chance to draw a bias anew")
    activation_mutation_rate: Fraction = Field(
        0.1, description="chance that a node draws its activation anew"
    )
    connection_addition_rate: Fraction = Field(0.15, description="chance to add a connection")
    connection_deletion_rate: Fraction = Field(0.15, description="chance to delete a connection")
    connection_toggle_rate: Fraction = Field(
        0.1, description="chance that a connection draws anew whether it is enabled"
    )
    node_addition_rate: Fraction = Field(0.1, description="chance to split a connection by a node")
    node_deletion_rate: Fraction = Field(0.1, description="chance to delete a node")


class Shape(Section):
    """From a genome to a mesh."""

    resolution: int = Field(25, ge=8, le=64, description="voxels along each side of the cube")
    threshold: float = Field(0.5, description="network output above which a voxel is solid")
    smoothing_iterations: int = Field(10, ge=0, le=100, description="rounds of Humphrey smoothing")
    smoothing_alpha: Fraction = Field(0.1, description="Humphrey alpha: pull to the original place")
    smoothing_beta: Fraction = Field(0.25, description="Humphrey beta: smoothing of that pull")
    longest_side: Length = Field(0.1, description="longest axis-aligned side of the mesh, metres")


class Region(Section):
    """A part of the cube that shapes grow in; the cube has sides of 1 and its middle at 0."""

    kind: Literal["none", "box", "ellipsoid", "cylinder", "mesh"] = Field(
        "none", description="its form; a sphere is an ellipsoid with equal sides, none: off"
    )
    size: tuple[PositiveFraction, PositiveFraction, PositiveFraction] = Field(
        (1, 1, 1), description="its sides along x, y, z, as parts of the cube"
    )
    centre: tuple[Offset, Offset, Offset] = Field(
        (0, 0, 0), description="its middle, as parts of the cube from the middle of that"
    )
    axis: Axis = Field("z", description="axis of a cylinder")
    mesh: str = Field(
        "", description="file of a mesh, scaled evenly to fit `size`; its inside counts"
    )

    @model_validator(mode="after")
    def _a_mesh_has_a_file(self) -> Self:
        if (self.kind == "mesh") != bool(self.mesh):
            raise ValueError(
                f"kind is {self.kind} and mesh is {self.mesh!r}; `kind: mesh` and a file belong "
                "together"
            )
        return self


class Envelope(Region):
    """What shapes must stay in, but for their part."""


class Part(Region):
    """What every shape must contain, but for the hole. It may stick out of the envelope."""


class Hole(Region):
    """What must stay empty."""


class Symmetry(Section):
    """Symmetry that shapes must have. Mirrors hold for envelope, part and hole too."""

    mirror: tuple[Axis, ...] = Field(
        (), description="axes across which the two halves of a shape are mirror images"
    )
    fold: int = Field(1, ge=1, le=32, description="how often a shape repeats itself in a full turn")
    axis: Axis = Field("z", description="axis of that turn")


class Limits(Section):
    """Shapes outside are rejected before they are measured."""

    aspect_ratio: Range = Field(
        (1, 64), description="longest by shortest side of the axis-aligned box, in voxels"
    )
    box_part: FractionRange = Field((0, 1), description="volume as part of that box")
    cube_part: FractionRange = Field((0, 1), description="volume as part of the cube")

    @model_validator(mode="after")
    def _ranges_ascend(self) -> Self:
        _ascending(self, "aspect_ratio", "box_part", "cube_part")
        if self.aspect_ratio[1] < 1:
            raise ValueError("aspect_ratio must reach 1 at least: no box is shorter than itself")
        return self


class Space(Section):
    """The two axes that objects are spread over, and the archive of their elites."""

    complexity_range: Range = Field((1.0, 5.0), description="complexities that the cells span")
    difficulty_range: Range = Field(
        (0.0005, 0.004), description="grasp qualities that the cells span: high is easy"
    )
    cells: int = Field(25, ge=1, le=26, description="cells along each axis")
    elites_per_cell: int = Field(4, ge=1, le=255, description="most objects kept in a cell")
    neighbours: int = Field(
        10, ge=1, description="diversity is the mean distance to this many nearest objects"
    )

    @model_validator(mode="after")
    def _ranges_ascend(self) -> Self:
        _ascending(self, "complexity_range", "difficulty_range")
        return self


class Axes(Section):
    """Measures of your own as the axes of the space, in the place of complexity or difficulty.

    `FILE.py:FUNCTION` or `package.module:FUNCTION` names a function from a closed
    `trimesh.Trimesh` in metres to a number.
    """

    complexity: str = Field("", description="in the place of complexity; empty: none")
    difficulty: str = Field(
        "", description="in the place of difficulty, high values in row A; empty: none"
    )

    @model_validator(mode="after")
    def _functions_are_named(self) -> Self:
        for key, text in self:
            module, _, function = text.rpartition(":")
            if text and not (module and function.isidentifier()):
                raise ValueError(
                    f"{key} is {text!r}; allowed: FILE.py:FUNCTION or package.module:FUNCTION"
                )
        return self


class Complexity(Section):
    """Shape complexity: the entropy of the angular deficits of the vertices."""

    bins: int = Field(512, ge=2, description="histogram bins over [-2 pi, 2 pi)")


class Similarity(Section):
    """Shape similarity: matching of multiresolutional Reeb graphs."""

    vertices: int = Field(4000, ge=4, description="split edges until a mesh has this many vertices")
    ranges: Literal[16, 32, 64, 128, 256] = Field(128, description="ranges of the finest graph")
    bases: Literal["even", "scan"] = Field(
        "even", description="`even`: farthest points; `scan`: the original's walk in vertex order"
    )
    base_count: int = Field(50, ge=1, description="number of bases (even)")
    base_coefficient: float = Field(
        0.005, gt=0, description="bases lie sqrt(this * area) apart (scan)"
    )
    weight: Fraction = Field(0.5, description="weight of area against length in a node's value")


class Quality(Section):
    """Ferrari-Canny grasp quality, one deterministic value a grasp."""

    friction: float = Field(0.5, gt=0, le=2, description="Coulomb friction coefficient")
    torque_scaling: float = Field(100.0, gt=0, description="torque units a force unit, 1/m")
    finger_radius: Length = Field(0.005, description="radius of the soft finger's contact, metres")
    cone_faces: int = Field(8, ge=3, le=24, description="edges of a linearised friction cone")


class Robust(Section):
    """The same quality under uncertainty: the mean over disturbed copies of a grasp."""

    samples: int = Field(25, ge=1, description="disturbed copies of a grasp")
    torque_scaling: float = Field(1000.0, gt=0, description="torque units a force unit, 1/m")
    grasp_translation_sigma: Sigma = Field(0.001, description="grasp centre, metres an axis")
    grasp_rotation_sigma: Sigma = Field(0.001, description="grasp axis, radians an axis")
    object_translation_sigma: Sigma = Field(0.005, description="object position, metres an axis")
    object_rotation_sigma: Sigma = Field(0.01, description="object rotation, radians an axis")
    com_sigma: Sigma = Field(0.01, description="centre of mass, metres an axis")
    friction_sigma: Sigma = Field(0.1, description="friction coefficient")


class Sampling(Section):
    """Antipodal grasp sampler."""

    cone: float = Field(
        0.75, gt=0, le=2, description="tangent of the widest angle between axis and normals"
    )
    spacing: float = Field(
        0.0025, ge=0, description="least distance of two grasps, metres; 4.5 degrees count 2.5 mm"
    )
    candidates: int = Field(200, ge=1, description="candidate axes drawn in one round")
    rounds: int = Field(10, ge=1, description="most rounds until enough grasps are found")
    approach_clearance: float = Field(
        0.1, ge=0, description="open fingers must reach their place from this far, metres; 0: off"
    )


class Difficulty(Section):
    """Grasp difficulty: a percentile of the quality of sampled grasps. High values are easy."""

    gripper: Name = Field("yumi", description="gripper of the table that grasps are sampled for")
    metric: Literal["plain", "robust"] = Field(
        "plain",
        description="quality of a grasp, or its mean over disturbed copies; the published letters "
        "follow the plain one (rank correlation 0.94 against 0.43, docs/measures.md)",
    )
    grasps: int = Field(100, ge=1, description="grasps sampled while evolving")
    percentile: float = Field(75, ge=0, le=100, description="percentile of the qualities, percent")
    side_fraction: PositiveFraction = Field(
        0.8, description="objects are scaled until their smallest side is this part of the opening"
    )


class Material(Section):
    """What the objects are made of."""

    density: float = Field(400.0, gt=0, description="kg/m3; printed PLA at 20 % infill: 350-450")


class Postprocess(Section):
    """Repair, and difficulty graded again without the luck of selection."""

    grasps: int = Field(1000, ge=1, description="grasps that an object is graded by")
    min_volume: float = Field(1e-9, ge=0, description="objects smaller than this are rejected, m3")


class GraspLabel(Section):
    """Labelled grasps."""

    grasps: int = Field(100, ge=1, description="most grasps an object")


class Rescale(Section):
    """Scaling to a gripper."""

    rule: ScaleRule = Field(
        "paper",
        description="paper: smallest side at most the fraction; egad-script: longest side = "
        "opening, then as paper; exact: smallest side = the fraction",
    )
    side_fraction: PositiveFraction = Field(
        0.8, description="part of the opening that the rule aims at"
    )


class SelectEval(Section):
    """The evaluation set: one object a cell of a coarse grid, chosen to look least alike."""

    rows: int = Field(7, ge=1, le=26, description="rows = letters = difficulty")
    columns: int = Field(7, ge=1, le=10, description="columns = digits = complexity")
    restarts: int = Field(20, ge=1, description="random starts of the local search")


class PrintExport(Section):
    """Files for 3D printers."""

    bed: tuple[Length, Length] = Field((0.22, 0.22), description="print bed, metres")
    gap: float = Field(0.005, ge=0, description="free space between objects on a plate, metres")


class Trials(Section):
    """Simulated grasping trials."""

    attempts: int = Field(20, ge=1, description="attempts an object")
    image_size: int = Field(300, ge=16, le=2048, description="pixels a side of the depth image")
    camera_height: Length = Field(0.6, description="camera above the table, metres")
    field_of_view: float = Field(40.0, gt=1, lt=170, description="degrees, both ways")
    lift_height: Length = Field(0.4, description="an object held this high counts, metres")
    hold_time: float = Field(1.0, ge=0, description="seconds that it must stay held up there")
    max_parts: int = Field(64, ge=1, description="most convex parts of an object")
    volume_error: float = Field(
        0.06, gt=0, lt=1, description="splitting into convex parts stops below this error"
    )


class Gripper(Section):
    """A parallel-jaw gripper."""

    opening: Length = Field(description="widest opening, metres")
    finger_length: Length = Field(0.04, description="from palm to fingertip, metres")
    finger_width: Length = Field(0.02, description="of a finger across both axes, metres")
    finger_thickness: Length = Field(0.01, description="of a finger along the closing axis, metres")
    palm: tuple[Length, Length, Length] = Field(
        (0.1, 0.06, 0.05),
        description="palm box, metres: along the closing axis, across it, along the approach",
    )
    force: float = Field(40.0, gt=0, description="closing force, newtons")
    friction: float = Field(0.5, gt=0, le=2, description="finger friction in simulation")


_PANDA_PALM = (0.2, 0.063, 0.06)
GRIPPERS = {
    "yumi": Gripper(opening=0.05, finger_length=0.035, force=20),
    "panda": Gripper(
        opening=0.08, finger_length=0.0445, finger_width=0.021, palm=_PANDA_PALM, force=70
    ),
    "egad_75mm": Gripper(opening=0.075, finger_length=0.06, palm=_PANDA_PALM, force=70),
    "robotiq_2f_85": Gripper(
        opening=0.085,
        finger_length=0.038,
        finger_width=0.022,
        palm=(0.15, 0.075, 0.09),
        force=100,
    ),
    "robotiq_2f_140": Gripper(
        opening=0.14,
        finger_length=0.065,
        finger_width=0.027,
        palm=(0.2, 0.075, 0.09),
        force=80,
    ),
}


class Settings(Section):
    """The whole configuration."""

    seed: int = Field(0, ge=0, lt=2**32, description="every random draw follows from this number")
    shards: int = Field(
        8, ge=1, le=1024, description="jobs a dataset is cut into; does not change any result"
    )
    datasets: dict[Name, Dataset] = Field(
        {"egad": Dataset(source="evolved")}, min_length=1, description="all datasets, by name"
    )
    targets: Targets = Targets()
    schedule: Schedule = Schedule()
    evolution: Evolution = Evolution()
    neat: Neat = Neat()
    shape: Shape = Shape()
    envelope: Envelope = Envelope()
    part: Part = Part()
    hole: Hole = Hole()
    symmetry: Symmetry = Symmetry()
    limits: Limits = Limits()
    space: Space = Space()
    axes: Axes = Axes()
    complexity: Complexity = Complexity()
    difficulty: Difficulty = Difficulty()
    similarity: Similarity = Similarity()
    sampling: Sampling = Sampling()
    quality: Quality = Quality()
    robust: Robust = Robust()
    material: Material = Material()
    postprocess: Postprocess = Postprocess()
    grasp_label: GraspLabel = GraspLabel()
    rescale: Rescale = Rescale()
    select_eval: SelectEval = SelectEval()
    print_export: PrintExport = PrintExport()
    trials: Trials = Trials()
    grippers: dict[Name, Gripper] = Field(
        GRIPPERS, min_length=1, description="all grippers, by name"
    )

    @model_validator(mode="after")
    def _names_refer_to_something(self) -> Self:
        problems = [
            *_unknown("targets.datasets", self.targets.datasets, self.datasets),
            *_unknown("targets.grippers", self.targets.grippers, self.grippers),
            *_unknown("difficulty.gripper", [self.difficulty.gripper], self.grippers),
        ]
        evolved = [name for name, data in self.datasets.items() if data.source == "evolved"]
        if len(evolved) > 1:
            problems.append(f"datasets: at most one can be evolved, got {', '.join(evolved)}")
        if problems:
            raise ValueError("\n".join(problems))
        return self


def _unknown(key: str, used: list[str], table: Mapping[str, Section]) -> list[str]:
    return [
        f"{key}: {name!r} is not defined; known: {', '.join(sorted(table))}"
        for name in used
        if name not in table
    ]

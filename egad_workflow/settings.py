"""Every setting: the sections of the library, and those of runs; `select` picks those of a stage.

The models are the only source of names, defaults, bounds and meanings: `check.py` says what is
wrong with a configuration, `manual.py` lists them all in `config/README.md`. Lengths are metres,
masses kilograms, densities kg/m3, forces newtons, angles degrees.
"""

from typing import Any, TypeVar

from pydantic import Field

from egad._util.parameters import Name, ParameterGroup, Parameters, Seed
from egad.bench import PLANNING_TIME, Clutter, NaiveGrasp, PlanningTime, TrialProtocol
from egad.bench.failures import FailureSearch
from egad.detectors import DETECTORS, DetectorConfig, ImageNoise
from egad.evalset import PrintCheck, PrintExport, SelectEval
from egad.evolution import (
    Envelope,
    Evolution,
    EvolutionParameters,
    Hole,
    KeepSolid,
    Limits,
    Neat,
    Shape,
    Symmetry,
)
from egad.exchange import EVALUATION_SET, Acronym, DexNet, Format, ObjectSet
from egad.exchange.release import Release
from egad.geometry import Bundle, Material, Rescale
from egad.grasps import GraspLabel, LabelParameters, Quality, Robust, Sampling
from egad.grippers import GRIPPERS, Gripper
from egad.learning import Training
from egad.learning.images import CAMERAS, Camera, Render
from egad.learning.scenes import TrainingScenes
from egad.measures import (
    Complexity,
    CustomMeasures,
    Graspability,
    MeasureParameters,
    MeasureSpace,
    Postprocess,
    SizeEffect,
    SizeEffectParameters,
    space_of,
)
from egad.measures.reeb import Similarity
from egad.sim import LabelAgreement, SimulatedLabel
from egad_workflow.datasets import DatasetSection

MAX_EPOCHS = 200
EPOCH = 10_000  # evaluations of an island; the paper's archive took 20 epochs


class Schedule(Parameters):
    """How the evaluations of evolution are divided into jobs."""

    islands: int = Field(1, ge=1, le=1024)
    """archives that evolve independently within an epoch and are then merged"""
    epochs: int | None = Field(None, ge=1, le=MAX_EPOCHS)
    """rounds of independent evolution and merging; nothing: one for every 10,000 evaluations of an
    island, so each further 10,000 extend a finished run"""


class Targets(Parameters):
    """What `snakemake --cores 2` makes if no file is named."""

    datasets: list[Name] = Field(["egad"])
    """datasets that run through the whole pipeline: grasps, scaling, evaluation set, prints,
    trials"""
    grippers: list[Name] = Field(["egad_75mm"], min_length=1)
    """grippers to make results for, from the table `grippers`"""
    detectors: list[Name] = Field(["antipodal-depth"], min_length=1)
    """grasp detectors to test in simulated trials, from the table `detectors`"""
    clutter: list[Name] = Field([])
    """grasp detectors to test on clearing tables with several objects, from the table
    `detectors`"""
    failures: list[Name] = Field([])
    """grasp detectors whose failures to search for, from the table `detectors`; a failure is an
    object of the datasets, or a child of one, that can be grasped but that the detector does not
    grasp"""
    exports: list[Format] = Field([])
    """formats to export for other programs: objects, labelled grasps, or rendered images with
    grasps"""
    export_objects: ObjectSet = EVALUATION_SET
    """which objects to export, in formats for objects"""
    graspability: bool = False
    """whether to measure the graspability of all objects for each gripper"""
    agreement: bool = False
    """whether to execute a sample of the labelled grasps in simulation"""
    simulated_labels: bool = False
    """whether to simulate labelled grasps of all objects; always done if `exports` has acronym,
    graspgen, graspnet, isaac_grasp or simready"""
    render: bool = False
    """whether to render depth images with grasps for training"""
    scenes: bool = False
    """whether to make packed and piled scenes with depth images and grasps labelled by simulation,
    for training"""


class Settings(Parameters):
    """The whole configuration."""

    seed: Seed = 0
    """seed of all random numbers"""
    shards: int = Field(4, ge=1, le=1024)
    """jobs per dataset; does not change any result"""
    planning_time: PlanningTime = PLANNING_TIME
    keep_going: bool = False
    """whether to continue with a detector that fails in every attempt at the first three objects,
    or of the first three rounds"""
    datasets: dict[Name, DatasetSection] = Field(
        {"egad": DatasetSection(source="evolved")}, min_length=1
    )
    """all datasets, by name"""
    targets: Targets = Targets()
    schedule: Schedule = Schedule()
    evolution: Evolution = Evolution()
    neat: Neat = Neat()
    shape: Shape = Shape()
    envelope: Envelope = Envelope()
    keep_solid: KeepSolid = KeepSolid()
    hole: Hole = Hole()
    symmetry: Symmetry = Symmetry()
    limits: Limits = Limits()
    space: MeasureSpace = MeasureSpace()
    measures: CustomMeasures = CustomMeasures()
    complexity: Complexity = Complexity()
    graspability: Graspability = Graspability()
    similarity: Similarity = Similarity()
    sampling: Sampling = Sampling()
    quality: Quality = Quality()
    robust: Robust = Robust()
    material: Material = Material()
    postprocess: Postprocess = Postprocess()
    grasp_label: GraspLabel = GraspLabel()
    size_effect: SizeEffect = SizeEffect()
    rescale: Rescale = Rescale()
    select_eval: SelectEval = SelectEval()
    print_check: PrintCheck = PrintCheck()
    print_export: PrintExport = PrintExport()
    bundle: Bundle = Bundle()
    dexnet: DexNet = DexNet()
    acronym: Acronym = Acronym()
    trials: TrialProtocol = TrialProtocol()
    clutter: Clutter = Clutter()
    failures: FailureSearch = FailureSearch()
    simulated_label: SimulatedLabel = SimulatedLabel()
    naive_grasp: NaiveGrasp = NaiveGrasp()
    agreement: LabelAgreement = LabelAgreement()
    training: Training = Training()
    render: Render = Render()
    image_noise: ImageNoise = ImageNoise()
    scenes: TrainingScenes = TrainingScenes()
    release: Release = Release()
    grippers: dict[Name, Gripper] = Field(GRIPPERS, min_length=1)
    """all grippers, by name"""
    cameras: dict[Name, Camera] = Field(CAMERAS, min_length=1)
    """all cameras of rendered images, by name"""
    detectors: dict[Name, DetectorConfig] = Field(DETECTORS, min_length=1)
    """all grasp detectors, by name"""

    @property
    def epochs(self) -> int:
        """Number of epochs of evolution."""
        of_an_island = -(-self.evolution.evaluations // self.schedule.islands)
        return self.schedule.epochs or min(-(-of_an_island // EPOCH), MAX_EPOCHS)

    @property
    def evolution_of_epoch(self) -> Evolution:
        """The section `evolution` for one island in one epoch, which evolves in whole steps."""
        shared = self.schedule.islands * self.epochs * self.evolution.population
        steps = -(-self.evolution.evaluations // shared)
        evaluations = steps * self.evolution.population
        return self.evolution.model_copy(update={"evaluations": evaluations})


S = TypeVar("S", bound=ParameterGroup)


def select(
    settings: Settings, stage: type[S], gripper: str | None = None, detector: str | None = None
) -> S:
    """The part of a configuration that a stage reads, one gripper or detector for some."""
    entries = ("gripper", "map_gripper", "camera", "detector", "density", "labels", "breeding")
    names = [name for name in stage.model_fields if name not in entries]
    # naive grasps share the engine of simulated labels, but not their number
    engine = SimulatedLabel(engine=settings.simulated_label.engine)
    labels = engine if "naive_grasp" in names else settings.simulated_label
    evolution = settings.evolution_of_epoch
    shared = settings.model_copy(update={"evolution": evolution, "simulated_label": labels})
    values = {name: getattr(shared, name) for name in names}
    if "gripper" in stage.model_fields:
        chooses = "select_eval" in values
        # an evaluation set must be printable for the narrowest gripper, if none is named
        narrowest = min(settings.grippers, key=lambda name: settings.grippers[name].opening)
        printed_for = settings.select_eval.gripper or narrowest
        own = printed_for if chooses else settings.graspability.gripper
        values["gripper"] = settings.grippers[gripper or own]
        lifts = values["gripper"].kind.lifts
        # settings that change nothing are left out: stages would run again for them
        robust = issubclass(stage, MeasureParameters) and settings.graspability.metric == "robust"
        if issubclass(stage, MeasureParameters | SizeEffectParameters) and not (lifts or robust):
            values["robust"] = None
        if "density" in stage.model_fields:
            values["density"] = settings.material.density if lifts else Material().density
        if "space" in stage.model_fields:
            # cells of an evaluation set are those of the map, whatever it is printed for
            values["space"] = (
                settings.space if chooses else space_of(values["gripper"], settings.space)
            )
    if "map_gripper" in stage.model_fields:
        values["map_gripper"] = settings.grippers[settings.graspability.gripper]
    if "camera" in stage.model_fields:
        values["camera"] = settings.cameras[settings.render.camera]
    if "labels" in stage.model_fields:
        values["labels"] = select(settings, LabelParameters, gripper)
    if "breeding" in stage.model_fields:
        values["breeding"] = select(settings, EvolutionParameters)
    if "detector" in stage.model_fields:
        values["detector"] = settings.detectors[detector or settings.targets.detectors[0]]
    return stage(**values)


def plain(part: Parameters) -> dict[str, Any]:
    """Settings as plain values for a rule."""
    return part.model_dump(mode="json")

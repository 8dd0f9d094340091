"""The whole configuration."""

from pydantic import Field

from egad._util.parameters import Name, Parameters, Seed
from egad.bench import Clutter, NaiveGrasp, TrialProtocol
from egad.bench.failures import FailureSearch
from egad.config.sections import DatasetSection, Postprocess, Release, Schedule, Targets
from egad.detectors import DETECTORS, DetectorConfig, ImageNoise
from egad.evalset import Engraving, PrintCheck, PrintExport, SelectEval
from egad.evolution import Envelope, Evolution, Hole, KeepSolid, Limits, Neat, Shape, Symmetry
from egad.exchange import Acronym, DexNet
from egad.geometry import Bundle, Material, Rescale
from egad.grasps import GraspLabel, Quality, Robust, Sampling
from egad.grippers import GRIPPERS, Gripper
from egad.learning import Training, VgnTraining
from egad.learning.images import CAMERAS, Camera, Render
from egad.learning.scenes import TrainingScenes
from egad.measures import Complexity, CustomMeasures, Graspability, MeasureSpace, SizeEffect
from egad.measures.reeb import Similarity
from egad.sim import LabelAgreement, SimulatedLabel


class Settings(Parameters):
    """The whole configuration."""

    seed: Seed = Field(0, description="seed of all random numbers")
    shards: int = Field(
        4, ge=1, le=1024, description="jobs per dataset; does not change any result"
    )
    datasets: dict[Name, DatasetSection] = Field(
        {"egad": DatasetSection(source="evolved")},
        min_length=1,
        description="all datasets, by name",
    )
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
    engraving: Engraving = Engraving()
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
    training_vgn: VgnTraining = VgnTraining()
    render: Render = Render()
    image_noise: ImageNoise = ImageNoise()
    scenes: TrainingScenes = TrainingScenes()
    release: Release = Release()
    grippers: dict[Name, Gripper] = Field(
        GRIPPERS, min_length=1, description="all grippers, by name"
    )
    cameras: dict[Name, Camera] = Field(
        CAMERAS, min_length=1, description="all cameras of rendered images, by name"
    )
    detectors: dict[Name, DetectorConfig] = Field(
        DETECTORS, min_length=1, description="all grasp detectors, by name"
    )

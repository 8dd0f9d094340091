from .api import Measures as Measures
from .api import convex_parts as convex_parts
from .api import measure as measure
from .api import rescale as rescale
from .api import sample_grasps as sample_grasps
from .api import similarity as similarity
from .api import similarity_matrix as similarity_matrix
from .api import stable_poses as stable_poses
from .exchange.grasps import load_grasps as load_grasps
from .export import export as export
from .geometry.repair import repair as repair
from .grasps.grasps import Grasps as Grasps
from .grasps.gripper import Gripper as Gripper
from .grasps.gripper import gripper as gripper
from .map_elites.archive import Archive as Archive
from .map_elites.evolver import Evolver as Evolver
from .map_elites.evolver import evolve as evolve
from .objects import Dataset as Dataset
from .objects import EvolvedObject as EvolvedObject
from .objects import load as load
from .report.pictures import render as render
from .trials import Trials as Trials
from .trials import run_trials as run_trials

__version__: str

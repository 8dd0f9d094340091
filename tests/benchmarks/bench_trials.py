"""How fast trials are and where their time goes, in CPU time on one core: `make bench`.

The objects are ten of the released ones, from all over the 7 x 7 grid, scaled to the gripper.
"""

import time
from collections import Counter

import pytest
from timing import timed

from egad.bench import SimulatedTrials, TrialRunner, run_attempts
from egad.data import released
from egad.detectors.registry import QUICK
from egad.evalset.selection import candidates_by_cell
from egad.evolution import packed_surface
from egad.geometry.repair import repair
from egad.geometry.scaling import rescale
from egad.sim import execution
from egad.sim.jaws import Hand
from egad.sim.model import build
from egad.sim.parameters import ENGINES
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE
from egad_workflow.settings import Settings, select

SETTINGS = Settings.model_validate({"trials": {"attempts": 5}})
GRIPPER = "egad_75mm"
STEPS = {
    "settling": (TrialRunner, "_settled"),
    "rendering": (TrialRunner, "render_view"),
    "planning": (TrialRunner, "_plan"),
    "building the hand": (execution, "place_hand_above"),
    "approaching": (Hand, "move"),
    "closing": (Hand, "close"),
    "lifting": (Hand, "lift"),
    "holding": (Hand, "hold"),
}


@pytest.fixture(scope="module")
def models():
    archive = parquet.read(released(), ARCHIVE)
    cells = candidates_by_cell(archive, SETTINGS.select_eval, SETTINGS.space)
    opening, density = SETTINGS.grippers[GRIPPER].opening, SETTINGS.material.density
    found = []
    for cell in list(cells.values())[::5]:
        mesh = repair(packed_surface(archive.iloc[cell[0]]["voxels"], SETTINGS.shape)).mesh
        found.append(build(rescale(mesh, "paper", opening, 0.8)[0], density, SETTINGS.bundle))
    return found


@pytest.mark.parametrize("arm", ["axis", "panda"])
@pytest.mark.parametrize("engine", ENGINES)
def test_an_attempt(models, engine, arm, monkeypatch):
    pytest.importorskip(engine)
    settings = select(SETTINGS, SimulatedTrials, GRIPPER, "antipodal-depth")
    changed = settings.trials.model_copy(update={"arm": arm, "engine": engine})
    settings = settings.model_copy(update={"trials": changed})
    spent, running = Counter(), []
    for step, (owner, name) in STEPS.items():
        monkeypatch.setattr(owner, name, timed(getattr(owner, name), step, spent, running))
    start = time.process_time()
    tables = [
        run_attempts(model, "A0", str(number), QUICK["antipodal-depth"], settings)
        for number, model in enumerate(models)
    ]
    total = time.process_time() - start
    spent["the rest"] = total - sum(spent.values())
    count, held = (sum(map(each, tables)) for each in (len, lambda table: table["success"].sum()))
    print(f"\n{engine}, {arm}: {count / total:.2f} attempts/s, {held} of {count} held")
    for step, seconds in spent.most_common():
        print(f"{1000 * seconds / count:8.1f} ms  {step}")

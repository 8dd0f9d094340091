"""The archive that is shipped: whole, and what the code makes of it."""

from pathlib import Path

import numpy as np
import pytest

import egad
from egad._util.workers import workers
from egad.data import released, released_ancestry, released_simulated
from egad.evolution import UNBOUND, Elite, EvolutionParameters, express, packed_surface, voxels
from egad.evolution.evaluation import GenomeVoxels, measure, refine
from egad.measures.grid import complexity_cells, difficulty_cells, labels
from egad.measures.reeb import diversities
from egad.measures.reeb import graph as reeb
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE, GENOME, LINEAGE
from egad.tables.grasping import ANTIPODAL_RATES
from egad_workflow.archive_settings import check_provenance
from egad_workflow.config_files import read_values
from egad_workflow.settings import Settings, select

SETTINGS = Settings.model_validate(read_values(Path(__file__).parents[1] / "config/full.yaml"))
EVOLVE = select(SETTINGS, EvolutionParameters)


@pytest.fixture(scope="module")
def archive():
    return parquet.read(released(), ARCHIVE)


@pytest.fixture(scope="module")
def ancestry():
    return parquet.read(released_ancestry(), LINEAGE)


def text(name):
    return (Path(__file__).parents[1] / name).read_text(encoding="utf-8")


def sample(archive, count):
    return archive.iloc[np.linspace(0, len(archive) - 1, count).astype(int)].to_dict("records")


def test_it_was_made_with_the_settings_that_ship():
    assert parquet.notes(released())
    check_provenance(released(), EVOLVE)


def test_cells_slots_and_ids_follow_from_the_rest(archive):
    space = SETTINGS.space
    assert (complexity_cells(archive["complexity"], space) == archive["complexity_cell"]).all()
    assert (difficulty_cells(archive["graspability"], space) == archive["difficulty_cell"]).all()
    assert archive.groupby(["complexity_cell", "difficulty_cell"]).size().max() <= 4
    assert archive["id"].is_unique
    assert len(set(labels(archive["complexity_cell"], archive["difficulty_cell"]))) == len(archive)
    for row in sample(archive, 50):
        assert voxels.identity(voxels.unpack(row["voxels"], 25)) == row["id"]


def test_it_is_as_large_and_diverse_as_its_data_card_says(archive):
    place = len(archive) / (SETTINGS.space.cells**2 * SETTINGS.space.elites_per_cell)
    assert place >= 0.85
    values = [archive["diversity"].agg(kind) for kind in ("min", "max", "mean")]
    row = " | ".join(
        [str(len(archive)), f"{100 * place:.1f} %", *(f"{each:.2f}" for each in values)]
    )
    assert f"| released, as evolution selected them | {row} |" in text("docs/released.md")


def test_it_holds_what_its_data_card_says(archive, ancestry):
    card = text("docs/released.md")
    founders = (ancestry["parents"].map(len) == 0).sum()
    filled = len(archive.groupby(["complexity_cell", "difficulty_cell"]))
    assert f"| objects | {len(archive)} watertight solids" in card
    assert f"of {len(ancestry)} objects" in card
    assert f"the {founders} random genomes" in card
    assert f"{filled} of the 625 cells" in card


def test_the_ancestry_holds_its_objects_as_they_are_and_their_ancestors_alone(archive, ancestry):
    rows = ancestry.set_index("id")
    for name in ("complexity", "graspability", "graspability_std", "cell_confidence"):
        assert (rows.loc[archive["id"], name].to_numpy() == archive[name].to_numpy()).all()
    parents = {parent for each in ancestry["parents"] for parent in each}
    assert set(ancestry["id"]) == parents | set(archive["id"])


def check_measures(rows):
    for row in rows:
        first = measure(GenomeVoxels(row["id"], row["voxels"]), EVOLVE)
        # measured before the rounding of coordinates counted, which moves it by at most 0.0044
        assert first.complexity == pytest.approx(row["complexity"], abs=0.0045)
        kept = Elite(row["id"], {}, row["voxels"], first.complexity, 0.0, first.graph, (), 0)
        found = refine(kept, EVOLVE)
        for name in ("graspability", "graspability_std", "cell_confidence"):
            assert getattr(found, name) == pytest.approx(row[name], rel=1e-6)


def test_its_measures_are_what_the_code_computes(archive):
    check_measures(sample(archive, 20))


@pytest.mark.slow
def test_all_its_measures_are_what_the_code_computes(archive):
    check_measures(archive.to_dict("records"))


@pytest.mark.slow
def test_its_diversities_are_what_the_code_computes(archive):
    with workers(2) as mapper:
        packed = mapper(_graph, archive["voxels"])
        graphs = [reeb.unpack(graph) for graph in packed]
    found = diversities(graphs, SETTINGS.similarity.weight, SETTINGS.space.neighbors)
    assert found == pytest.approx(archive["diversity"].to_numpy(), abs=1e-6)


def _graph(packed):
    return reeb.pack(reeb.extract(packed_surface(packed, SETTINGS.shape), SETTINGS.similarity))


def test_genomes_express_the_voxels(archive):
    """But for voxels at the threshold, where the last bit of a sine decides."""
    rows = sample(archive, 60)
    found = [express({name: row[name] for name in GENOME.names}, EVOLVE, UNBOUND) for row in rows]
    same = [solid.id == row["id"] for solid, row in zip(found, rows, strict=True)]
    assert np.mean(same) >= 0.9


def test_the_simulated_grasps_are_those_of_the_released_objects(archive):
    table = parquet.read(released_simulated(), ANTIPODAL_RATES)
    assert set(table["id"]) == set(archive["id"])
    assert (table["n_simulated"] == 100).all()
    assert (table["antipodal_success_rate"] <= table["held_shaking"]).all()
    assert table["held_shaking"].between(0, 1).all()
    loaded = egad.load("released").table.set_index("id")
    expected = table.set_index("id").loc[loaded.index]
    for name in ("antipodal_success_rate", "held_shaking"):
        assert loaded[name].tolist() == expected[name].tolist()
    assert "antipodal_success_rate" not in egad.load(released()).table

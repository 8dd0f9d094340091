"""Archives that this version did not write."""

import pyarrow as pa

from egad.config import Settings
from egad.config.archive_settings import provenance
from egad.config.stages import select
from egad.map_elites.parameters import EvolutionParameters
from egad.tables import parquet
from egad.tables.evolution import EPOCH


def write_first_edition(path):
    """An archive with the columns and notes that the first edition had."""
    settings = select(Settings.model_validate({"space": {"confidence": 0}}), EvolutionParameters)
    columns = [field for field in EPOCH if b"optional" not in field.metadata]
    schema = pa.schema(columns)
    notes = provenance(settings)
    notes["difficulty"] = {"grasps": 100, "percentile": 75.0}
    notes["evolution"] = {"reevaluation_grasps": 0}
    del notes["space"]["confidence"]
    parquet.write(parquet.empty(schema), schema, path, notes)
    return path

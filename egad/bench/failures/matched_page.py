"""What the datasheet of a matched set says about its pairs."""

from typing import Any

from egad._util.markdown import table
from egad.bench.failures.matched import ROW, MatchedSet, percent
from egad.bench.failures.matching import REFERENCE
from egad.evalset import label_at
from egad.tables import parquet

PAGE = """# Matched set of {name}

Failures of the detector {detector}, and for each a partner: the most similar object that it
grasps, of those at most {within} cells away in complexity and in graspability. Row A has the
failures, row B their partners: A0 and B0 are a pair, A1 and B1, and so on. Columns go from simple
to complex failures. `contact-sheet.pdf` shows all objects on one page.

The failures were found by a search, in simulation. Then the detector and a reference, which knows
where the object lies, tried all objects {attempts} times from the same poses in each physics
engine. Nothing was chosen based on these attempts, so their rates are not biased by the search:

{rates}

{pairs}
The similarity of the two shapes of a pair is that of `egad.similarity`. `pairs.parquet` has these
counts, and `attempts.parquet` all attempts.

{chosen}

`archive.parquet` has the genomes and voxels of all objects. They are not a sample of any population
of objects: the failures show where the detector fails, not how often.

## On a robot

Try both objects of a pair equally often, in the random order of `log.html`, and compare the rates
of rows A and B. A robot has no reference: to show that a failure can be grasped, use a detector
that grasps it, or guide the hand.

## The objects
"""


def introduction(found: MatchedSet, name: str, detector: str) -> str:
    """The first part of the datasheet of a set, as Markdown."""
    engines = found.engines
    columns = [
        "label",
        "partner",
        "similarity",
        *(f"{who}, {engine}" for engine in engines for who in ("detector", "reference")),
    ]
    return PAGE.format(
        name=name,
        detector=detector,
        within=found.rules.within,
        attempts=int(found.table[f"n_pairs_{engines[0]}"].iloc[0]),
        rates="\n".join(_rates(found, engine) for engine in engines),
        pairs=table(columns, [_cells(row, engines) for row in parquet.records(found.table)]),
        chosen=_chosen(found),
    )


def _rates(found: MatchedSet, engine: str) -> str:
    words = []
    for failures, what in ((True, "failures"), (False, "partners")):
        detector, reference = (
            found.success_rate(engine, failures=failures, who=who)
            for who in ("detector", "reference")
        )
        words.append(
            f"{what}: detector {percent(detector)}, reference {percent(reference)} of "
            f"{detector.attempts}"
        )
    return f"- {engine}: {'; '.join(words)}"


def _cells(row: dict[str, Any], engines: list[Any]) -> list[str]:
    counts = [
        f"{row[f'{who}_successes_{engine}']} of {row[f'n_pairs_{engine}']}"
        for engine in engines
        for who in ("detector", "reference")
    ]
    partner = label_at(ROW[not row["is_failure"]], row["pair"])
    return [row["label"], partner, f"{row['similarity']:.2f}", *counts]


def _chosen(found: MatchedSet) -> str:
    reasons = "; ".join(f"{reason}: {count}" for reason, count in found.replaced.items())
    return (
        f"A partner must be printable. In the same number of other attempts, the detector must "
        f"hold it in {100 * found.rules.succeeds:.0f} %, the reference in {100 * REFERENCE:.0f} %. "
        f"Objects that were chosen but did not pass: {reasons or 'none'}. Failures without a "
        f"partner, left out: {found.unmatched}."
    )

"""Hands that tried the same objects: success rates, ranks, differences, causes of failures."""

from collections.abc import Mapping
from pathlib import Path
from typing import Self

import pandas as pd

from egad._util.display import Picture, draw, table_html
from egad.bench.hands.parameters import HandParameters
from egad.bench.stats import (
    Comparison,
    Mean,
    Ranks,
    by_object,
    compare,
    conclusion,
    leads,
    mean_rate,
    ranks,
)
from egad.errors import check_name
from egad.grippers import Gripper
from egad.tables import parquet
from egad.tables.hands import GRASPERS, HAND_ATTEMPTS, Cause


class HandComparison:
    """Attempts of several hands at the same objects, drops and errors of the cell.

    Attributes:
        table: One row per attempt, columns of `tables.hands.HAND_ATTEMPTS`.
        hands: The hands by name; differences are to the first.
        detectors: The name of the detector of each hand.
        settings: Settings of the attempts.
        rule: How objects were scaled to `settings.hands.size`: see `egad.rescale`.
    """

    def __init__(
        self,
        table: pd.DataFrame,
        hands: Mapping[str, Gripper],
        detectors: Mapping[str, str],
        settings: HandParameters,
        rule: str,
    ) -> None:
        """Wrap a table."""
        self.table = table.reset_index(drop=True)
        self.hands, self.detectors = dict(hands), dict(detectors)
        self.settings, self.rule = settings, rule

    def __repr__(self) -> str:
        lines = [f"{name}: {rate}" for name, rate in self.rates().items()]
        return "\n".join([f"HandComparison, {GRASPERS['best']}:", *lines])

    def _repr_html_(self) -> str:
        """Success rates by hand and grasper, for notebooks."""
        rates = {who: {name: r.value for name, r in self.rates(who).items()} for who in GRASPERS}
        return table_html("Success rates by hand", pd.DataFrame(rates))

    def plot(self) -> Picture:
        """Draw the success rates of all hands, with intervals of 95 % over objects.

        Returns:
            A picture that a notebook shows; `save("hands.svg")` writes it.
        """
        return draw("hands", "rate_chart", self)

    def attempts(self, hand: str, grasper: str = "best") -> pd.DataFrame:
        """The attempts that a hand is judged by.

        Args:
            hand: Its name.
            grasper: `best`: the best grasp that a search on other drops found; `detector`;
                or `naive`: naive grasps.

        Returns:
            Rows of `table`. The columns `attempt` and `initial_pose` are equal in attempts that
            differ only in the hand.

        Raises:
            UserError: There is no such hand or grasper.
        """
        check_name("hand", hand, self.hands)
        check_name("grasper", grasper, GRASPERS)
        rows = self.table[(self.table["hand"] == hand) & (self.table["grasper"] == grasper)]
        number = rows["drop"] * self.settings.hands.naive + rows["attempt"]
        return rows.assign(attempt=number, initial_pose="dropped")

    def rates(self, grasper: str = "best") -> dict[str, Mean]:
        """Success rate of each hand with a grasper, with its 95 % interval over objects."""
        return {name: mean_rate(self.attempts(name, grasper)) for name in self.hands}

    def compare(self, first: str, second: str, grasper: str = "best") -> Comparison:
        """The first hand against the second over pairs of attempts, by object and drop."""
        return compare(self.attempts(first, grasper), self.attempts(second, grasper))

    def ranks(self, grasper: str = "best") -> dict[str, Ranks]:
        """Best and worst rank that each hand may have, with 95 % confidence in all of them."""
        counts = {name: by_object(self.attempts(name, grasper)) for name in self.hands}
        sizes = next(iter(counts.values()))["attempts"].to_numpy()
        successes = {name: each["successes"].to_numpy() for name, each in counts.items()}
        return ranks(list(counts), leads(successes, sizes))

    def causes(self, grasper: str = "best") -> pd.DataFrame:
        """Number of attempts by hand (rows) and what became of them (columns: `Cause`)."""
        rows = self.table[self.table["grasper"] == grasper]
        counts = pd.crosstab(rows["hand"], rows["cause"])
        return counts.reindex(index=list(self.hands), columns=list(Cause), fill_value=0)

    def never_held(self, hand: str) -> pd.DataFrame:
        """Attempts at the objects that a hand held in none, whoever chose the grasps."""
        rows = self.table[self.table["hand"] == check_name("hand", hand, self.hands)]
        return rows[~rows.groupby("label")["success"].transform("any").astype(bool)]

    def conclusions(self) -> list[str]:
        """A sentence for each grasper and each hand after the first: which is better, how sure."""
        first, *others = self.hands
        return [self._conclusion(grasper, first, name) for name in others for grasper in GRASPERS]

    def _conclusion(self, grasper: str, first: str, second: str) -> str:
        result = self.compare(second, first, grasper)
        better, worse = second, first
        if result.difference < 0:
            better, worse, result = first, second, self.compare(first, second, grasper)
        tables = [self.attempts(name, grasper) for name in (better, worse)]
        text = conclusion(better, worse, result, tables)
        return f"{GRASPERS[grasper].capitalize()}: {text}"

    def save(self, path: str | Path) -> None:
        """Write the table, with the hands and the settings; `load` reads them."""
        notes = {
            "hands": [(name, hand.model_dump(mode="json")) for name, hand in self.hands.items()],
            "detectors": self.detectors,
            "settings": self.settings.model_dump(mode="json"),
            "rule": self.rule,
        }
        parquet.write(self.table, HAND_ATTEMPTS, Path(path), notes)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read what `save` wrote; TableError if the table is missing or damaged."""
        notes = parquet.notes(Path(path))
        return cls(
            parquet.read(Path(path), HAND_ATTEMPTS),
            {name: Gripper.model_validate(hand) for name, hand in notes["hands"]},
            notes["detectors"],
            HandParameters.model_validate(notes["settings"]),
            notes["rule"],
        )

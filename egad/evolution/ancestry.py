"""Where elites come from: their ancestors back to the random founders, even those long replaced."""

from collections import defaultdict
from collections.abc import Iterable

import pandas as pd

from egad._util.display import table_html
from egad.errors import UserError
from egad.evolution.genome import Row
from egad.tables.evolution import GENOME

MEASURES = ["complexity", "graspability"]


class Lineage:
    """Lines of descent among elites and all their ancestors (ours).

    A child of two parents has the structure of its network from the first one: connections and
    nodes that only one parent has come from that one (`genome.child`). So the line of first
    parents leads from each object to one founder, a random genome. All objects with the same
    founder are a family. A name that is not in the table is a `UserError`.

    Attributes:
        table: One row per object, parents before their children, with its genome and measures.
    """

    def __init__(self, ancestry: pd.DataFrame) -> None:
        """Read the relations of a table with the columns of `tables.evolution.LINEAGE`."""
        self.table = ancestry
        ids = ancestry["id"]
        self._parents: dict[str, tuple[str, ...]] = {
            name: tuple(parents) for name, parents in zip(ids, ancestry["parents"], strict=True)
        }
        self._children: dict[str, list[str]] = defaultdict(list)
        for name, parents in self._parents.items():
            for parent in dict.fromkeys(parents):
                self._children[parent].append(name)

    def __len__(self) -> int:
        return len(self._parents)

    def __contains__(self, name: object) -> bool:
        return name in self._parents

    def __repr__(self) -> str:
        founders = sum(not parents for parents in self._parents.values())
        return f"Lineage({len(self)} objects, {founders} of them founders)"

    def _repr_html_(self) -> str:
        return table_html(repr(self), self.table.set_index("id")[["parents", *MEASURES]])

    def genome(self, name: str) -> Row:
        """The CPPN of an object or ancestor, with the columns of `tables.evolution.GENOME`."""
        self.parents(name)
        row = self.table[self.table["id"] == name].iloc[0]
        return {column: row[column] for column in GENOME.names}

    def parents(self, name: str) -> tuple[str, ...]:
        """Ids of the parents of an object, the first one first; a founder has none."""
        if name not in self._parents:
            raise UserError(
                f"the ancestors of the object {name} are unknown: it is not in the table"
            )
        return self._parents[name]

    def children(self, name: str) -> tuple[str, ...]:
        """Ids of the children of an object that are in the table, the oldest first."""
        self.parents(name)
        return tuple(self._children.get(name, ()))

    def line(self, name: str) -> list[str]:
        """An object, its first parent, the first parent of that one, and so on to the founder."""
        line = [name]
        while parents := self.parents(line[-1]):
            line.append(parents[0])
        return line

    def family(self, name: str) -> str:
        """Id of the founder at the end of the line of first parents, which names the family."""
        return self.line(name)[-1]

    def founders(self, name: str) -> list[str]:
        """Ids of all founders that an object descends from by any parent, the oldest first."""
        known, waiting = {name}, [name]
        while waiting:
            parents = self.parents(waiting.pop())
            waiting.extend(set(parents) - known)
            known.update(parents)
        return [each for each, parents in self._parents.items() if each in known and not parents]


def ancestors(elites: Iterable[str], lineage: pd.DataFrame) -> pd.DataFrame:
    """The rows of elites, named by id, and of all their ancestors, in the order of creation.

    An object that was accepted more than once, or by several islands, counts from the first time.
    `UserError` if one of them is missing in the lineage (`LINEAGE`).
    """
    born = lineage.sort_values(["epoch", "step", "island", "id"]).drop_duplicates("id")
    parents = dict(zip(born["id"], born["parents"], strict=True))
    known: set[str] = set()
    waiting = list(elites)
    while waiting:
        name = waiting.pop()
        if name in known:
            continue
        if name not in parents:
            raise UserError(f"the object {name} is missing: an ancestry needs all epochs of a run")
        known.add(name)
        waiting.extend(parents[name])
    return born[born["id"].isin(known)].reset_index(drop=True)

"""Splits of a dataset into training, validation and test objects by family (ours).

Evolution makes an object from others by small changes, so near relatives may look alike. A network
that was trained on one of them has in a sense seen the other.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping

from egad.evolution import Lineage
from egad.random import entropy


def families(ids: Iterable[str], lineage: Lineage | None) -> dict[str, str]:
    """The founder of each object, by id; itself without a lineage. UserError if that lacks it."""
    return {name: lineage.family(name) if lineage else name for name in ids}


def with_parents_and_children(names: Iterable[str], lineage: Lineage | None) -> set[str]:
    """Objects, their parents and children, if known; UserError if the lineage lacks an object."""
    found = set(names)
    if lineage is None:
        return found
    return found.union(
        *(lineage.parents(name) for name in found), *(lineage.children(name) for name in found)
    )


def split_by_family(
    family_of: Mapping[str, str], test: Collection[str], validation: float, seed: int
) -> dict[str, str]:
    """The split of each object, `train`, `validation` or `test`, whatever their order.

    No family is in both training and validation. The largest families go to training until it has
    its share of the objects; all others go to validation, at most that fraction of the objects that
    are not for testing. The seed decides among families of the same size.
    """
    held_out = set(test)
    sizes = Counter(family for name, family in family_of.items() if name not in held_out)
    order = sorted(sizes, key=lambda name: (-sizes[name], entropy(seed, "family split", name)))
    wanted = round((1 - validation) * sizes.total(), 6)  # 0.7 of 30 are 21, not a little more
    training: set[str] = set()
    count = 0
    for family in order:
        if count >= wanted:
            break
        training.add(family)
        count += sizes[family]
    return {
        name: "test" if name in held_out else "train" if family in training else "validation"
        for name, family in family_of.items()
    }

"""The front matter of a dataset card, against the lists of Hugging Face's documentation."""

import pytest
import yaml

from egad.exchange.release.dataset_card import front_matter


@pytest.mark.parametrize(
    ("rows", "category"),
    [(999, "n<1K"), (1000, "1K<n<10K"), (999_999, "100K<n<1M"), (11_000_000, "10M<n<100M")],
)
def test_the_size_is_a_category_of_hugging_face(rows, category):
    assert yaml.safe_load(front_matter("Name", 100, rows - 100))["size_categories"] == [category]

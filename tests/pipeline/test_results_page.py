from pathlib import Path

from egad.pipeline import results_page


def test_the_page_is_what_the_schemas_give():
    path = Path(__file__).parents[2] / results_page.PAGE
    assert path.read_text(encoding="utf-8") == results_page.page()


def test_every_column_has_a_meaning():
    schemas = [each.schema for each in results_page.ARTEFACTS if each.schema is not None]
    assert len(schemas) > 5
    for schema in schemas:
        for field in schema:
            assert field.metadata[b"meaning"], field.name

"""The hooks of the documentation site, `docs/hooks.py`: links that leave docs/, pages of names."""

import importlib.util
from pathlib import Path

import pytest
import yaml

import egad

ROOT = Path(__file__).parents[1]


def hooks_module():
    spec = importlib.util.spec_from_file_location("site_hooks", ROOT / "docs/hooks.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


hooks = hooks_module()


@pytest.mark.parametrize(
    ("source", "link", "page"),
    [
        ("docs/grasps.md", "../config/README.md#scale-rules", "config/README.md#scale-rules"),
        ("docs/guides/own-meshes.md", "../../config/README.md", "../config/README.md"),
        ("docs/custom.md", "../examples/measures.py", "examples/measures.py.md"),
        ("docs/custom.md", "../README.md#what-comes-out", "index.md"),
        ("docs/custom.md", "trials.md#labels", "trials.md#labels"),
        ("config/README.md", "../docs/custom.md", "../custom.md"),
        ("docs/custom.md", "https://example.org/a.md", "https://example.org/a.md"),
        ("docs/custom.md", "../config/no-such-file.yaml", "../config/no-such-file.yaml"),
        ("docs/custom.md", "#limits", "#limits"),
        ("docs/results.md", "../studies/search/search.svg", "studies/search/search.svg"),
        ("studies/search/README.md", "search.svg", "search.svg"),
    ],
)
def test_links_lead_to_pages_of_the_site(source, link, page):
    text = f"See [this]({link}), and ![it]({link})."
    assert hooks.with_links_to_pages(text, source) == f"See [this]({page}), and ![it]({page})."


def test_a_notebook_is_a_page_with_its_pictures():
    cells = [
        {"cell_type": "markdown", "source": ["# Title\n", "text"]},
        {
            "cell_type": "code",
            "source": "draw()",
            "outputs": [
                {"output_type": "stream", "name": "stderr", "text": ["1/2"]},
                {"output_type": "stream", "name": "stdout", "text": ["done\n"]},
                {"output_type": "display_data", "data": {"image/png": "QUJD\n", "text/plain": "x"}},
                {"output_type": "execute_result", "data": {"image/svg+xml": ["A", "BC"]}},
            ],
        },
    ]
    text = hooks.page_of({"cells": cells})
    assert text.split("\n\n") == [
        "# Title\ntext",
        "```python\ndraw()\n```",
        "```text\ndone\n```",
        '<img src="data:image/png;base64,QUJD" alt="Output">',
        '<img src="data:image/svg+xml;base64,QUJD" alt="Output">\n',
    ]


def test_every_public_name_has_a_page():
    pages = dict(hooks.reference_pages())
    public = {name for name in egad.__all__ if not name.startswith("__")}
    assert set(pages) == {f"reference/egad.{name}.md" for name in public} | {"reference/index.md"}
    for name in public:
        assert f"egad.{name}.md" in pages["reference/index.md"]


class Loader(yaml.SafeLoader):
    """Reads mkdocs.yml without making the objects of Python that it names."""


Loader.add_multi_constructor("tag:yaml.org,2002:python/", lambda *_: None)


def test_the_navigation_names_files_that_are_there():
    settings = yaml.load((ROOT / "mkdocs.yml").read_text(), Loader)  # noqa: S506 (a SafeLoader)
    made = {"reference/index.md", hooks.page_path(f"docs/{hooks.NOTEBOOK}")}
    assert (ROOT / "docs" / hooks.NOTEBOOK).is_file()
    for page in set(hooks.pages_of(settings["nav"])) - made:
        assert (ROOT / "docs" / page).is_file() or (ROOT / page).is_file(), page

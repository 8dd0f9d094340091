"""What the site needs besides mkdocs: files from outside docs/, and a page for each public name.

Pages link to files beside docs/, as they do in the repository: `../config/README.md`,
`../examples/measures.py`. Each of these becomes a page of the site, Markdown as it is and anything
else but pictures as a listing, and links lead to that page. Each name in `egad.__all__` gets a page
with its docstring and an entry in the navigation.
"""

import base64
import inspect
import json
import posixpath
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import egad

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import File, Files
    from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[1]
NOTEBOOK = "tutorial.ipynb"
HOME = "index.md"  # stands for README.md
REFERENCE = "Reference"  # heading in the navigation of mkdocs.yml
LINK = re.compile(r"(?<=\]\()([^)\s#:]+)(#[^)\s]*)?(?=\))")
PICTURES = (".png", ".svg")
LANGUAGES = {".py": "python", ".yaml": "yaml", ".toml": "toml", ".smk": "python", ".sh": "bash"}


def on_config(config: "MkDocsConfig") -> None:
    """Add the pages of public names to the navigation."""
    section = next(part for part in config.nav or [] if REFERENCE in part)
    section[REFERENCE][1:1] = [
        {title: [{name: reference_page(name)} for name in names]}
        for title, names in public_names().items()
        if names
    ]


def on_files(files: "Files", *, config: "MkDocsConfig") -> "Files":
    """Add the files outside docs/ that a page links to or that the navigation names."""
    from mkdocs.structure.files import File, InclusionLevel  # noqa: PLC0415 (tests need no mkdocs)

    in_navigation = set(pages_of(config.nav))
    texts = {f"docs/{file.src_uri}": file.content_string for file in files.documentation_pages()}
    wanted = {path for source, text in texts.items() for path in linked_files(text, source)}
    wanted |= {path for path in in_navigation if (ROOT / path).is_file()}
    for path in with_links_of_their_own(wanted):
        uri = page_path(path)
        level = InclusionLevel.UNDEFINED if uri in in_navigation else InclusionLevel.NOT_IN_NAV
        content = (ROOT / path).read_bytes() if path.endswith(PICTURES) else listing(path)
        files.append(File.generated(config, uri, content=content, inclusion=level))
    notebook = json.loads((ROOT / "docs" / NOTEBOOK).read_text())
    files.append(File.generated(config, page_path(f"docs/{NOTEBOOK}"), content=page_of(notebook)))
    for uri, content in reference_pages():
        files.append(File.generated(config, uri, content=content))
    return files


def on_page_markdown(markdown: str, *, page: "Page", **_: Any) -> str:  # noqa: ANN401
    """Make links to files outside docs/ lead to their pages."""
    return with_links_to_pages(markdown, source_of(page.file))


def source_of(file: "File") -> str:
    """The file of the repository that a page comes from."""
    return file.src_uri if file.generated_by else f"docs/{file.src_uri}"


def page_path(path: str) -> str:
    """The page that shows a file of the repository, both relative to their roots."""
    if path == "README.md":
        return HOME
    if path.startswith("docs/"):
        return path.removeprefix("docs/").replace(".ipynb", ".md")
    return path if path.endswith((".md", *PICTURES)) else f"{path}.md"


def with_links_to_pages(text: str, source: str) -> str:
    """Replace relative links to files of the repository by links to their pages.

    Args:
        text: Markdown.
        source: The file that it comes from, relative to the root of the repository.
    """
    folder = posixpath.dirname(page_path(source))

    def replaced(link: re.Match[str]) -> str:
        path = target(link[1], source)
        if not (ROOT / path).is_file():
            return link[0]  # mkdocs reports it
        anchor = "" if path == "README.md" else link[2] or ""
        return posixpath.relpath(page_path(path), folder) + anchor

    return LINK.sub(replaced, text)


def linked_files(text: str, source: str) -> Iterator[str]:
    """Files outside docs/ that a page links to, relative to the root of the repository."""
    for link in LINK.finditer(text):
        path = target(link[1], source)
        outside = path != "README.md" and not path.startswith(("docs/", "../"))
        if outside and (ROOT / path).is_file():
            yield path


def target(link: str, source: str) -> str:
    """What a relative link leads to, relative to the root of the repository."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(source), link))


def with_links_of_their_own(paths: Iterable[str]) -> list[str]:
    """The files and all that their pages link to outside docs/, sorted."""
    found: set[str] = set()
    waiting = set(paths)
    while waiting:
        path = waiting.pop()
        found.add(path)
        if path.endswith(".md"):
            waiting |= set(linked_files((ROOT / path).read_text(), path)) - found
    return sorted(found)


def listing(path: str) -> str:
    """A file of the repository as Markdown."""
    text = (ROOT / path).read_text()
    if path.endswith(".md"):
        return text
    language = LANGUAGES.get(Path(path).suffix, "text")
    return f"# {Path(path).name}\n\n`{path}` in the repository.\n\n````{language}\n{text}````\n"


def page_of(notebook: dict[str, Any]) -> str:
    """A notebook as Markdown: its texts, its code, and what the code gave."""
    parts = []
    for cell in notebook["cells"]:
        text = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(text)
        else:
            parts += [f"```python\n{text}\n```", *map(output, cell["outputs"])]
    return "\n\n".join(filter(None, parts)) + "\n"


def output(found: dict[str, Any]) -> str:
    """What a cell gave, as Markdown: a picture, HTML or text; progress is left out."""
    if found["output_type"] == "stream":
        text = "".join(found["text"]) if found["name"] == "stdout" else ""
        return f"```text\n{text.rstrip()}\n```" if text else ""
    data = {kind: "".join(value) for kind, value in found["data"].items()}
    if "image/png" in data:
        return f'<img src="data:image/png;base64,{data["image/png"].strip()}" alt="Output">'
    if "image/svg+xml" in data:
        content = base64.b64encode(data["image/svg+xml"].encode()).decode()
        return f'<img src="data:image/svg+xml;base64,{content}" alt="Output">'
    if "text/html" in data:
        return re.sub(r"\n\s*\n", "\n", data["text/html"])
    return f"```text\n{data['text/plain']}\n```"


def pages_of(navigation: Any) -> Iterator[str]:  # noqa: ANN401
    """All pages of a navigation as YAML has it: texts, lists and mappings from titles."""
    if isinstance(navigation, str):
        yield navigation
    else:
        parts = navigation.values() if isinstance(navigation, dict) else navigation
        for part in parts:
            yield from pages_of(part)


def public_names() -> dict[str, list[str]]:
    """The names in `egad.__all__` by their kind, sorted."""
    kinds: dict[str, list[str]] = {"Functions": [], "Classes": [], "Errors": [], "Others": []}
    for name in sorted(egad.__all__, key=str.lower):
        if not name.startswith("__"):
            kinds[kind(getattr(egad, name))].append(name)
    return kinds


def kind(value: object) -> str:
    """The heading that a public name stands under."""
    if inspect.isclass(value):
        return "Errors" if issubclass(value, Exception) else "Classes"
    return "Functions" if callable(value) else "Others"


def reference_page(name: str) -> str:
    """The page of a public name."""
    return f"reference/egad.{name}.md"


def reference_pages() -> Iterator[tuple[str, str]]:
    """Pages of all public names, and the overview that lists them: path and Markdown of each."""
    overview = ["# Reference", "", "Everything here is imported with `import egad`."]
    for title, names in public_names().items():
        if names:
            overview += ["", f"## {title}", "", "| name | what it is |", "| --- | --- |"]
        for name in names:
            summary = (inspect.getdoc(getattr(egad, name)) or "").partition("\n")[0]
            overview.append(f"| [`egad.{name}`](egad.{name}.md) | {summary} |")
            yield reference_page(name), f"# egad.{name}\n\n::: egad.{name}\n"
    yield "reference/index.md", "\n".join(overview) + "\n"

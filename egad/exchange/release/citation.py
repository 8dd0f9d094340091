"""The files of a dataset release that say how to cite it and what its licence is."""

import yaml

from egad.exchange.release.dataset_card import LICENSE, LICENSE_URL, PAPER

CREATOR = "the egad developers"
TERMS = """{title}, version {version}

Licence: Creative Commons Attribution 4.0 International (CC BY 4.0)
SPDX-License-Identifier: {license}
Legal text: {url}legalcode
Copyright (c) {creator}

You may copy, change and share these files for any purpose, even commercially, if you give
credit, link to the licence, and say whether you changed something. For credit, cite the paper and
the dataset as CITATION.cff says. The data comes without any warranty; the legal text says so in
full. To the network vgn-evolved, the licence networks/vgn-evolved/LICENSE-VGN applies, too.
"""


def licence_text(title: str, version: str) -> str:
    """The licence of a release, with the dataset's title for people and its version."""
    return TERMS.format(
        title=title, version=version, license=LICENSE, url=LICENSE_URL, creator=CREATOR
    )


def citation_cff(title: str, version: str, date: str | None, url: str | None) -> str:
    """How to cite a release, in the Citation File Format 1.2.0; `date` is YYYY-MM-DD, if known."""
    names = [
        name.rsplit(" ", 1) for name in str(PAPER["authors"]).replace(" and ", ", ").split(", ")
    ]
    paper = {
        "type": "article",
        "title": PAPER["title"],
        "authors": [{"family-names": family, "given-names": given} for given, family in names],
        **{name: PAPER[name] for name in ("journal", "year", "volume", "issue", "start", "end")},
        "doi": PAPER["doi"],
    }
    fields = {
        "cff-version": "1.2.0",
        "message": "If you use this dataset, please cite the paper and the dataset.",
        "type": "dataset",
        "title": title,
        "version": version,
        "license": LICENSE,
        "authors": [{"name": CREATOR}],
        **({"date-released": date} if date else {}),
        **({"url": url} if url else {}),
        "references": [paper],
    }
    return yaml.safe_dump(fields, sort_keys=False, allow_unicode=True)

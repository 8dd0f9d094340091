"""The report in Chromium, on screens of several widths: `make browser`."""

import pytest
from chromium import IN_CHROMIUM

from egad.report.page import report_page, section_of
from egad_workflow.config_tables import changed_parameters, settings_text
from egad_workflow.settings import Settings

pytestmark = IN_CHROMIUM
PARTS = {"source": "meshes", "folder": "parts/" + "long" * 20, "units": "mm"}


@pytest.fixture(scope="module")
def settings_page(tmp_path_factory):
    """The section with the widest tables."""
    changed = Settings(trials={"attempts": 3}, datasets={"own": PARTS})
    section = section_of(
        "parameters.html.j2",
        "Parameters",
        changed=changed_parameters(changed),
        settings=settings_text(Settings()),
        versions={},
    )
    path = tmp_path_factory.mktemp("report") / "report.html"
    path.write_text(report_page([section]), encoding="utf-8")
    return path


@pytest.mark.parametrize("width", [320, 390, 800, 1200])
def test_the_report_does_not_scroll_sideways(settings_page, browser, width):
    page = browser(viewport={"width": width, "height": 900}, is_mobile=False).new_page()
    page.goto(settings_page.as_uri())
    page.locator("details > summary").click()
    assert page.evaluate("document.documentElement.scrollWidth") == width
    assert "graspability_range: [0.0005, 0.004]" in page.locator("pre").inner_text()

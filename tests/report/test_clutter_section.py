"""The section of cleared tables tells what the tables do."""

from egad.report.clutter import clutter_view


def test_rates_and_thirds_are_those_of_the_table(clutter, evalset):
    view = clutter_view({"mine": clutter}, evalset, {})
    only = view.rates["mine"][0]
    assert (only.scene, only.noise, only.rounds) == ("pile", "none", 2)
    assert (only.success.successes, only.success.attempts) == (1, 5)
    assert (only.cleared.successes, only.cleared.attempts) == (1, 4)
    for rates in view.thirds["mine"].values():
        success, cleared = zip(*rates, strict=True)
        assert sum(rate.attempts for rate in success) == 5
        assert sum(rate.attempts for rate in cleared) == 4
        assert sum(rate.successes for rate in success) == 1
        assert [rate.successes for rate in success] == [rate.successes for rate in cleared]


def test_the_report_shows_it(report_html):
    assert report_html.count('id="clutter"') == 1
    text = " ".join(report_html.split())
    assert "A scene of the kind pile" in text
    assert "antipodal-cloud" in text

from egad._util.markdown import table


def test_tables_are_markdown():
    assert table(["a", "b"], [[1234, "x"], [True, 0.5]]) == (
        "| a | b |\n| --- | --- |\n| 1,234 | x |\n| True | 0.5 |\n"
    )

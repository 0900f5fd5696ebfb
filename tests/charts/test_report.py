"""The page of charts and the comparison of headline figures."""

import json

import pytest
from charts import __main__ as command
from charts import experiment, report


def verdicts(committed, now):
    return {figure: verdict for figure, _, _, verdict in report.compare(committed, now)}


def test_a_figure_is_worse_beyond_the_tolerance_only():
    committed = {"a": 100, "b": 100, "c": 100, "d": 100, "e": 0.0, "time_over_x": 1, "time_over_y": 1}
    now = {"a": 104.9, "b": 105.1, "c": 90, "e": 0.0, "f": 1, "time_over_x": 1.4, "time_over_y": 1.6}
    assert verdicts(committed, now) == {
        "a": "same",
        "b": "worse",
        "c": "better",
        "d": "gone",
        "e": "same",
        "f": "new",
        "time_over_x": "same",
        "time_over_y": "worse",
    }


def one_figure(value):
    return experiment.Experiment(
        "bytes", "", lambda quick: {"value": value}, None, None, lambda results: {"all": results["value"]}
    )


@pytest.mark.parametrize("value, code", [(100, 0), (104, 0), (106, 1), (50, 0)])
def test_quick_fails_for_a_worse_figure(tmp_path, monkeypatch, capsys, value, code):
    monkeypatch.setattr(report, "HEADLINES", tmp_path / "headlines.json")
    assert command.quick([one_figure(100)], accept=True) == 0
    assert json.loads((tmp_path / "headlines.json").read_text()) == {"bytes.all": 100}
    assert command.quick([one_figure(value)], accept=False) == code
    shown = capsys.readouterr()
    assert "bytes.all" in shown.out
    assert ("bytes.all" in shown.err) == bool(code)


def test_every_experiment_has_results_pictures_and_a_sentence():
    for e in command.all_experiments():
        record = experiment.load(e.name)
        assert record, f"no docs/evidence/charts/results/{e.name}.json: ./run charts {e.name}"
        text = e.text(record["results"])
        assert report.first_sentence(text), e.name
        pictures = [name for name in report.pictures(text) if not (experiment.PAGES / name).exists()]
        assert not pictures, f"{e.name}: ./run charts --draw {e.name}"


def test_the_page_is_that_of_the_stored_results():
    assert (experiment.PAGES / "README.md").read_text() == report.page(
        command.all_experiments()
    ), "./run charts --draw"

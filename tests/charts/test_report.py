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


def judged(option, justified):
    return experiment.Experiment(
        "one",
        "One",
        None,
        None,
        lambda results: "**It says so.**",
        defaults=lambda results: [(option, 1, "a knee at 2", justified)],
    )


@pytest.mark.parametrize(
    "option, justified, counts, says",
    [
        ("fvvmux --quality", True, True, "a knee at 2"),
        (
            "fvvmux --quality",
            False,
            True,
            "Chosen per scene by default (`--view-loss`): 38 to 40 dB in 2 of 3 scenes",
        ),
        ("fvvmux --group", False, False, "**Not justified**"),
        ("fvvmux --group", True, True, "a knee at 2"),
    ],
)
def test_a_default_is_justified_or_chosen_for_each_scene_or_counts(option, justified, counts, says):
    row = {"max_error": 0.1, "threshold": 0.25}
    scenes = {"a": row | {"picture_psnr": 38}, "b": row | {"picture_psnr": 40}, "c": {"reason": "one camera"}}
    by_scene = experiment.Experiment("choices", "Choices", None, None, None)
    found = [(judged(option, justified), {"results": {}}), (by_scene, {"results": {"scenes": scenes}})]
    (shown,) = report.default_rows(found)
    assert shown.justified == counts
    assert says in shown.verdict
    assert justified or "a knee at 2." in shown.verdict


def test_no_default_is_unjustified():
    rows = report.default_rows(report.measured(command.all_experiments()))
    assert len(rows) > 15 and not [row.option for row in rows if not row.justified]

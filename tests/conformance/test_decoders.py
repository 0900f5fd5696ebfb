"""The decoders of this project agree with every case, and call nothing intact that damage has changed."""

import pathlib
import sys

import pytest

CONFORMANCE = pathlib.Path(__file__).resolve().parent.parent.parent / "conformance"
sys.path.insert(0, str(CONFORMANCE))

from adapters import all as adapters  # noqa: E402
from fvv_conformance import cases, command, running, sweep  # noqa: E402

CASES = cases.load(cases.default_folder())
#: Damages of each case. ./run conformance --sweep takes more.
SAMPLES = {"libfvv": 30, "wasm": 2, "python": 4, "reference": 1}
#: Cases that differ from others in one content: what damage does to their containers others show.
ALIKE = ("valid/record_", "valid/sample_", "valid/weights_", "valid/projection_")


def command_of(name):
    if reason := adapters.missing(name):
        print(f"skipped: {name}: {reason}")
        pytest.skip(reason)
    return adapters.commands()[name][0]


def test_there_are_cases():
    tiers = [case.tier for case in CASES]
    assert tiers.count("valid") >= 200 and tiers.count("faulty") >= 200


def test_a_spread_of_200_cases():
    """The same for every run, from all tiers and kinds, in one process."""
    found = [CASES[i * len(CASES) // 200] for i in range(200)]
    tested = running.test_decoder(command_of("libfvv"), found, jobs=1, timeout=60)
    assert [(o.case, o.differences[:3]) for o in tested.outcomes if o.differences] == []
    assert len({o.case for o in tested.outcomes}) == 200


@pytest.mark.parametrize("name", [*SAMPLES, "example.c", "example.mjs", "example.py"])
def test_agreement(name):
    found = adapters.cases_for(name, CASES)
    tested = running.test_decoder(command_of(name), found, jobs=2, timeout=60)
    assert [(o.case, o.differences[:3]) for o in tested.outcomes if o.differences] == []
    assert len(tested.outcomes) == len(found) >= len(CASES) - 1


def test_what_draws_weighs_cameras_as_the_cases_do():
    tested = running.test_decoder(command_of("view"), CASES, jobs=1, timeout=60)
    assert [(o.case, o.differences[:3]) for o in tested.outcomes if o.differences] == []
    assert {o.case for o in tested.outcomes} == {c.name for c in CASES if c.name.startswith("valid/weights_")}


@pytest.mark.parametrize("name", SAMPLES)
def test_damage(name):
    found = [case for case in adapters.cases_for(name, CASES) if not case.name.startswith(ALIKE)]
    result = sweep.sweep_decoder(command_of(name), found, SAMPLES[name], False, jobs=2, timeout=60)
    assert (result["wrong"], result["disagreed"]) == ([], [])
    assert result["refused"] + result["damaged"] > result["damages"] * 0.8


def test_command_line(tmp_path, capsys):
    native = command_of("libfvv")
    outputs = {name: tmp_path / f"result.{name}" for name in ("json", "junit", "html")}
    given = ["run", "--decoder", native, "--only", "valid/mesh_*"]
    given += [word for name, path in outputs.items() for word in (f"--{name}", str(path))]
    assert command.main(given) == 0
    assert capsys.readouterr().out.startswith("decoder")
    assert all(path.stat().st_size > 500 for path in outputs.values())
    assert command.main(given) == 1  # they exist
    assert "--force" in capsys.readouterr().err
    assert command.main([*given, "--force"]) == 0

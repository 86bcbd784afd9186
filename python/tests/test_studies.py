"""Cases, Monte Carlo, sensitivity and tuning, each with its figure."""

import re
import subprocess
import sys

import numpy as np
import pandas
import pytest

import hdrm_fmu
from hdrm_fmu import BadInput, plots, studies
from test_sweep import QUICK


def test_grids_and_random_cases():
    table = hdrm_fmu.grid(mode=["pd", "adaptive"], **{"hdrm.inertia_scale": [1.0, 1.2, 1.4]})
    assert len(table) == 6 and list(table.columns) == ["mode", "hdrm.inertia_scale"]
    some = hdrm_fmu.random(500, 7, {"a": (2.0, 3.0), "mode": ["pd", "adaptive"]})
    more = hdrm_fmu.random(500, 7, {"mode": ["pd", "adaptive"], "a": (2.0, 3.0), "b": (0.0, 1.0)})
    pandas.testing.assert_frame_equal(some, more[["a", "mode"]])
    assert some["a"].between(2.0, 3.0).all() and some["a"].max() > 2.95 and set(some["mode"]) == {"pd", "adaptive"}
    with pytest.raises(BadInput, match="first must be less"):
        hdrm_fmu.random(5, 7, {"a": (3.0, 2.0)})


def test_monte_carlo(two_workers, tmp_path):
    options = {k: v for k, v in QUICK.items() if k != "settings"}
    table = studies.monte_carlo(3, out=tmp_path / "m", modes=["adaptive_integral", "pd"], client=two_workers, settings={"settle_time": 0.02}, **options)
    assert len(table) == 6 and table["known_rmse"].nunique() == 6
    summary = studies.summary(table)
    assert (summary["runs"] == 3).all() and (summary["worst"] >= summary["median"]).all()
    plots.spread(table, path=tmp_path / "m.png")
    assert (tmp_path / "m.png").stat().st_size > 10_000


def test_sobol_finds_what_matters(two_workers, tmp_path):
    """The residual of a PD controller at rest is made by the weight, not by a gain of the wrist's end stop that is never reached."""
    ranges = {"hdrm.inertia_scale": (0.8, 1.2), "settle_time": (0.01, 0.02)}
    table = studies.sobol(ranges, out=tmp_path / "s", base=8, metric="tip_rmse_whole", client=two_workers, stop_time=0.05, settings={"mode": "pd"}, progress=False)
    total = dict(zip(table["parameter"], table["ST"]))
    assert total["hdrm.inertia_scale"] > 0.8 and total["settle_time"] < 0.1
    plots.indices(table, tmp_path / "s.png")
    assert (tmp_path / "s.png").stat().st_size > 5_000


def test_tuning_knows_the_rule_of_a_machine(monkeypatch):
    """A best value far from where the scan looks is found, because the rule is tried; a range that leaves it out is named."""
    made_up(monkeypatch, lambda gamma: abs(np.log(gamma / 990.0)))
    stranger = {"extends": "reference", "geometry": {"r_B_B4": [2.1, 0, 0]}, "bodies": {"PL": {"mass": 500}}}
    options = {"runs": 2, "world": "real", "machine": stranger}
    result, _ = studies.tune({"gamma": (20.0, 5000.0)}, **options)
    assert result["rule"] == {"gamma": 990.0} and result["gains"]["gamma"] == pytest.approx(990.0)
    with pytest.warns(UserWarning, match="lowest mode"):
        studies.tune({"gamma": (20.0, 60.0)}, **options)


def test_tuning_is_judged_on_a_held_out_trajectory(tmp_path):
    gains = {"Lambda_position": (2.0, 40.0)}
    options = {"stop_time": 0.15, "settings": {"settle_time": 0.02, "mode": "pd"}}
    result, history = studies.tune(gains, runs=6, **options)
    assert result["cubic"]["after"] <= result["cubic"]["before"] == history["objective"][0]
    alone = hdrm_fmu.run(trajectory="triangular", stop_time=0.15, signals=[], settings={**options["settings"], **result["gains"]})
    assert result["triangular"]["after"] == alone.attrs["tip_rmse"]
    assert result["at_bound"] == [] and result["bad"] == (history["bad"] > 0).sum()
    plots.tuning(history, tmp_path / "t.png")
    assert np.isfinite(history.to_numpy()).all()


def made_up(monkeypatch, metric, verdict=lambda x: "good"):
    """Runs whose metric and verdict are functions of gamma."""

    def run(settings, **_):
        found = verdict(settings["gamma"])
        if found == "failed":
            raise hdrm_fmu.RunFailed("it swings")
        return type("Run", (), {"attrs": {"tip_rmse": metric(settings["gamma"]), "verdict": found}})

    monkeypatch.setattr(studies, "run", run)


def test_tuning_finds_a_valley_far_from_the_start(monkeypatch):
    """A shallow one at the start value, 25, and the deeper one at 900: a search that only goes downhill stays in the first."""
    made_up(monkeypatch, lambda gamma: min(0.2 + abs(np.log(gamma / 25.0)), abs(np.log(gamma / 900.0))))
    result, _ = studies.tune({"gamma": (2.0, 2000.0)}, runs=40)
    assert result["gains"]["gamma"] == pytest.approx(900.0, rel=0.05) and result["at_bound"] == []


def test_tuning_says_what_ended_at_a_bound(monkeypatch):
    made_up(monkeypatch, lambda gamma: 1.0 / gamma)
    result, _ = studies.tune({"gamma": (2.0, 50.0)}, runs=30)
    assert result["at_bound"] == ["gamma"] and result["gains"]["gamma"] == pytest.approx(50.0, rel=0.05)


def test_tuning_counts_bad_tries_and_takes_none(monkeypatch):
    """The metric is smallest where runs are bad or fail."""
    verdict = lambda gamma: "good" if gamma < 100.0 else "BAD" if gamma < 500.0 else "failed"
    made_up(monkeypatch, lambda gamma: 1.0 / gamma, verdict)
    result, history = studies.tune({"gamma": (2.0, 2000.0)}, runs=30)
    assert 50.0 < result["gains"]["gamma"] < 100.0 and 0 < result["bad"] == (history["bad"] > 0).sum() < len(history)


@pytest.mark.parametrize("command", ["demo", "monte-carlo", "sobol", "tune"])
def test_every_option_of_the_commands_is_explained(command):
    text = subprocess.run([sys.executable, "-m", "hdrm_fmu", command, "--help"], capture_output=True, text=True, check=True).stdout
    options = re.split(r"\n  (?=-)", text.partition("options:")[2])
    assert len(options) > 3 and all(len(option.split()) > 4 for option in options[1:]), text


@pytest.mark.parametrize(
    ("call", "reason"),
    [
        (lambda out: studies.tune({"Lambda_positon": (1.0, 2.0)}), "did you mean"),
        (lambda out: studies.tune({"gamma": (1.0, 2.0)}, metric="tip_rmes"), "did you mean `tip_rmse`"),
        (lambda out: studies.tune({"gamma": (1.0, 2.0)}, held_out="cub"), "did you mean `cubic`"),
        (lambda out: studies.tune({}), "no parameters"),
        (lambda out: studies.sobol({"inertia_scale": (1.2, 0.8)}, out=out), "must be more than the first"),
        (lambda out: studies.sobol({"inertia_scale": ("a", 0.8)}, out=out), "pair of numbers"),
        (lambda out: studies.sobol({"inertia_scale": (0.8, 1.2)}, out=out, metric="energy_emla_2_coper"), "did you mean `energy_emla_2_copper`"),
        (lambda out: studies.sobol({"inertia_scale": (0.8, 1.2)}, out=out, base=3), "power of 2"),
        (lambda out: studies.monte_carlo(0, out=out), "no values"),
    ],
)
def test_bad_input_costs_nothing(call, reason, tmp_path):
    with pytest.raises(BadInput, match=reason):
        call(tmp_path / "x")
    assert not (tmp_path / "x").exists()


def test_metrics_are_known_before_a_run():
    from hdrm_fmu import _native

    names = _native.metric_names(["emla_1", "emla_2", "emla_3", "all"])
    data = hdrm_fmu.run(stop_time=0.05, signals=[], metrics=("tracking", "energy"))
    found = {name for name, value in data.attrs.items() if isinstance(value, float) and name not in ("elapsed", "step", "simulated")}
    assert found == set(names) - {"sag_rms", "sag_max", *(f"rigid_{e}" for e in ("rmse", "max", "mean", "varying"))}
    assert {names["tip_rmse"], names["known_rmse"], names["energy_all_work"]} == {"", "tracking", "energy"}

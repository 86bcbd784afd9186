"""The figures: equal scales, one colour for an axis, labels within the picture, numbers that a person reads."""

import re

import numpy as np
import pytest
from matplotlib.colors import to_rgb

import hdrm_fmu
from hdrm_fmu import plots


@pytest.fixture(scope="module")
def run():
    return hdrm_fmu.run(trajectory="triangular", metrics=("energy",), settings={"settle_time": 0.1}, stop_time=1.5)


def test_the_tip_is_seen_from_three_sides_in_one_scale(run):
    figure = plots.tip(run)
    views, (over_time,) = figure.axes[:3], [a for a in figure.axes if a.get_xlabel() == "time / s"]
    assert [(view.get_xlabel()[0], view.get_ylabel()[0]) for view in views] == [("x", "y"), ("x", "z"), ("z", "y")]
    figure.draw_without_rendering()
    spans = [abs(np.diff(limits)[0]) for view in views for limits in (view.get_xlim(), view.get_ylim())]
    assert np.ptp(spans) < 1e-12
    scales = {round(abs(view.transData.transform([[1, 1]])[0][k] - view.transData.transform([[0, 0]])[0][k]), 3) for view in views for k in (0, 1)}
    assert len(scales) == 1, scales
    error = 1e3 * run["controller.tip_error_norm"].to_numpy()
    shown = views[0].collections[0].get_array()
    assert shown.max() <= error.max() and shown.max() > 0.5 * error.max() > 0.0
    largest = run.time.to_numpy()[run.time >= run.attrs["motion_start"]][error[run.time >= run.attrs["motion_start"]].argmax()]
    assert any(text.get_text() == f"largest, t = {largest:.3f} s" for text in over_time.get_legend().get_texts())


def test_an_axis_has_one_colour_everywhere(run):
    lines = {line.get_label(): to_rgb(line.get_color()) for axis in plots.signals(run).axes for line in axis.lines}
    lift = {colour for name, colour in lines.items() if re.fullmatch(r"emla_2\..*|hdrm\.(zeta|x|x_dot)\[2\]|controller\.v_[dq]\[2\]", name)}
    assert len(lift) == 1 and lines["controller.tau_wrist[1]"] == lines["hdrm.zeta[4]"] not in lift
    bars = [patch for patch in plots.energy(run).axes[0].patches if np.allclose(patch.get_facecolor()[:3], min(lift))]
    assert len(bars) == 1 and bars[0].get_x() < 1.0 < bars[0].get_x() + bars[0].get_width()


@pytest.mark.parametrize("draw", [plots.tip, plots.energy, plots.signals])
def test_no_label_is_cut(run, draw):
    figure = draw(run)
    figure.draw_without_rendering()
    page = figure.bbox
    for artist in [*figure.axes, *(axis.get_legend() for axis in figure.axes if axis.get_legend())]:
        box = artist.get_tightbbox()
        assert page.x0 - 1 <= box.x0 and box.x1 <= page.x1 + 1 and page.y0 - 1 <= box.y0 and box.y1 <= page.y1 + 1, artist


def test_numbers_have_three_digits():
    assert [plots._digits(value) for value in (0.0023014, 12.345, 378.46, 0.0, 1e5)] == ["0.00230", "12.3", "378", "0.00", "100000"]

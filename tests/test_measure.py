"""How `bench/measure.py` reads measurements and judges them."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent / "bench"))

from measure import compared, coupled_step, measurements, table  # noqa: E402


def test_numbers_are_read_and_anything_else_is_an_error():
    line = '{"name":"x, y","unit":"ns","median":2.5,"least":1.5}'
    assert measurements(line) == [("x, y", "ns", 2.5, 1.5)]
    with pytest.raises(ValueError):
        measurements("2.5 ns")
    text = '{"real_time_factor":{"median":50.0,"worst":40.0,"best":80.0},"runs":3,"simulated_s":10,"step_s":0.001,"instances":5}'
    assert coupled_step("step", text) == [("step", "ns", 20_000.0, 12_500.0)]


def test_the_table_holds_ratios():
    text = table({"forward dynamics": ("ns", 2.0, 1.0), "Pinocchio tree": ("ns", 30.0, 10.0)})
    assert "- Pinocchio tree / forward dynamics: 15.00 (least: 10.00)\n" in text


def test_only_growth_beyond_the_limit_fails():
    compared({"call": 1029}, {"call": 1000}, 0.03)
    compared({"call": 500}, {"call": 1000}, 0.03)
    compared({"call": 1031}, {"call": 1000}, 0.15)
    for counts, recorded in (({"call": 1031}, {"call": 1000}), ({"call": 1000}, {})):
        with pytest.raises(SystemExit):
            compared(counts, recorded, 0.03)

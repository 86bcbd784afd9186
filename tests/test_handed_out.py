"""How the numbers of two platforms are compared, by `handed_out.py`."""

import pytest

from handed_out import Failed, close, same

ROWS = "time,x\n0,-4\n1,0.5\n"


def test_the_last_digit_counts():
    one = "time,x\n0,1.5\n0.001,2.25\n"
    assert same(one, one) == 4
    with pytest.raises(Failed, match=r"^row 2: `x` is 2.25 and 2.2500000000000004$"):
        same(one, one.replace("2.25", "2.2500000000000004"))
    for other in ("time,x\n0,1.5\n", ""):
        with pytest.raises(Failed):
            same(one, other)
    with pytest.raises(Failed, match="no numbers"):
        same("time,x\n", "time,x\n")


def test_differences_are_parts_of_the_largest_value():
    assert close(ROWS, ROWS, 0.0) == (4, 0.0)
    other = ROWS.replace("0.5", "0.25")
    assert close(ROWS, other, 0.0625) == (4, 0.0625)
    with pytest.raises(Failed, match=r"^`x` differs by 2.5e-01, which is 6.2e-02 of its largest value$"):
        close(ROWS, other, 0.06)


@pytest.mark.parametrize("other", [ROWS.replace("0.5", "nan"), "time,x\n0,-4\n", ROWS.replace("x", "y")])
def test_what_cannot_be_compared_is_refused(other):
    with pytest.raises(Failed):
        close(ROWS, other, 1.0)

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from labbook.demo.writers import delimited_text


@given(
    hnp.arrays(np.float64, st.integers(1, 20), elements=st.floats(-999_999, 999_999, width=64)),
    st.integers(1, 6),
)
def test_values_have_all_their_decimals_and_round_to_nearest(values: np.ndarray, decimals: int) -> None:
    lines = delimited_text("x", [(values, decimals)]).decode().splitlines()
    assert lines[0] == "x"
    assert all(len(line.split(".")[1]) == decimals for line in lines[1:])
    written = np.array([float(line) for line in lines[1:]])
    np.testing.assert_allclose(written, values, rtol=0, atol=0.5 * 10.0**-decimals + 1e-9)


def test_small_and_negative_values_are_never_scientific() -> None:
    text = delimited_text("x", [(np.array([1e-6, -1e-6, 0.0, -0.5]), 6)])
    assert text == b"x\n0.000001\n-0.000001\n0.000000\n-0.500000\n"


def test_integers_have_no_point_and_line_ends_are_as_asked() -> None:
    columns = [(np.array([1, 20]), 0), (np.array([0.5, 0.5]), 2)]
    assert delimited_text("a,b", columns, line_end="\r\n") == b"a,b\r\n1,0.50\r\n20,0.50\r\n"

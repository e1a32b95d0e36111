"""What is a number in a file."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from it2hys.support.numerals import parse_number


@given(st.floats())
def test_what_python_writes_is_read_to_the_same_bits(number):
    read = parse_number(repr(number))
    assert read == number or (math.isnan(read) and math.isnan(number))


@pytest.mark.parametrize(
    "text", ["1", "-1", "+1.5", ".5", "5.", "1e-5", "1E+05", " 2 ", "INF", "-INF", "NaN"]
)
def test_what_xml_and_csv_write_is_read_as_python_does(text):
    assert repr(parse_number(text)) == repr(float(text))


@pytest.mark.parametrize(
    "text",
    [
        "",
        " ",
        ".",
        "e5",
        "1e",
        "1_0e-5",
        "1_000",
        "١٢",
        "１",
        "1\u00a0",
        "1,5",
        "0x10",
        "1d3",
        "1 0",
        "--1",
    ],
)
def test_all_else_is_no_number(text):
    with pytest.raises(ValueError, match="is not a number"):
        parse_number(text)

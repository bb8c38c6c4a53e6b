"""Records of quantities say what rows have: their outputs, dimensions, errors and derivatives."""

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.words.outputs import OUTPUTS
from vibropipe.words.vocabulary import ERROR_SUFFIX, SENSITIVITY_SUFFIX, STEADY

SOFT = vp.Exciter(l=0.5, nu=1.2, f=0.8, h=0.1, R1=0.7, R2=0.7, k1=50, friction=0.01)
RIGID = vp.Exciter(l=0.5, nu=1.2, f=0.8, h=0.1, R1=0.7, R2=0.7)


@pytest.mark.parametrize(
    ("exciter", "effects"), [(RIGID, {""}), (SOFT, {"", "soft", "friction"})], ids=["rigid", "soft"]
)
def test_a_row_has_what_records_say_and_nothing_else(exciter, effects):
    row = vp.sweep(exciter, {"nu": [1.2]}, outputs=OUTPUTS, accuracy=1e-6)
    of_rows = {name: entry for name, entry in STEADY.items() if entry.effect in effects}
    assert {*of_rows} == {str(name) for name in row if name in STEADY}
    for name, entry in of_rows.items():
        dims = [dim for dim in row[name].dims if dim != "nu"]
        assert dims == ["phase" if dim == "tau" else dim for dim in entry.dims]
        assert (name + ERROR_SUFFIX in row) == entry.has_error
        assert (name + SENSITIVITY_SUFFIX in row) == entry.has_derivative
        assert (row[name].dtype.kind == "c") == entry.is_complex
        if not (entry.is_signed or entry.is_complex or name == "residual"):
            assert (np.nan_to_num(row[name].values.astype(float)) >= -1e-12).all()
        if entry.largest_of:
            assert np.nanmax(row[name]) == np.nanmax(row[entry.largest_of])


@pytest.mark.parametrize("output", OUTPUTS[:-1])
def test_an_output_adds_its_own_quantities_alone(output):
    row = vp.sweep(RIGID, {"nu": [1.2]}, outputs=[output])
    assert {STEADY[str(name)].output for name in row if name in STEADY} == {"", output}

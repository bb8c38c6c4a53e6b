"""Datasets as tables of pandas and as CSV: the numbers of xarray, names for codes, nothing multiplied."""

import io
import sys
from dataclasses import replace

import dask
import dask.array as da
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from command_line import run

import vibropipe as vp
from vibropipe.solve.physical import in_units
from vibropipe.store import StoreError, save, table
from vibropipe.store.table import without_constants
from vibropipe.words.regimes import Regime

EXCITER = vp.Exciter(l=0.5, nu=1.0, f=-1, h=0.2, R1=0.7, R2=0.7)
OVER = {"nu": [0.6, 1.0, 1.7], "f": [0.02, 0.5, 1.0, 2.0]}


@pytest.fixture(scope="module")
def sweep():
    return vp.sweep(EXCITER, OVER, harmonics=2)


@pytest.fixture
def folder(sweep, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    save(sweep, "results/s/map.nc")
    return tmp_path


def test_a_row_for_each_point_of_the_grid(sweep):
    rows = vp.table(sweep)
    assert len(rows) == 12
    assert list(rows.columns[:7]) == ["nu", "f", "h", "l", "delta", "R1", "R2"]
    for row in rows.itertuples():
        point = sweep.sel(nu=row.nu, f=row.f)
        assert row.regime == Regime(int(point["regime"])).name.lower()
        assert row.displacement_amplitude_2 == float(point["displacement_amplitude"][1])
        assert row.floquet_multiplier_1_im == complex(point["floquet_multiplier"][0]).imag
    assert set(rows["l"]) == {0.5}


def test_a_row_for_each_impact(sweep):
    impacts = vp.table(sweep, impacts=True)
    assert len(impacts) == sweep.sizes["impact"] > 0
    hardest = (
        impacts.assign(speed=impacts["impact_velocity"].abs())
        .groupby(["nu", "f", "impact_support"])["speed"]
        .max()
    )
    for (nu, f, support), speed in hardest.items():
        point = sweep.sel(nu=nu, f=f, support=int(support[-1]))
        largest = float(point["impact_velocity_max"])
        if point["period_multiple"] > 0:
            assert speed == pytest.approx(largest, rel=1e-14)
        else:  # the largest of a window, of whose last periods the impacts are listed
            assert speed <= largest * (1 + 1e-14)


def test_a_motion_has_a_row_for_each_sample():
    motion = vp.simulate(EXCITER, 20.0, samples_per_period=32)
    rows = vp.table(motion)
    np.testing.assert_array_equal(rows["tau"], motion["tau"])
    np.testing.assert_array_equal(rows["velocity"], motion["velocity"])
    assert set(rows["status"]) == {"ok"}
    np.testing.assert_array_equal(
        vp.table(motion, impacts=True)["impact_velocity"], motion["impact_velocity"]
    )


@pytest.mark.parametrize("friction", [0.0, 0.15])
def test_a_motion_without_samples_is_one_row(friction):
    exciter = replace(EXCITER, friction=friction)
    motion = vp.simulate(exciter, 20.0, samples_per_period=0, energy=True)
    rows = vp.table(motion)
    assert len(rows) == 1
    assert rows["displacement_end"].notna().all()
    assert not {"turn", "turn_tau", "stick", "stick_start"} & {*rows.columns}
    assert len(vp.table(motion, impacts=True)) == motion.sizes["impact"] > 0


def test_a_study_a_node_and_a_file_give_the_same(sweep, folder):
    expected = vp.table(sweep)
    node = vp.open_study("results/s")["map"]
    for source in (node, "results/s/map.nc", vp.load("results/s/map.nc")):
        pd.testing.assert_frame_equal(vp.table(source), expected)


def test_impacts_that_were_not_asked_for_are_said_to_be_missing():
    quiet = vp.sweep(EXCITER, {"nu": [1.0]}, outputs=["harmonics"])
    with pytest.raises(StoreError, match="where its scene takes the output impacts"):
        vp.table(quiet, impacts=True)


def test_csv_holds_every_digit(sweep, folder, capsys):
    assert run("table", "results/s/map.nc", "-o", "out/map.csv") == 0
    assert run("table", "results/s/map.nc", "--impacts", "--output", "out/impacts.csv") == 0
    pd.testing.assert_frame_equal(
        pd.read_csv("out/map.csv"), vp.table(sweep), check_dtype=False, check_exact=True
    )
    assert len(pd.read_csv("out/impacts.csv")) == sweep.sizes["impact"]
    capsys.readouterr()
    assert run("table", "results/s/map.nc") == 0
    assert len(pd.read_csv(io.StringIO(capsys.readouterr().out))) == 12


def test_columns_that_never_change_can_be_left_out(sweep, folder, capsys):
    capsys.readouterr()
    assert run("table", "results/s/map.nc", "--varying") == 0
    kept = pd.read_csv(io.StringIO(capsys.readouterr().out))
    whole = vp.table(sweep)
    filled = whole.astype(object).where(whole.notna(), "none")
    changing = [name for name in filled if len({*filled[name]}) > 1]
    assert list(kept) == changing
    assert "h" in whole
    assert "h" not in changing
    one = whole.iloc[:1]
    assert without_constants(one) is one


def test_what_has_no_number_is_empty(sweep):
    """The impacts of a chatter, and the stability of a motion without an orbit."""
    dims = sweep["regime"].dims
    edited = sweep.copy(deep=True)
    edited["rests_per_orbit"].loc[{"support": 1}] = 1.0
    edited["period_multiple"][...] = 0
    frame = vp.table(edited)
    assert frame["impacts_per_orbit_1"].isna().all()
    assert frame["impacts_per_period_1"].isna().all()
    assert not frame["impacts_per_orbit_2"].isna().any()
    assert frame["stable"].isna().all()
    assert len(frame) == np.prod([sweep.sizes[dim] for dim in dims])


def test_mistakes_are_said_and_leave_nothing(folder, capsys):
    assert run("table", "results/s/maps.nc", "-o", "x.csv") == 2
    assert run("table", "results/s", "-o", "x.csv") == 2
    assert "Traceback" not in capsys.readouterr().err
    assert not (folder / "x.csv").exists()


def test_each_lazy_quantity_is_read_once(sweep):
    reads = []

    def read(values, name):
        reads.append(name)
        return values

    lazy = sweep.copy()
    for name in ("displacement_amplitude", "floquet_multiplier", "regime"):
        chunk = da.from_delayed(
            dask.delayed(read)(sweep[name].values, name), sweep[name].shape, sweep[name].dtype
        )
        lazy[name] = sweep[name].copy(data=chunk)
    pd.testing.assert_frame_equal(vp.table(lazy), vp.table(sweep))
    assert sorted(reads) == ["displacement_amplitude", "floquet_multiplier", "regime"]


def test_samples_of_orbits_do_not_multiply_the_rows(sweep):
    every = ("harmonics", "impacts", "motion", "stability", "energy")
    sampled = vp.sweep(EXCITER, OVER, harmonics=2, outputs=every)
    rows = vp.table(sampled)
    assert len(rows) == 12
    assert set(vp.table(sweep).columns) <= set(rows.columns)
    pd.testing.assert_frame_equal(vp.table(sampled, impacts=True), vp.table(sweep, impacts=True))


def test_what_is_asked_of_the_program_has_a_row_for_each_accuracy():
    coords = {"motion": ["one"], "method": ["exact", "newmark"], "accuracy": [1e-3, 1e-6]}
    both = xr.Dataset(
        {
            "error_end": (("motion", "method", "setting"), [[[1e-13], [1e-4]]]),
            "asked_error": (("motion", "accuracy"), [[1e-13, 2e-13]]),
        },
        coords,
    )
    alone = table(both.isel(method=[0]))
    assert alone["accuracy"].tolist() == [1e-3, 1e-6]
    assert alone["asked_error"].tolist() == [1e-13, 2e-13]
    assert alone["error_end"].tolist() == [1e-13, 1e-13]
    race = table(both)
    assert race["error_end"].tolist() == [1e-13, 1e-4]
    assert race["asked_error_1e-06"].tolist() == [2e-13, 2e-13]


def test_sections_have_a_row_for_each_state_at_the_section(tmp_path, monkeypatch, capsys):
    swept = vp.sweep(EXCITER, {"nu": [0.6, 1.0], "f": [0.5, 1.0]}, outputs=["poincare"])
    points = table(swept, sections=True)
    assert len(points) == swept.poincare_displacement.size
    at = points[(points.nu == 1.0) & (points.f == 0.5)]
    part = swept.sel(nu=1.0, f=0.5)
    assert at.poincare_displacement.tolist() == part.poincare_displacement.values.tolist()
    assert at.poincare_velocity.tolist() == part.poincare_velocity.values.tolist()
    # A row without states, as one that was not solved, has none.
    empty = swept.where(swept.nu != 1.0).assign_coords(swept.coords)
    assert set(table(empty, sections=True).nu) == {0.6}
    monkeypatch.chdir(tmp_path)
    save(swept, "s.nc")
    assert run("table", "s.nc", "--sections") == 0
    head, *lines = capsys.readouterr().out.splitlines()
    assert head.startswith("nu,f,visit,")
    assert len(lines) == len(points)


def test_sections_that_are_not_there_are_refused(sweep):
    with pytest.raises(StoreError, match="sections: are not in this dataset"):
        table(sweep, sections=True)
    with pytest.raises(StoreError, match="impacts, sections: must not be asked for at once"):
        table(sweep, impacts=True, sections=True)


def test_designs_are_numbered_as_in_reports():
    designs = xr.Dataset({"f": ("design", [0.8, 0.9])})
    assert vp.table(designs).to_dict("list") == {"design": [1, 2], "f": [0.8, 0.9]}


def test_a_table_is_written_in_the_units_that_are_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    exciter = vp.Exciter.from_physical(
        m="0.35 kg", C="6 N/mm", H="4 N s/m", F="12 N", l="4 mm", omega="22 Hz", R1=0.6, R2=0.6
    )
    si = vp.to_physical(vp.steady_state(exciter), 0.35, 6000.0)
    save(si, "x.nc")
    read = {}
    for units in ("SI", "Hz, mm"):
        assert run("table", "x.nc", "--units", units) == 0
        read[units] = pd.read_csv(io.StringIO(capsys.readouterr().out)).iloc[0]
    assert read["SI"]["omega (rad/s)"] == pytest.approx(2 * np.pi * 22, rel=1e-12)
    assert read["Hz, mm"]["omega (Hz)"] == pytest.approx(22.0, rel=1e-12)
    assert read["Hz, mm"]["l (mm)"] == pytest.approx(4.0, rel=1e-12)
    assert read["SI"]["F (N)"] == read["Hz, mm"]["F (N)"] == pytest.approx(12.0, rel=1e-12)


@pytest.mark.parametrize(
    ("units", "must"),
    [
        ("Hz, rpm", "units: must have one unit of frequency, got Hz and rpm"),
        ("mmm", "units: must be SI or units of "),
        ("mm,", "units: must be SI or units of "),
    ],
)
def test_units_that_are_none_are_refused(units, must, sweep):
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.2)
    si = vp.to_physical(vp.steady_state(exciter), 0.35, 6000.0)
    with pytest.raises(vp.ParameterError, match=must):
        in_units(si, units)
    with pytest.raises(
        vp.ParameterError, match="units: must be left out: the dataset has no units"
    ):
        in_units(sweep, units)


def test_the_section_of_a_motion_has_rows_of_its_own():
    motion = vp.simulate(EXCITER, 20.0, samples_per_period=16)
    visits = xr.Dataset({"poincare_displacement": ("visit", [0.1, 0.2, np.nan])})
    points = table(motion.merge(visits), sections=True)
    assert points["poincare_displacement"].tolist() == [0.1, 0.2]
    assert points["visit"].tolist() == [0, 1]


def test_a_sheet_has_the_numbers_and_names_of_the_csv(folder, capsys):
    assert run("table", "results/s/map.nc", "--varying", "-o", "map.csv") == 0
    assert run("table", "results/s/map.nc", "--varying", "-o", "map.xlsx") == 0
    listed, sheet = pd.read_csv("map.csv"), pd.read_excel("map.xlsx")
    assert [*sheet.columns] == [*listed.columns]
    for name in listed:
        if listed[name].dtype.kind == "f":  # sheets have 16 digits
            np.testing.assert_allclose(sheet[name].astype(float), listed[name], rtol=1e-15)
        else:
            assert (sheet[name].fillna("") == listed[name].fillna("")).all(), name


def test_what_a_sheet_cannot_hold_is_told(folder, monkeypatch, capsys):
    module = sys.modules["vibropipe.store.table"]  # beside the function of this name
    monkeypatch.setattr(module, "MAX_SHEET", (10, 16_384))
    assert run("table", "results/s/map.nc", "-o", "map.xlsx") == 2
    assert "a sheet has at most 10 rows, the table 13: write .csv" in capsys.readouterr().err
    monkeypatch.setattr(module, "find_spec", lambda _name: None)
    assert run("table", "results/s/map.nc", "-o", "map.xlsx") == 2
    assert "openpyxl: is not installed: pip install 'vibropipe[xlsx]'" in capsys.readouterr().err
    assert not [*folder.glob("*.xlsx*")]

"""Two datasets beside each other: what is told of them, and what cannot be compared."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import vibropipe as vp
from vibropipe.cli.commands import app
from vibropipe.jobs.comparison import compare_datasets
from vibropipe.jobs.comparison_told import as_lines, as_table, draw
from vibropipe.store import save

EXCITER = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.1, R1=0.7, R2=0.7)
OVER = {"nu": np.linspace(0.8, 1.0, 5), "f": [0.6, 1.2]}
OUTPUTS = ["harmonics", "impacts", "stability"]


@pytest.fixture(scope="module")
def pair() -> tuple[xr.Dataset, xr.Dataset]:
    """Return a sweep of one exciter, and of one with another restitution."""
    other = replace(EXCITER, R1=0.69)
    return vp.sweep(EXCITER, OVER, outputs=OUTPUTS), vp.sweep(other, OVER, outputs=OUTPUTS)


def test_equal_datasets_agree_in_all(pair: tuple[xr.Dataset, xr.Dataset]) -> None:
    found = compare_datasets(pair[0], pair[0])
    assert (found.settings, found.laws, found.changes, found.left_out) == ([], [], [], [])
    assert (found.rows, found.only) == (10, (0, 0))
    assert found.same > 10
    assert as_table(found).empty


def test_what_differs_is_told_with_its_row(pair: tuple[xr.Dataset, xr.Dataset]) -> None:
    one, two = pair
    found = compare_datasets(one, two)
    assert [tuple(each) for each in found.settings] == [("R1", "0.7", "0.69")]
    change = next(each for each in found.changes if each.name == "impact_velocity_max")
    moved = np.abs(two.impact_velocity_max - one.impact_velocity_max)
    assert change.largest == float(moved.max())
    top = moved.isel({k: int(v) for k, v in moved.argmax(...).items()})
    assert change.where == (
        f"nu = {float(top.nu):.12g}, f = {float(top.f):.12g}, support = {int(top.support)}"
    )
    laws = [(one[n] != two[n]) for n in ("regime", "period_multiple")]
    orbits = (one.impacts_per_orbit != two.impacts_per_orbit).any("support") & (one.regime < 5)
    assert len(found.laws) == int((laws[0] | laws[1] | orbits).sum())


def test_only_rows_of_both_are_compared(pair: tuple[xr.Dataset, xr.Dataset]) -> None:
    one = pair[0].drop_dims("impact")
    found = compare_datasets(one, one.isel(nu=slice(2, None)))
    assert (found.rows, found.only, found.changes) == (6, (4, 0), [])
    assert "6 rows over nu, f in both, 4 in A alone, 0 in B alone" in as_lines(found)


def test_phases_of_velocities_have_the_errors_of_displacements(
    pair: tuple[xr.Dataset, xr.Dataset],
) -> None:
    one = pair[0]
    error = one["displacement_phase_error"].fillna(0.0) + 1e-6
    one = one.assign(displacement_phase_error=error)
    for times, changed in ((1.9, []), (2.1, ["velocity_phase"])):
        two = one.assign(velocity_phase=one["velocity_phase"] + times * error)
        assert [each.name for each in compare_datasets(one, two).changes] == changed


def test_values_within_their_errors_agree(pair: tuple[xr.Dataset, xr.Dataset]) -> None:
    one = pair[0]
    shift = 1e-6 * float(abs(one.velocity_strobe).max())
    two = one.assign(velocity_strobe=one.velocity_strobe + shift)
    assert [each.name for each in compare_datasets(one, two).changes] == ["velocity_strobe"]
    error = xr.full_like(one.velocity_strobe, 0.6 * shift)
    known = [data.assign(velocity_strobe_error=error) for data in (one, two)]
    assert compare_datasets(*known).changes == []


def test_angles_differ_the_short_way_round(pair: tuple[xr.Dataset, xr.Dataset]) -> None:
    one = pair[0]
    turned = one.displacement_phase + (2 * np.pi - 1e-3)
    two = one.assign(displacement_phase=turned.assign_attrs(one.displacement_phase.attrs))
    (change,) = compare_datasets(one, two).changes
    assert change.largest == pytest.approx(1e-3, rel=1e-9)


def test_what_cannot_be_compared_is_refused(pair: tuple[xr.Dataset, xr.Dataset]) -> None:
    one = pair[0]
    line = vp.sweep(EXCITER, {"nu": [0.8, 0.9]})
    with pytest.raises(vp.ParameterError, match="B: must have rows over nu, f, as A has, got nu"):
        compare_datasets(one, line)
    far = line.assign_coords(nu=[2.0, 3.0])
    empty = line.isel(nu=slice(0))
    for whose, both in (("A", (empty, line)), ("B", (line, empty))):
        with pytest.raises(vp.ParameterError, match=f"{whose}: must have rows over nu .*got none"):
            compare_datasets(*both)
    with pytest.raises(vp.ParameterError, match="rows in common with A, got none of 2 rows"):
        compare_datasets(line, far)
    with pytest.raises(vp.ParameterError, match="pictures are of sweeps over one or two"):
        draw(vp.steady_state(EXCITER), vp.steady_state(EXCITER), compare_datasets(line, line))


def test_the_command_writes_a_table_and_pictures(
    pair: tuple[xr.Dataset, xr.Dataset], tmp_path
) -> None:
    one, two = (str(tmp_path / f"{name}.nc") for name in "ab")
    for data, path in zip(pair, (one, two), strict=True):
        save(data, path)
    for name in ("c.csv", "c.pdf"):
        done = CliRunner().invoke(app, ["compare", one, two, "-o", str(tmp_path / name)])
        assert done.exit_code == 0, done.output
        assert (tmp_path / name).stat().st_size > 100
    assert "R1       0.7  0.69" in done.output
    assert (tmp_path / "c.csv").read_text().startswith("name,unit,rows,largest,relative,where")


def test_rows_without_coordinates_are_compared_by_their_numbers() -> None:
    one = vp.branch(replace(EXCITER, f=-0.6), "f", -0.5)
    n = one.sizes["point"]
    found = compare_datasets(one, one)
    assert (found.over, found.rows, found.changes) == (["point"], n, [])
    assert f"{n} rows over point in both, 0 in A alone, 0 in B alone" in as_lines(found)
    moved = one.velocity_strobe.copy(deep=True)
    moved[3] += 0.5
    change = next(
        each for each in compare_datasets(one, one.assign(velocity_strobe=moved)).changes
        if each.name == "velocity_strobe"
    )  # fmt: skip
    assert (change.rows, change.where) == (1, "point 3")
    regime = one.regime.copy(deep=True)
    regime[2] = 5
    assert compare_datasets(one, one.assign(regime=regime)).laws[0].startswith("point 2: ")
    must = f"as many rows over point as A, {n}: they have numbers alone, got {n - 1}"
    with pytest.raises(vp.ParameterError, match=must):
        compare_datasets(one, one.isel(point=slice(1, None)))
    with pytest.raises(vp.ParameterError, match="pictures are of sweeps"):
        draw(one, one, found)


def test_codes_differ_without_a_size(pair: tuple[xr.Dataset, xr.Dataset]) -> None:
    one = pair[0]
    stable = one.stable.copy(deep=True)
    stable[0, 0] = 1 - stable[0, 0]
    found = compare_datasets(one, one.assign(stable=stable))
    (change,) = found.changes
    assert (change.name, change.rows) == ("stable", 1)
    assert np.isnan(change.largest)
    assert any("another code" in line for line in as_lines(found))


def test_datasets_without_laws_are_compared_by_the_rows_of_their_tables() -> None:
    one = vp.backbone(0.1, np.linspace(3.2, 6.0, 4))
    found = compare_datasets(one, one)
    assert found.laws is None
    assert found.rows == 4
    assert not any(line.startswith("law of motion") for line in as_lines(found))
    borders = vp.boundary(EXCITER, "grazing", within=((0.8, 1.2), (0.2, 0.8)), lines=3)
    found = compare_datasets(borders, borders)
    assert "support" not in found.over
    assert "multiplier" not in found.over


def test_the_command_tells_values_in_the_units_of_the_study(tmp_path) -> None:
    exciter = vp.Exciter.from_physical(
        m="0.35 kg", C="6 N/mm", H="4 N s/m", F="12 N", l="4 mm", omega="22 Hz", R1=0.6, R2=0.6
    )
    paths = []
    for name, load in (("a", 0.0), ("b", 1e-4)):
        row = vp.to_physical(vp.steady_state(replace(exciter, delta=load)), 0.35, 6000.0)
        paths.append(str(tmp_path / f"{name}.nc"))
        save(row.assign_attrs(display_units="frequency: Hz; length: mm"), paths[-1])
    done = CliRunner().invoke(app, ["compare", *paths])
    assert done.exit_code == 0, done.output
    assert "delta    0 mm  0.1 mm" in done.output

"""`vp.plot`: the picture of every kind of dataset, datasets over one another, and what is refused."""

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from command_line import printed
from matplotlib.figure import Figure
from matplotlib.text import Text

import vibropipe as vp
from vibropipe.figures.units import display_units
from vibropipe.jobs.solving import solve_to_file
from vibropipe.study import load_study

NU = np.linspace(0.6, 1.8, 13)
BOX = {"along": ("nu", "f"), "within": ((0.9, 1.1), (0.3, 0.5)), "lines": 2, "max_step": 0.1}
MEASURED = {"nu": [0.8, 1.0, 1.2, 1.4], "displacement_amplitude_1": [0.3, 0.5, 0.52, 0.45]}


def exciter(**changed: float) -> vp.Exciter:
    return vp.Exciter(
        **{**{"l": 0.5, "nu": 1.0, "f": 0.5, "h": 0.2, "delta": 0.05, "R1": 0.7, "R2": 0.7}, **changed}
    )  # fmt: skip


OF_MOTOR, LINE = ["stability", "power", "sensitivity"], {"no_load": 2.2, "stall": 0.55}


def rotor() -> vp.Exciter:
    return vp.Exciter(nu=0.6, h=0.1, f=0.3, l=50.0)


MADE = {
    "motion": lambda: vp.simulate(exciter(), tau_end=20),
    "steady state": lambda: vp.steady_state(exciter(), outputs=["motion", "harmonics", "impacts"]),
    "sweep": lambda: vp.sweep(exciter(), over={"nu": NU}),
    "both ways": lambda: vp.sweep(exciter(), over={"nu": NU}, follow=("nu", "both")),
    "map": lambda: vp.sweep(exciter(), over={"nu": NU, "f": np.linspace(0.2, 1, 9)}),
    "branch": lambda: vp.branch(exciter(), "nu", (0.9, 1.2)),
    "branch without harmonics": lambda: vp.branch(exciter(), "nu", (0.9, 1.2), outputs=OF_MOTOR),
    "motor": lambda: vp.motor(vp.branch(rotor(), "nu", (0.2, 2.9), outputs=OF_MOTOR), LINE),
    "boundary": lambda: vp.boundary(exciter(), of="grazing", **BOX),
    "basins": lambda: vp.basins(exciter(), np.linspace(-0.4, 0.5, 5), np.linspace(-1, 1, 5), starts=16),
    "attractors": lambda: vp.attractors(exciter(), starts=16),
    "design": lambda: vp.design(exciter(), vary={"delta": (-0.2, 0.2)}, target={"displacement_mean": -0.03}),
    "tolerance": lambda: vp.tolerance(exciter(), {"delta": 0.01}, samples=64),
    "identify": lambda: vp.identify(exciter(), measured=MEASURED, vary={"f": (0.3, 0.7)}),
    "free motion": lambda: vp.amplitude_frequency(exciter(), amplitude=np.linspace(0.2, 2, 9)),
    "backbone": lambda: vp.backbone([0, 0.2], np.linspace(3, 6, 9)),
}  # fmt: skip
# The picture drawn of each by default, by a text of its axes.
SHOWS = {
    "motion": r"velocity $\dot{x}$", "steady state": r"velocity $\dot{x}$", "sweep": "frequency of excitation",
    "both ways": "frequency of excitation", "map": "amplitude of excitation", "branch": "frequency of excitation",
    "branch without harmonics": "impacts per period", "motor": "torque added at a jump",
    "boundary": "amplitude of excitation", "basins": "velocity", "attractors": "at the section",
    "design": r"$\delta$ = −0.04",
    "tolerance": "deviation of", "identify": "misfit", "free motion": "eigenfrequency",
    "backbone": "period of free vibration",
}  # fmt: skip


@pytest.fixture(scope="module")
def made():
    """Datasets by name, each made once when it is first asked for."""

    class Made(dict):
        def __missing__(self, name):
            self[name] = MADE[name]()
            return self[name]

    return Made()


def labels(figure: Figure) -> str:
    """Return all texts of a figure."""
    texts = [text.get_text() for text in figure.findobj(Text)]
    return " | ".join(filter(None, texts)).replace("\n", " ")


@pytest.mark.parametrize("name", MADE)
def test_every_kind_of_dataset_has_its_picture(made, name, tmp_path):
    figure = vp.plot(made[name])
    assert isinstance(figure, Figure)
    assert SHOWS[name] in labels(figure)
    assert figure.get_figwidth() * 2.54 == pytest.approx(16.0)
    figure.savefig(tmp_path / "a.pdf")
    figure.savefig(tmp_path / "a.png", dpi=40)
    assert b"Libertinus" in (tmp_path / "a.pdf").read_bytes()


def test_a_picture_is_chosen_by_its_name(made):
    assert "velocity" in labels(vp.plot(made["motion"], "portrait"))
    assert len(vp.plot(made["sweep"], show=["displacement_mean"]).axes) < len(
        vp.plot(made["sweep"]).axes
    )


@pytest.mark.parametrize(
    ("name", "picture", "options", "message"),
    [
        ("sweep", "kurves", {}, "picture: must be a picture that fits the dataset (curves, bifurcation and spectrum), "
                                "got 'kurves' (did you mean 'curves'?)"),
        ("sweep", "map", {}, "picture: must be a picture that fits the dataset (curves, bifurcation and spectrum)"),
        ("sweep", None, {"shw": 1}, "shw: is an unknown key; must be one of pictures, show, backbone"),
        ("sweep", None, {"show": ["lyapunov_exponent"]}, "show: must name quantities that the dataset holds ("),
        ("motor", "branches", {}, "picture: must be a picture that fits the dataset (motor), got 'branches'"),
        ("sweep", None, {"backbone": "spine"}, "'spine' is a scene that is not known here"),
    ],
)  # fmt: skip
def test_what_cannot_be_drawn_is_refused(made, name, picture, options, message):
    with pytest.raises(vp.ParameterError) as caught:
        vp.plot(made[name], picture, **options)
    assert message in str(caught.value)


def test_a_steady_state_is_drawn_over_one_period_of_its_motion(made):
    given = {"omega": "9 Hz", "m": "2 kg", "C": "8 N/mm", "l": "8 mm", "H": "40 N s/m", "F": "120 N"}  # fmt: skip
    struck = vp.Exciter.from_physical(**given, C1="40 N/mm", H1="20 N s/m", R2=0.7)
    free = vp.steady_state(vp.Exciter(l=0.5), x0=0.3, v0=1.0, outputs=["motion", "impacts"])
    for row, ends in (
        (made["steady state"], 2 * np.pi),
        (vp.steady_state(struck, "1 mm", outputs=["motion", "impacts"]), 1000 / 9),  # ms
        (free, 2 * np.pi / float(free.base_frequency)),
        (vp.sweep(exciter(), {"nu": [0.8, 1.0]}, outputs=["motion", "impacts"]).isel(nu=1), 2 * np.pi),
    ):  # fmt: skip
        over_time = vp.plot(row).axes[0]
        x = next(line.get_ydata() for line in over_time.lines if len(line.get_xdata()) > 100)
        assert over_time.get_xlim() == pytest.approx((0.0, ends))
        assert x[-1] == pytest.approx(x[0])  # one period


@pytest.mark.parametrize(
    ("changed", "outputs", "message"),
    [
        ({}, ["harmonics"], "dataset: must hold the trajectory of its steady state: ask for the output motion, or"),
        ({"nu": 0.35, "f": 1.5, "h": 0.02, "delta": 0.4, "R1": 0.9, "R2": 0.9}, ["motion"],
         "dataset: must hold a periodic motion, of which one period is drawn: draw what simulate returns"),
    ],
)  # fmt: skip
def test_a_steady_state_without_its_orbit_is_refused(changed, outputs, message):
    row = vp.steady_state(exciter(**changed), outputs=outputs)
    with pytest.raises(vp.ParameterError, match=message):
        vp.plot(row)
    assert changed or "harmonic" in labels(vp.plot(row, "spectrum"))


def test_a_branch_without_stability_and_speeds_among_branches_are_refused(made):
    unknown = vp.branch(rotor(), "nu", 0.7, outputs=["harmonics"])
    with pytest.raises(vp.ParameterError, match="dataset: must be a branch with the output stab"):
        vp.plot(unknown)
    with pytest.raises(vp.ParameterError, match="dataset 2: must be branches, and not the speeds"):
        vp.plot([unknown, made["motor"]])


def test_what_no_study_draws_is_refused(made):
    with pytest.raises(vp.ParameterError, match="dataset: must be what a scene of a study holds"):
        vp.plot(vp.symmetric_orbit(exciter(delta=0.0)))
    with pytest.raises(vp.ParameterError, match=r"dataset: must be an xarray\.Dataset"):
        vp.plot(3)


def test_a_backbone_stands_under_curves(made):
    under, alone = (
        vp.plot(made["sweep"], **options) for options in ({"backbone": made["free motion"]}, {})
    )
    n_lines = [sum(len(ax.lines) for ax in figure.axes) for figure in (under, alone)]
    assert n_lines[0] > n_lines[1]


def curves_in(figure: Figure) -> list[set[str]]:
    return [{str(line.get_color()) for line in ax.lines} for ax in figure.axes]


def test_motions_lie_over_one_another(made):
    motions = [vp.simulate(exciter(f=f), tau_end=20) for f in (0.3, 0.5)]
    figure = vp.plot(motions)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["$f$ = 0.3", "$f$ = 0.5"]
    assert [len(colours) for colours in curves_in(figure)] == [2, 2]
    line = figure.axes[0].lines[0].get_xydata()
    x = np.interp(motions[0]["tau"], line[:, 0], line[:, 1])
    np.testing.assert_allclose(x, motions[0]["displacement"], atol=1e-6)
    named = vp.plot(dict(zip(("weak", "strong"), motions, strict=True)), show=["displacement"])
    assert [text.get_text() for text in named.legends[0].get_texts()] == ["weak", "strong"]
    assert len(named.axes) == 1
    si = vp.plot([vp.to_physical(each, "2 kg", "8 N/mm") for each in motions])
    assert si.axes[0].get_ylabel() == r"displacement $x\,$ (mm)"
    assert [text.get_text() for text in si.legends[0].get_texts()] == ["$F$ = 2.4 kN", "$F$ = 4 kN"]


def test_steady_states_lie_over_motions_and_over_sweeps(made):
    steady, motion = made["steady state"], made["motion"]
    for pair in ([steady, steady], [motion, steady]):
        last = vp.plot(pair).axes[0].lines[-1].get_xdata()
        assert (last[0], last[-1]) == pytest.approx((0.0, 2 * np.pi))
    over = vp.plot([made["sweep"], steady])
    assert r"\dot{x}{}^-" in labels(over)  # as in a report
    point = over.axes[0].lines[-1]
    assert point.get_xdata() == pytest.approx([1.0])
    assert point.get_marker() == "o"


def test_sweeps_and_branches_lie_over_one_another(made):
    figure = vp.plot([made["sweep"], made["both ways"], made["branch"]])
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["1", "2", "3"]
    assert [len(colours) for colours in curves_in(figure)] == [3, 3]
    points = np.concatenate([line.get_xydata() for line in figure.axes[1].lines])
    expected = made["sweep"]["impact_velocity_max"].max("support")
    for nu, value in zip(NU, expected.values, strict=True):
        if np.isfinite(value):
            assert np.nanmin(np.abs(points - [nu, value]).sum(axis=1)) < 1e-12


@pytest.mark.parametrize(
    ("names", "options", "message"),
    [
        (["motion", "sweep"], {}, "dataset: must be motions, or sweeps of one parameter and branches along it to be "
                                  "drawn over one another, got motion and sweep scenes"),
        (["basins", "basins"], {}, "got basins scenes"),
        (["sweep", "map"], {}, "dataset 2: must have one swept parameter"),
        (["sweep"] * 8, {}, "must be at most 7 datasets over one another, got 8"),
        (["sweep", "sweep"], {"show": ["displacement"]}, "show: must be quantities that all datasets hold (displ"),
        (["sweep", "sweep"], {"picture": "curves"}, "picture: must be left out where datasets are drawn over"),
        ([], {}, "dataset: must be at least one dataset"),
    ],
)  # fmt: skip
def test_datasets_that_cannot_lie_over_one_another(made, names, options, message):
    with pytest.raises(vp.ParameterError) as caught:
        vp.plot([made[name] for name in names], **options)
    assert message in str(caught.value)


STUDY = """\
title: T
physical: {m: 2 kg, C: 8 N/mm, H: 40 N s/m, F: 120 N, l: 8 mm, delta: 1 mm}
exciter: {R1: 0.7, R2: 0.6}
scenes:
  spine: {kind: backbone, amplitude: {start: 1 mm, stop: 20 mm, points: 9}}
  response:
    kind: sweep
    over: {omega: {start: 5 Hz, stop: 15 Hz, points: 11}}
    figure: {backbone: spine, show: [displacement_amplitude]}
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("plotted")
    (folder / "mine.yaml").write_text(STUDY)
    study = load_study(folder / "mine.yaml")
    for name in study.scenes:
        solve_to_file(study, name, folder / f"{name}.nc", None, 1)
    return folder


def test_a_scene_and_a_file_are_drawn_as_by_their_study(results):
    of_file = vp.plot(results / "response.nc")
    with vp.open_study(results) as tree:
        of_node = vp.plot(tree["response"])
        with pytest.raises(vp.ParameterError, match=r"must be a scene of a study \(.*response.*\)"):
            vp.plot(tree)
    for figure in (of_file, of_node):
        assert r"$\omega/2\pi\,$ (Hz)" in labels(figure)
        assert "(mm)" in labels(figure)
    all_panels = vp.plot(vp.load(results / "response.nc"), "curves")
    assert len(of_file.axes) == len(of_node.axes) < len(all_panels.axes)


def test_a_dataset_alone_is_drawn_without_the_other_scenes_of_its_study(results):
    alone, with_backbone = (
        vp.plot(vp.load(results / "response.nc")),
        vp.plot(results / "response.nc"),
    )
    assert len(alone.axes) == len(with_backbone.axes)
    assert len(alone.axes[0].lines) < len(with_backbone.axes[0].lines)


def test_python_chooses_units(made):
    motion = vp.to_physical(made["motion"], "2000 g", "8 N/mm", {"length": "cm", "time": "s"})
    assert motion["displacement"].attrs["units"] == "m"
    figure = vp.plot(motion)
    assert "(cm)" in labels(figure)
    assert "(s)" in labels(figure)
    assert float(display_units({"": motion})[""]["m"]) == 2000.0
    assert "(in)" in labels(vp.plot([motion, motion], units={"length": "in"}))
    with pytest.raises(
        vp.ParameterError, match=r"units\.length: .* got 'mmm' \(did you mean mm\?\)"
    ):
        vp.plot(motion, units={"length": "mmm"})
    with pytest.raises(
        vp.ParameterError, match=r"units: must be units by dimension .* got 'lenght'"
    ):
        vp.to_physical(made["motion"], 2, 8000, {"lenght": "mm"})


def test_an_exciter_remembers_the_units_it_was_given():
    exciter = vp.Exciter.from_physical(
        m="2 kg", C="8 N/mm", H="40 N s/m", F="0.12 kN", omega="9 Hz", l="8 mm", R1=0.7, R2=0.7
    )
    for copied in (pickle.loads(pickle.dumps(exciter)), copy.copy(exciter)):
        assert copied == exciter
        assert copied.written == exciter.written
    assert vp.Exciter(l=1.0).written == {}
    motion = vp.to_physical(vp.simulate(exciter, tau_end=6), exciter)
    by_hand = vp.to_physical(vp.simulate(exciter, tau_end=6), "2 kg", "8 N/mm")
    assert motion.drop_attrs().identical(by_hand.drop_attrs())
    assert motion["displacement"].attrs["units"] == "m"
    shown = display_units({"": motion})[""]
    units = {name: shown[name].attrs["units"] for name in ("displacement", "F", "omega", "C")}
    assert units == {"displacement": "mm", "F": "kN", "omega": "Hz", "C": "N/mm"}
    assert "(mm)" in labels(vp.plot(motion))
    metres = vp.to_physical(vp.simulate(exciter, tau_end=6), exciter, units={"length": "m"})
    assert "(m)" in labels(vp.plot(metres))
    for arguments in ((vp.Exciter(l=1.0),), (exciter, 8000)):
        with pytest.raises(vp.ParameterError, match="m: must be an exciter of from_physical"):
            vp.to_physical(motion.drop_vars(["m", "C"]), *arguments)


def test_importing_the_package_loads_no_pictures():
    names = ["matplotlib", "xarray", "vibropipe.scenes"]
    code = f"import sys, vibropipe; print({{*{names}}} & {{*sys.modules}})"
    assert printed(code) == "set()\n"

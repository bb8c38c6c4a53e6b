"""Progress of calls: `done` counts from the beginning of the call up to `total`."""

import pytest

import vibropipe as vp
from vibropipe.solve.sweep.blocks import solve_blocks
from vibropipe.solve.sweep.sweep import grid_of
from vibropipe.words.progress import WorkCount, part_of

EXCITER = vp.Exciter(l=0.5, nu=1.0, f=-1, h=0.2, R1=0.7, R2=0.7)
END = 2000.5 * EXCITER.period
NEWMARK = {"method": "newmark", "steps_per_period": 20, "tau_end": END}


@pytest.mark.parametrize(
    ("call", "total"),
    [
        (lambda heard: vp.simulate(EXCITER, tau_end=END, progress=heard), 2000),
        (lambda heard: vp.simulate(EXCITER, tau_start=0.6, tau_end=END, progress=heard), 2000),
        (lambda heard: vp.simulate(EXCITER, **NEWMARK, progress=heard), 2000),
        (lambda heard: vp.simulate(EXCITER, **NEWMARK, energy=True, progress=heard), 4000),
        (lambda heard: vp.basins(EXCITER, [0, 0.1], [0, 1, 2], starts=4, progress=heard), 6),
        (
            lambda heard: vp.basins(
                EXCITER, [0, 0.1], [0], starts=4, over={"nu": [0.9, 1.0]}, progress=heard
            ),
            4,
        ),
        # 16 samples, and both ends of the axis of one parameter
        (lambda heard: vp.tolerance(EXCITER, {"f": 0.01}, samples=16, progress=heard), 18),
        (
            lambda heard: list(
                solve_blocks(
                    grid_of(EXCITER, {"nu": [0.9, 1.0, 1.1, 1.2]}), 1, 4, 1, progress=heard
                )
            ),
            3,
        ),
    ],
)
def test_done_grows_to_the_total(call, total):
    counts = []
    call(lambda *each: counts.append(each))
    done = [each[0] for each in counts]
    assert done == sorted(done)
    assert {each[1] for each in counts} == {total}
    assert done[-1] == total


def test_the_total_of_a_motion_to_an_accuracy_is_unknown():
    counts = []
    progress = lambda *each: counts.append(each)  # noqa: E731
    vp.simulate(EXCITER, tau_end=50 * EXCITER.period, accuracy=1e-3, progress=progress)
    done = [each[0] for each in counts]
    assert done == sorted(done)
    assert done[-1] == 50  # marched once; another method would be marched beside it
    assert {each[1] for each in counts} == {0}


def test_a_part_reports_the_progress_of_all_work():
    counts = []
    part = part_of(lambda *each: counts.append(each), 3, 10)
    for done in (0, 4, 8):
        part(done, 8)
    assert counts == [(3, 10), (7, 10), (10, 10)]
    part = part_of(lambda *each: counts.append(each), 3, 0)
    part(4, 8)
    assert counts[-1] == (7, 0)
    assert part_of(None, 3, 10) is None


def test_a_count_ends_at_its_total():
    counts = []
    count = WorkCount(3, lambda *each: counts.append(each))
    for n in (1, 1, 5):
        count.add(n)
    assert counts == [(1, 3), (2, 3), (3, 3)]

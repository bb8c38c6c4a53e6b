"""A motion with soft supports and its steady state in one dataset: each has contacts over its own dimension."""

import numpy as np

import vibropipe as vp
from vibropipe.scenes.motion.solve import solve
from vibropipe.study import parse_study

# With losses by restitution all effects are called for, whose kernels other tests need as well.
SOFT = {"nu": 0.8, "f": 0.9, "l": 0.5, "h": 0.1, "k1": 20, "k2": 20, "h1": 0.2, "h2": 0.2}
MOTION = {"kind": "motion", "outputs": ["motion", "impacts", "harmonics"]}
STUDY = {"title": "Soft", "exciter": {**SOFT, "friction": 0.05}, "scenes": {"motion": MOTION}}
OF_EACH = ("impact_velocity_after", "contact_duration", "contact_force_max", "contact_depth_max")


def test_the_contacts_of_the_motion_and_those_of_its_orbit():
    scene = parse_study(STUDY).scenes["motion"]
    dataset = solve(scene)
    row = vp.steady_state(vp.Exciter(**scene.resolved_exciter()), outputs=("impacts",))
    for name in OF_EACH:
        assert dataset[name].dims == ("impact",)
        assert dataset[f"orbit_{name}"].dims == ("orbit_impact",)
        np.testing.assert_array_equal(dataset[f"orbit_{name}"].values, row[name].values)
    np.testing.assert_array_equal(dataset.support_force_max.values, row.support_force_max.values)
    assert dataset.sizes["impact"] > dataset.sizes["orbit_impact"]

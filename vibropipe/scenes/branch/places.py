"""Places of the bifurcations of branches: several branches have a row of the dataset for the same one."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.scenes.branch.lines import followed, kinds_present, swept

# Distance, as a share of the range followed, within which bifurcations of one kind are one.
SAME_PLACE = 1e-9

PLURALS = {
    "fold": "folds",
    "flip": "flips",
    "pitchfork": "pitchforks",
    "grazing": "grazings",
    "change": "changes of contacts, turns or sticks",
}


def places_of(dataset: xr.Dataset) -> dict[str, np.ndarray]:
    """Return for each kind that occurs the parameter at its places, in order.

    Mirror images have the same bifurcation, and at a grazing all branches end that meet there. Places at several values
    of a further parameter are several.
    """
    along, over = followed(dataset), swept(dataset)
    at = dataset[f"bifurcation_{along}"].values
    beside = dataset[over].values[dataset["bifurcation_point"].values] if over else 0.0 * at
    reach = SAME_PLACE * float(np.ptp(dataset[along].values))
    places = {}
    for kind, mask in kinds_present(dataset).items():
        found = []
        for value in np.unique(beside[mask]):
            own = np.sort(at[mask & (beside == value)])
            found.append(own[np.diff(own, prepend=-np.inf) > reach])
        places[kind] = np.sort(np.concatenate(found))
    return places

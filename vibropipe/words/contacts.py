"""Quantities of contacts with soft supports, which motions and steady states have only where there are any."""

from __future__ import annotations

from collections.abc import Mapping

OF_CONTACT: Mapping[str, str] = {
    "contact_duration": "contact_duration_max",
    "contact_force_max": "support_force_max",
    "contact_depth_max": "support_depth_max",
}
"""Those of each contact, over `impact`, and the largest of a steady state, over `support`."""

OF_SOFT: tuple[str, ...] = tuple(OF_CONTACT.values())
"""Those of a steady state."""

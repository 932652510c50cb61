"""Units in which people read quantities that are SI everywhere else; the page has the same table (plots/signals.ts)."""

SHOWN = {
    "m": ("mm", 1e3),
    "m/s": ("mm/s", 1e3),
    "m s": ("mm s", 1e3),
    "Pa": ("kPa", 1e-3),
    "N m": ("mN m", 1e3),
    "s": ("ms", 1e3),
    "ns": ("µs", 1e-3),
    "J": ("mJ", 1e3),
    "W": ("mW", 1e3),
}
"""By SI unit: the unit that is shown, and the factor from SI."""


def shown(unit: str) -> tuple[str, float]:
    """Unit and factor for values in `unit`, which stays as it is where people read it so."""
    return SHOWN.get(unit, (unit, 1.0))

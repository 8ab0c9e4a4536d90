"""Reading and writing RINEX: observations and broadcast navigation, versions 2 to 4."""

from importlib import import_module

_HOME_OF = {
    "RinexError": "errors",
    "read_rinex_obs": "observation_reader",
    "write_rinex_obs": "observation_writer",
    "read_rinex_nav": "navigation_reader",
    "write_rinex_nav": "navigation_writer",
}

__all__ = sorted(_HOME_OF)


def __getattr__(name):
    if name not in _HOME_OF:
        raise AttributeError(f"gnsslab.gnss.rinex has no public name {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME_OF[name]}"), name)


def __dir__():
    return sorted([*globals(), *_HOME_OF])

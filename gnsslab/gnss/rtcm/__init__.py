"""Reading RTCM 3 logs (RTCM 10403.3, 2016): MSM observations, broadcast ephemerides, station messages."""

from importlib import import_module

_HOME_OF = {
    "RtcmError": "errors",
    "RtcmLog": "reader",
    "is_rtcm": "reader",
    "read_rtcm": "reader",
}

__all__ = sorted(_HOME_OF)


def __getattr__(name):
    if name not in _HOME_OF:
        raise AttributeError(f"gnsslab.gnss.rtcm has no public name {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME_OF[name]}"), name)


def __dir__():
    return sorted([*globals(), *_HOME_OF])

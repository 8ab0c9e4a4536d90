"""Presets: situations worth simulating, as data. Truth and noise only; how to solve them is not said here."""

from dataclasses import dataclass, replace

import numpy as np

from gnsslab.simulate.events import Gap, Outage, Slip, Street, event_claims
from gnsslab.simulate.receivers import LOW_COST, SIGNALS, SURVEY, Clock, Noise
from gnsslab.simulate.sky import NOMINAL_IONOSPHERE
from gnsslab.simulate.trajectories import Car, Hop, Ship, Static, Turntable

_TWO_CLOCKS = (Clock(offset=2.0e-6, drift=3e-9), Clock(offset=-5.0e-6, drift=-8e-9))  # steered receivers, each on its own quartz
_MOST_ANTENNAS = 4


@dataclass(frozen=True)
class Preset:
    """One situation: where, when, what moves, what is measured and what goes wrong. Change one with `dataclasses.replace`.

    Antennas stand on the moving body, lever arms in its axes (right, forward, up). With `base` there is a receiver at rest
    besides, which then is the master; without, the first antenna is. One clock a receiver, the master's first.
    """

    name: str
    title: str
    sentence: str  # what to look at
    site: tuple[float, float, float]  # latitude, longitude [deg], ellipsoidal height [m]: where the trajectory counts from
    start: str  # GPS time, "2024-06-24T08:00:00"
    duration: float  # [s]
    trajectory: object  # with .at(seconds) -> Pose
    antennas: tuple[tuple[float, float, float], ...]  # lever arms on the body [m]
    interval: float = 1.0  # [s]
    systems: str = "GECJ"
    bands: int = 2
    satellites: tuple[str, ...] = ()  # only these; none named: all of the systems
    mask_deg: float = 5.0  # nothing is recorded below
    base: tuple[float, float, float] | None = None  # east, north, up [m] of a base at rest from the site
    clocks: tuple[Clock, ...] = _TWO_CLOCKS
    noise: Noise = SURVEY
    events: tuple = ()
    ionosphere: tuple[float, ...] | None = NOMINAL_IONOSPHERE  # Klobuchar coefficients of the true ionosphere; None: none
    humidity: float | None = 0.7  # of the true (Saastamoinen) troposphere; None: no troposphere

    def __post_init__(self):
        for claim, sentence in _claims(self):
            if not claim:
                raise ValueError(f"preset {self.name!r}: {sentence}")

    @property
    def epochs(self):
        """Number of epochs T."""
        return round(self.duration / self.interval)

    @property
    def time(self):
        """Receiver time tags (T,), datetime64[ns] in GPS time."""
        nanoseconds = np.round(np.arange(self.epochs) * self.interval * 1e9).astype("timedelta64[ns]")
        return np.datetime64(self.start, "ns") + nanoseconds

    @property
    def receivers(self):
        """Number of receivers: antennas on the body, and the base."""
        return len(self.antennas) + (self.base is not None)


def _claims(preset):
    """Yield what must be true of a preset, and the sentence to say where it is not."""
    latitude, longitude, height = preset.site
    yield abs(latitude) <= 90 and abs(longitude) <= 360, f"site is latitude and longitude in degrees and height in metres; it is {preset.site}"
    yield -1000 < height < 20_000, f"the site's height must be from -1000 to 20000 m; it is {height}"
    yield _is_time(preset.start), f"start is a GPS time such as 2024-06-24T08:20:00; it is {preset.start!r}"
    yield preset.interval > 0, f"interval must be above zero [s]; it is {preset.interval}"
    yield preset.epochs >= 1, f"duration must hold one interval of {preset.interval} s at least; it is {preset.duration} s"
    yield preset.systems and set(preset.systems) <= set(SIGNALS), f"systems are the letters G, E, C and J; they are {preset.systems!r}"
    yield preset.bands in (1, 2, 3), f"bands must be 1, 2 or 3; it is {preset.bands}"
    yield 0 <= preset.mask_deg < 90, f"mask_deg must be from 0 to below 90; it is {preset.mask_deg}"
    yield 1 <= len(preset.antennas) <= _MOST_ANTENNAS, f"one to four antennas fit on the body; there are {len(preset.antennas)}"
    yield preset.receivers >= 2, "a baseline needs two receivers: give a second antenna or a base"
    yield len(set(preset.antennas)) == len(preset.antennas), "two antennas stand in one place; move one of them"
    yield len(preset.clocks) == preset.receivers, f"{preset.receivers} receivers need as many clocks; there are {len(preset.clocks)}"
    for event in preset.events:
        yield from event_claims(event, preset.epochs, preset.receivers, preset.systems)


def _is_time(text):
    try:
        return not np.isnat(np.datetime64(text, "ns"))
    except ValueError:
        return False


def find_preset(name):
    """Return the preset of that name.

    >>> find_preset("static-baseline").title
    'Two antennas on a roof'
    """
    if name not in PRESETS:
        raise ValueError(f"there is no preset {name!r}; the presets are {', '.join(PRESETS)}")
    return PRESETS[name]


def with_length(preset, length):
    """Return the preset with the first two antennas that distance [m] apart: all lever arms are scaled about the body's origin.

    >>> with_length(find_preset("static-baseline"), 2.5).antennas
    ((0.0, 0.0, 0.0), (0.0, 2.5, 0.0))
    """
    if len(preset.antennas) < 2:
        raise ValueError(f"preset {preset.name!r} has one antenna on its body, so there is no length to set; choose one with two")
    if not (np.isfinite(length) and length > 0):
        raise ValueError(f"the distance between the antennas must be above zero [m]; it is {length}")
    first, second = np.array(preset.antennas[:2])
    scale = length / np.linalg.norm(second - first)
    return replace(preset, antennas=tuple(tuple(float(x) for x in np.multiply(arm, scale)) for arm in preset.antennas))


# Paper A (papers' calibration): low-cost receivers at 25.286 N 110.33 E, GPS L1 and BeiDou B1I of the second generation.
# The paper gives no time of day, so the start is free. Of the minutes of a week with 15 satellites in view throughout, this one's
# geometry comes nearest to the calibrated scatter: sigma 0.42 deg of heading, 1.27 of pitch by one epoch of carriers, 3.0 times as much.
_PAPER_A = {
    "site": (25.286, 110.33, 150.0),
    "start": "2019-03-16T12:35:00",
    "systems": "GC",
    "bands": 1,
    "satellites": tuple([f"G{k:02d}" for k in range(1, 33)] + [f"C{k:02d}" for k in (*range(1, 13), 14)]),
    "mask_deg": 15.0,
    "noise": Noise(
        code=0.7, carrier=0.003, doppler=0.05, code_multipath=0.4, code_multipath_time=20.0, carrier_multipath=0.0045, carrier_multipath_time=60.0
    ),
}
_ROOF = (35.1347, 136.9776, 104.9)

_ALL = (
    Preset(
        "static-baseline",
        "Two antennas on a roof",
        "Survey receivers 1.167 m apart see every system on two bands: heading to a few tenths of a degree from the first second.",
        _ROOF,
        "2024-06-24T08:20:00",
        300.0,
        Static(heading_deg=35.0, pitch_deg=4.0),
        ((0.0, 0.0, 0.0), (0.0, 1.167, 0.0)),
    ),
    Preset(
        "paper-a-static",
        "Paper A: low-cost receivers at rest",
        "Every satellite loses lock at 300 and at 500 s: does the heading survive it?",
        duration=650.0,
        trajectory=Static(heading_deg=35.0),
        antennas=((0.0, 0.0, 0.0), (0.0, 1.167, 0.0)),
        events=(Slip(300, antennas=(1,)), Slip(500, antennas=(1,))),
        **_PAPER_A,
    ),
    Preset(
        "paper-a-turntable",
        "Paper A: low-cost receivers on a turntable",
        "Still for 50 s, then 6 degrees a second; lock is lost at 150 s, and the master's epoch 218 is missing.",
        duration=300.0,
        trajectory=Turntable(still=50.0, rate_deg_s=6.0, heading_deg=35.0),
        antennas=((0.0, -0.5835, 0.0), (0.0, 0.5835, 0.0)),
        events=(Slip(150, antennas=(1,)), Gap(218, 218, antennas=(0,))),
        **_PAPER_A,
    ),
    Preset(
        "car-rtk",
        "A car one kilometre from its base",
        "A bridge at 150 s hides the sky for five seconds: how long until centimetres are back?",
        _ROOF,
        "2024-06-24T08:20:00",
        300.0,
        Car(centre_enu=(800.0, 600.0, 0.0)),
        ((0.0, 0.0, 1.5),),
        base=(0.0, 0.0, 0.0),
        noise=LOW_COST,
        events=(Outage(150, 154, antennas=(1,)),),
    ),
    Preset(
        "ship-heading",
        "A ship's heading in the waves",
        "Two antennas two metres apart along the keel of a ship that rolls 6 degrees and pitches 2.",
        (34.65, 139.20, 38.0),
        "2024-06-24T01:00:00",
        300.0,
        Ship(),
        ((0.3, -1.0, 8.0), (0.3, 1.0, 8.0)),
        noise=LOW_COST,
    ),
    Preset(
        "car-heading",
        "A car's heading in the hills",
        "Two antennas along the roof, a metre apart, on a road with slopes of up to 13 %: heading and pitch of the car itself.",
        _ROOF,
        "2024-06-24T08:20:00",
        300.0,
        Car(height=6.0, speed=15.0),
        ((0.0, -0.5, 1.5), (0.0, 0.5, 1.5)),
        noise=LOW_COST,
    ),
    Preset(
        "car-clocks",
        "A fast car and a clock that steps",
        "Antennas across the roof; the rover's clock is up to half a millisecond off, in which the car drives 1 cm: half a degree of heading.",
        _ROOF,
        "2024-06-24T08:20:00",
        300.0,
        Car(size=400.0, speed=20.0),
        ((-0.5, 0.0, 1.5), (0.5, 0.0, 1.5)),
        noise=LOW_COST,
        clocks=(Clock(offset=2.0e-6, drift=3e-9), Clock(drift=4e-5, jump=1e-3)),
    ),
    Preset(
        "city-heading",
        "A car's heading between houses",
        "Two streets hide most of the sky, a bridge all of it: what is lost, and how soon is it back?",
        _ROOF,
        "2024-06-24T08:20:00",
        300.0,
        Car(speed=8.0),
        ((0.0, -0.5, 1.5), (0.0, 0.5, 1.5)),
        noise=LOW_COST,
        events=(Street(60, 110, roofs_deg=50.0), Outage(150, 156), Street(190, 240, roofs_deg=70.0)),
    ),
    Preset(
        "drone-hop",
        "A drone's hop",
        "Up 40 m, once around in 60 s, banked up to 22 degrees, and down again.",
        _ROOF,
        "2024-06-24T08:20:00",
        140.0,
        Hop(),
        ((0.0, 0.0, 0.1),),
        base=(-30.0, -40.0, 0.0),
        interval=0.2,
    ),
    Preset(
        "four-antennas",
        "Four antennas on one body",
        "Three baselines give all three angles, and one to spare.",
        _ROOF,
        "2024-06-24T08:20:00",
        300.0,
        Ship(speed=0.0, turn_deg_s=1.0, heave=0.2),
        ((0.0, 0.0, 0.0), (0.0, 1.2, 0.0), (1.0, 0.0, 0.0), (1.0, 1.2, 0.3)),
        clocks=(*_TWO_CLOCKS, Clock(1e-5, 2e-9), Clock(-8e-6, 5e-9)),
        noise=LOW_COST,
    ),
    Preset(
        "static-rtk-5km",
        "Five kilometres from the base",
        "Both ends rest; the ionosphere and troposphere of the two are not quite the same any more.",
        _ROOF,
        "2024-06-24T08:20:00",
        600.0,
        Static(place_enu=(3000.0, 4000.0, 35.0)),
        ((0.0, 0.0, 0.0),),
        base=(0.0, 0.0, 0.0),
    ),
)
PRESETS = {preset.name: preset for preset in _ALL}

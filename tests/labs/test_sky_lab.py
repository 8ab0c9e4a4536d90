"""Lab of the whole sky: every corner of every control computes or explains itself; presets show what they promise."""

import numpy as np
import pytest

from gnsslab.labs import sky
from gnsslab.labs.sky import sky_lab
from gnsslab.simulate.receivers import white_factor

LAB = "sky"


def test_too_few_satellites_are_said_in_words(lab):
    assert "satellites above 60 deg" in lab.run(systems="E", mask_deg=60).problem


def test_table_has_one_row_a_satellite_and_epoch(lab):
    result = lab.run()
    columns = lab.table(result)
    assert len({len(column) for column in columns.values()}) == 1
    assert len(columns["satellite"]) == np.isfinite(result.view.elevation).sum() > 90


@pytest.mark.parametrize("settings", [{}, {"mask_deg": 30}, {"hour": 13, "latitude_deg": 0}, {"latitude_deg": 90}])
def test_dilution_is_that_of_our_own_inversion(lab, settings):
    """Plain normal equations with one clock, inverted by numpy, from azimuths and elevations alone."""
    view = lab.run(**settings).view
    used = view.used[view.shown]
    azimuth, elevation = view.azimuth[view.shown][used], view.elevation[view.shown][used]
    A = np.stack([np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), np.sin(elevation), np.ones(used.sum())], axis=1)
    D = np.diag(np.linalg.inv(A.T @ A))
    np.testing.assert_allclose(view.dop, np.sqrt([D.sum(), D[:3].sum(), D[:2].sum(), D[2]]), rtol=1e-9)


@pytest.mark.parametrize("systems", ["G", "GE"])
def test_the_promise_is_the_dilution_where_all_sigmas_are_alike(lab, systems):
    """With 3 m for all and one system, the promise is 3 m times HDOP and VDOP; a second clock makes it no better."""
    view = lab.run(sigma="flat", systems=systems).view
    if systems == "G":
        np.testing.assert_allclose(view.promised, 3.0 * view.dop[2:], rtol=1e-9)
    assert (view.promised >= 3.0 * view.dop[2:] * (1 - 1e-9)).all()


def test_residuals_scatter_by_the_simulated_law(lab):
    """White noise only, four systems: residuals over 0.5 m sqrt(1/2 + 1/(2 sin^2 el)) have unit scatter, less what the place and clocks took."""
    view = lab.run(systems="GECJ", multipath=0, code_noise=0.5, mask_deg=5).view
    unit = view.residual / (0.5 * white_factor(view.elevation))
    for low, high in ((5, 25), (25, 50), (50, 90)):
        part = unit[(np.degrees(view.elevation) >= low) & (np.degrees(view.elevation) < high) & np.isfinite(unit)]
        assert len(part) > 60
        assert np.std(part) == pytest.approx(1.0, abs=4 / np.sqrt(2 * len(part)) + 0.05)  # a clock takes one of ten


def test_residuals_do_not_depend_on_what_the_engine_found(lab):
    """They are held against the true place: with a mask that leaves four satellites they stay as large as they are."""
    all_in, few = (lab.run(mask_deg=mask, multipath=0).view for mask in (10, 35))
    both = np.isfinite(all_in.residual) & np.isfinite(few.residual)
    assert both.sum() >= 40
    assert np.std(few.residual[both]) == pytest.approx(np.std(all_in.residual[both]), rel=0.3)


def test_low_satellites_err_more(lab):
    view = lab.run(systems="GECJ", mask_deg=5).view
    low, high = (np.std(view.residual[mask & np.isfinite(view.residual)]) for mask in (view.elevation < 0.35, view.elevation > 0.87))
    assert low > 2 * high


def test_presets_show_what_they_promise(lab):
    view = {p.name: lab.run(**p.settings).view for p in lab.presets if "data" not in p.settings}
    start = view["sky"]
    assert np.nanmax(np.abs(start.residual)) < 2.0
    assert view["high-mask"].error[1] > 2 * start.error[1]
    assert view["high-mask"].dop[3] > 2 * start.dop[3]
    assert view["city"].dop[3] > 5
    assert (view["all-systems"].dop < 0.7 * start.dop).all()
    assert (view["all-systems"].error < 0.75 * start.error).all()
    assert np.nanmax(np.abs(view["bad-site"].residual)) > 10
    assert view["bad-site"].within < 0.4
    assert view["noon"].error[1] > 4
    low = np.degrees(view["noon"].elevation) < 15
    assert np.nanmean(view["noon"].residual[low]) > 1.5
    assert np.nanmax(np.degrees(view["pole"].elevation)) < 48
    assert view["three-centimetres"].within < 0.1
    assert (start.error > 10 * view["three-centimetres"].promised).all()


def test_gps_at_the_pole_stays_low():
    """From the pole an orbit of inclination i rises to tan el = (r sin i - R) / (r cos i)."""
    R, r, i = 6.357e6, 26.56e6, np.radians(55.8)  # [m]; the most inclined satellite of the simulated sky
    highest = np.degrees(np.arctan2(r * np.sin(i) - R, r * np.cos(i)))
    seen = max(np.nanmax(np.degrees(sky_lab().run(latitude_deg=90, hour=hour).view.elevation)) for hour in (0, 4, 8, 12))
    assert highest - 6 < seen < highest + 1


@pytest.mark.parametrize(
    ("settings", "name", "reached"),
    [
        ({}, "high", False),  # the mask is too low for the rule
        ({"mask_deg": 25}, "high", False),
        ({"mask_deg": 25, "systems": "GECJ"}, "high", True),
        ({"data": "station", "mask_deg": 25, "systems": "GECJ"}, "high", False),
        ({"mask_deg": 15}, "gps", False),
        ({"mask_deg": 15, "hour": 18}, "gps", True),
        ({"mask_deg": 15, "hour": 18, "systems": "GE"}, "gps", False),
    ],
)
def test_goals_are_judged(lab, settings, name, reached):
    is_reached, state = lab.goal(name).judge(lab.run(**settings))
    assert is_reached == reached, state
    assert state.startswith("Now: ")


def test_controls_without_effect_say_why(lab):
    assert set(lab.blocked(lab.settings())) == set(sky.FILES)
    for data in ("real", "station"):
        reasons = lab.blocked(lab.settings(data=data))
        assert set(sky.SIMULATION_ONLY) <= set(reasons)
        assert all(reasons.values())


def test_a_day_later_the_sky_is_another_but_a_little(lab):
    """Twelve sidereal hours bring GPS round once, twice a day: after 24 h the sky lags by 4 minutes, so it is nearly the same."""
    morning, evening = (lab.run(hour=hour).view for hour in (0, 24))
    common = sorted(set(morning.names) & set(evening.names))
    assert len(common) >= 8
    here, there = (view.elevation[view.shown][[view.names.index(name) for name in common]] for view in (morning, evening))
    moved = np.degrees(np.abs(here - there))
    assert 0.2 < np.nanmedian(moved) < 4.0


@pytest.mark.parametrize(("name", "data"), [("matrtklib-static", "real"), ("cssrlib-078", "station")])
def test_real_skies_give_the_known_place_to_metres(lab, dataset, name, data):
    dataset(name)
    view = lab.run(data=data, systems="GE").view
    assert view.is_truth_known
    assert (view.error < 5.0).all()  # [m], single points without corrections
    assert np.nanstd(view.residual[view.elevation < 0.5]) > np.nanstd(view.residual[view.elevation > 0.9])


def test_systems_that_are_not_there_are_said(lab):
    """The GEONET set holds no BeiDou: it is left out; without any of the chosen systems the words say which there are."""
    names = lab.run(data="station", systems="GECJ").view.names
    assert {name[0] for name in names} == set("GEJ")


def test_own_files_missing_are_named(lab):
    assert "your observation and navigation files are missing" in lab.run(data="mine").problem


def test_own_files_give_the_sky_of_the_simulation_they_came_from(lab, tmp_path):
    from dataclasses import replace

    from gnsslab.simulate import find_preset, simulate, write_simulation

    write_simulation(tmp_path, simulate(replace(find_preset("static-baseline"), systems="E"), np.random.default_rng(5)))
    files = {"observation_file": tmp_path / "rover.obs", "navigation_file": tmp_path / "broadcast.nav"}
    view = lab.run(data="mine", systems="E", **files).view
    assert not view.is_truth_known
    assert len(view.time) == 60
    assert (view.error < 3.0).all()
    assert "these observations hold no satellite of the chosen systems; they have E" in lab.run(data="mine", systems="G", **files).problem

"""Stand-in for simulator and engine until they are there; to be deleted."""

from types import SimpleNamespace

import numpy as np


def stand_in_attitude(settings):
    rng = np.random.default_rng(settings["seed"])
    T, L, psi = 300, settings["length"], 35.0
    b = L * np.array([np.sin(np.radians(psi)), np.cos(np.radians(psi)), 0.02])
    fraction = max(0.0, 1 - settings["mask_deg"] / 70 * (1 if settings["single_epoch"] else 0.3))
    status = np.where(rng.random(T) < fraction, 2, 1).astype(np.int8)
    status[:5] = 0
    sigma = np.where(status == 2, settings["carrier_noise"] * 1e-3, 0.3)[:, None] * [1, 1, 2]
    enu = b + sigma * rng.standard_normal((T, 3))
    enu[status == 0] = np.nan
    return SimpleNamespace(
        time=np.datetime64("2024-06-24T08:20:00", "ns") + np.arange(T) * np.timedelta64(1, "s"),
        status=status, heading=np.arctan2(enu[:, 0], enu[:, 1]) % (2 * np.pi),
        pitch=np.arctan2(enu[:, 2], np.hypot(enu[:, 0], enu[:, 1])), length=np.linalg.norm(enu, axis=1),
        baseline_enu=enu, sigma_heading=sigma[:, 0] / L, sigma_pitch=sigma[:, 2] / L, ratio=np.full(T, 5.0),
        satellites=np.full(T, 12),
    )  # fmt: skip


def stand_in_truth(settings):
    return SimpleNamespace(heading=np.radians(35.0), pitch=np.arctan(0.02), length=settings["length"])

"""Shares in per cent, with as many digits as matter."""


def percent(share):
    """Return a share in per cent with as many digits as tell it from 0 and from 100.

    >>> percent(0.5), percent(0.0008), percent(0.99993), percent(1.0)
    ('50.0', '0.08', '99.993', '100')
    """
    rare = 100 * min(share, 1 - share)
    digits = 1 if rare >= 0.95 else 2 if rare >= 0.0095 else 3
    return f"{100 * share:.{digits}f}" if rare >= 0.0005 else f"{round(100 * share)}"

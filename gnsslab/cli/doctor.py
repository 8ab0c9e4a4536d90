"""`gnsslab doctor`: what is missing, and what to type."""

EXAMPLE = "Example: gnsslab doctor"
MARKS = {"well": "ok  ", "hint": "note", "broken": "MISSING"}


def doctor():
    """Say in words what is missing on this machine and what to type."""
    from gnsslab.teaching.doctor import examine

    findings = examine()
    for finding in findings:
        print(f"{MARKS[finding.state]:8}{finding.words}")
    broken = [finding for finding in findings if finding.state == "broken"]
    if broken:
        raise ValueError(f"{len(broken)} of {len(findings)} checks failed; first: {broken[0].words}")

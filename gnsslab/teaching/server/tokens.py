"""The word that opens a class: drawn at random or chosen, typed by students from a projector, compared in constant time."""

import hmac
import re
import secrets

ALPHABET = "23456789abcdefghjkmnpqrstuvwxyz"  # none that is mistaken for another on a projector
FEWEST = 6  # letters and digits of a chosen one
CHOSEN = re.compile(r"[0-9A-Za-z-]{6,64}")


def new_token():
    """Return a token to read aloud: two groups of four, about 10^12 of them."""
    letters = [secrets.choice(ALPHABET) for _ in range(8)]
    return "".join(letters[:4]) + "-" + "".join(letters[4:])


def chosen_token(text):
    """Return a token that an instructor chose; raise ValueError for one that is too short or cannot stand in a link."""
    if not CHOSEN.fullmatch(text) or len(_bare(text)) < FEWEST:
        raise ValueError(f"--token {text}: expected 6 to 64 letters, digits and hyphens, at least 6 of them letters or digits")
    return text


def is_same_token(typed, token):
    """Return whether what was typed is the token, however it was spaced, hyphened or capitalised; the time tells nothing.

    >>> is_same_token(" K7MX 2fqp", "k7mx-2fqp"), is_same_token("k7mx", "k7mx-2fqp")
    (True, False)
    """
    return hmac.compare_digest(_bare(typed), _bare(token))


def _bare(text):
    return re.sub(r"[\s-]", "", text).lower().encode("utf-8")

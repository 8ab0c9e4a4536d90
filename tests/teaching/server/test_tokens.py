"""The token of a class: easily typed, hard to guess."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.teaching.server.tokens import chosen_token, is_same_token, new_token


def test_tokens_are_all_different_and_easily_read():
    tokens = {new_token() for _ in range(1000)}
    assert len(tokens) == 1000
    assert not set("".join(tokens)) & set("01ilo")
    assert all(chosen_token(token) == token for token in tokens)


@pytest.mark.parametrize("typed", ["k7mx-2fqp", "K7MX-2FQP", " k7mx 2fqp ", "k7mx2fqp"])
def test_what_is_read_from_a_projector_opens(typed):
    assert is_same_token(typed, "k7mx-2fqp")


@given(st.text())
def test_nothing_else_opens(typed):
    bare = "".join(letter for letter in typed.lower() if not letter.isspace() and letter != "-")
    assert is_same_token(typed, "k7mx-2fqp") == (bare == "k7mx2fqp")


@pytest.mark.parametrize("text", ["", "short", "with space", "a" * 65, "päßword", "what?no", "line\nbreak"])
def test_a_token_that_cannot_stand_in_a_link_is_refused_in_words(text):
    with pytest.raises(ValueError, match="expected 6 to 64 letters, digits and hyphens"):
        chosen_token(text)

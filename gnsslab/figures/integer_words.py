"""Integers and float values as they are written by hand, for pictures and what stands beside them."""

MINUS = "\N{MINUS SIGN}"
_SUBSCRIPTS = "\N{SUBSCRIPT ZERO}\N{SUBSCRIPT ONE}\N{SUBSCRIPT TWO}\N{SUBSCRIPT THREE}\N{SUBSCRIPT FOUR}"


def whole(integer):
    """Return an integer as text.

    >>> whole(-2) == MINUS + "2", whole(7)
    (True, '7')
    """
    return f"{integer:d}".replace("-", MINUS)


def decimal(number):
    """Return a number in two decimals, never minus zero.

    >>> decimal(-0.001), decimal(1.5)
    ('0.00', '1.50')
    """
    return f"{round(float(number), 2) + 0.0:.2f}".replace("-", MINUS)


def vector(integers):
    """Return integers as a vector.

    >>> vector([2, 0, 1])
    '(2, 0, 1)'
    """
    return "(" + ", ".join(map(whole, integers)) + ")"


def indexed(letter, k):
    """Return a letter with the subscript of entry k, which counts from 0: "a" and 0 give a with a small 1."""
    return letter + _SUBSCRIPTS[k + 1]


def combination(factors, letter):
    """Return a sum of multiples of indexed letters, those with the factor 0 left out.

    >>> combination([1, 0, 3], "a") == f"{indexed('a', 0)} + 3 {indexed('a', 2)}"
    True
    """
    terms = [(factor, ("" if abs(factor) == 1 else f"{abs(factor)} ") + indexed(letter, k)) for k, factor in enumerate(factors) if factor != 0]
    first = "".join(f"{MINUS if factor < 0 else ''}{term}" for factor, term in terms[:1])
    return first + "".join(f" {MINUS if factor < 0 else '+'} {term}" for factor, term in terms[1:])

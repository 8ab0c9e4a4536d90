"""The one error that reading or writing a RINEX file raises."""


class RinexError(ValueError):
    """A RINEX file that cannot be used: names the file, the line, what was expected and what stands there.

    >>> print(RinexError("base.obs", "expected an epoch line, found 'abc'", line=7))
    base.obs, line 7: expected an epoch line, found 'abc'
    """

    def __init__(self, file, problem, line=None):
        self.file, self.problem, self.line = str(file), problem, line
        place = self.file if line is None else f"{self.file}, line {line}"
        super().__init__(f"{place}: {problem}")

    def __reduce__(self):
        return type(self), (self.file, self.problem, self.line)


def quoted(text, width=40):
    """Return text in quotation marks for a message, unprintable characters escaped, cut to a readable width.

    >>> quoted(b"12a4 ")
    "'12a4'"
    """
    if isinstance(text, bytes):
        text = text.decode("latin-1")
    text = text.rstrip()
    return repr(text if len(text) <= width else text[: width - 3] + "...")

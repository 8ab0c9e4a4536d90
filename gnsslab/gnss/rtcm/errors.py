"""The one error that reading an RTCM log raises."""


class RtcmError(ValueError):
    """An RTCM log that cannot be used: names the file, what was expected and what was found.

    >>> print(RtcmError("base.rtcm3", "the file is empty; expected an RTCM 3 log"))
    base.rtcm3: the file is empty; expected an RTCM 3 log
    """

    def __init__(self, file, problem):
        self.file, self.problem = str(file), problem
        super().__init__(f"{self.file}: {problem}")

    def __reduce__(self):
        return type(self), (self.file, self.problem)

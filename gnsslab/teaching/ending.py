"""The end of a process that has served lessons."""

import os
import sys
import threading


def end_process(status):
    """End this process with an exit status; at once, where threads still work in the background.

    They may be inside the compiler or a compiled kernel. Python stops such a thread when it comes back from there, which
    aborts the whole process.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    if any(thread.daemon for thread in threading.enumerate()):
        os._exit(status)
    sys.exit(status)

"""`python -m gnsslab` is the command `gnsslab`."""

from gnsslab.cli import main
from gnsslab.teaching.ending import end_process


def run():
    """Run the command line and end the process."""
    end_process(main())


if __name__ == "__main__":
    run()

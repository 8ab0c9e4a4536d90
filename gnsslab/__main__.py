"""`python -m gnsslab` is the command `gnsslab`."""

import sys

from gnsslab.cli import main

sys.exit(main())

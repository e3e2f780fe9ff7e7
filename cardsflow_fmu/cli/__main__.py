"""`python -m cardsflow_fmu.cli`: the command line where no script is installed."""

import sys

from .main import main

sys.exit(main())

"""Command line as `python -m cardsflow_fmu.cli`, without an installed script."""

import sys

from .main import main

sys.exit(main())

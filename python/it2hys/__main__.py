"""`python -m it2hys`: the command line."""

import sys

from it2hys.cli import main

sys.exit(main())

"""`python -m vtbench`, the same as `vtbench`."""

import sys

from vtbench.cli import main

sys.exit(main())

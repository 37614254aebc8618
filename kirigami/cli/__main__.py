"""``python -m kirigami.cli`` is ``kirigami``."""

import sys

from kirigami.cli import main

sys.exit(main())

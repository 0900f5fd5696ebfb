"""python -m fvv_conformance is fvv-conformance."""

import sys

from .command import main

sys.exit(main())

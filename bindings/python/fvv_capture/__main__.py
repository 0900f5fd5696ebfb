"""python -m fvv_capture"""

import sys

from .command import main

if __name__ == "__main__":  # not in the processes of --jobs, which import this module
    sys.exit(main(sys.argv[1:]))

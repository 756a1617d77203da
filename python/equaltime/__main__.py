"""The command line as ``python -m equaltime``, for a Python whose ``equaltime`` script is not on the search path."""

import sys

from equaltime.cli import main

if __name__ == "__main__":
    sys.exit(main())

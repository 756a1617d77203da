"""``python -m equaltime``: the command line, where no script is installed or another Python is meant."""

import sys

from equaltime.cli import main

if __name__ == "__main__":
    sys.exit(main())

"""What all tests share."""

from __future__ import annotations

import signal

# A runner that was started in the background ignores Ctrl-C and would hand that on to the programs under test.
signal.signal(signal.SIGINT, signal.default_int_handler)

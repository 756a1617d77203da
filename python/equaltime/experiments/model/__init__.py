"""An experiment as a value, and the summary of what it found."""

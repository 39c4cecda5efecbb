"""What retrodict costs and how exact it is, measured: `python -m benchmarks`."""

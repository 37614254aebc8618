"""Many designs of any function: samples, workers, a resumable table."""

"""Parts that every node shares: start and stop, parameters, diagnostics, clocks."""

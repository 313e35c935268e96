"""Other planners on the same disc with the same map: OMPL's SST and pytorch_mppi, beside bounce and avoid."""

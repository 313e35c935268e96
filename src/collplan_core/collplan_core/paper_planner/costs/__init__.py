"""The cost terms of the paper, one file each. Paper: eq. (1) to (3), Alg. 1 and 2."""

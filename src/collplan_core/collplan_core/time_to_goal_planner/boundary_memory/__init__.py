"""The boundaries seen so far, and the clearance of the disc from them."""

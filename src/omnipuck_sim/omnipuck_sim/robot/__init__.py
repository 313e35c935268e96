"""The simulated Omnipuck: drive, contacts, noise."""

"""The live page: what it is sent, who may speak to it, and the page itself."""

"""How far strategies are from the best that a disc can do that may not touch anything and knows the map."""

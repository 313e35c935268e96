"""The paper's question: does harnessing collisions pay?"""

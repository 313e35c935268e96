"""The program bringup, in four questions.

What is chosen: options.py, the command line; preparation.py, what it is checked to mean.
What is started: graph.py, with one_process.py or processes.py.
What is watched: watching.py, bringup's own node and what a graph lacks; driving.py, one run on the graph.
How it ends: ending.py, exceptions, outcomes, exit codes; main.py, the results.
"""

"""`vtbench time`: what a sample costs, in fresh processes, one at a time, with a control."""

"""The `neohookean-reduced` rung: fast replay of one indenter along its axis, by POD and hyper-reduction.

It refuses what it was not trained with: another indenter, another place, a deeper or heavier press.
`python -m sensors.contact.neohookean_reduced` trains one and prints its errors and its speed.
"""

from sensors.contact.neohookean_reduced.basis import pod_basis
from sensors.contact.neohookean_reduced.pad import ReducedPad, Trained
from sensors.contact.neohookean_reduced.sampling import sample_elements
from sensors.contact.neohookean_reduced.train import train_reduced, training_depths

__all__ = ["ReducedPad", "Trained", "pod_basis", "sample_elements", "train_reduced", "training_depths"]

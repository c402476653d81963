"""How the backbone `vt-vgg` is made: shapes of its own, presses of them, the network, its training and the evidence."""

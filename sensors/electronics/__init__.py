"""From true taxel loads to the forces that a taxel array reads."""

"""The contact models scored: each against its closed forms, against the hyperelastic pad, and beside a peer solver."""

from sensors.contact.scoring.closed_forms import OracleRow, score_closed_forms
from sensors.contact.scoring.hyperelastic import SolidRow, against_hyperelastic
from sensors.contact.scoring.peer import PeerRow, compare_with_tamaas

__all__ = ["OracleRow", "PeerRow", "SolidRow", "against_hyperelastic", "compare_with_tamaas", "score_closed_forms"]

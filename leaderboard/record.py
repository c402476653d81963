"""The record and its files, by name: `Record` and its blocks, `write_record`, `read_records`, `read_predictions`."""

from leaderboard._files import (
    PREDICTIONS_FILE,
    RECORD_FILE,
    RecordWarning,
    read_predictions,
    read_records,
    scan_records,
    write_record,
)
from leaderboard._models import (
    SCHEMA_VERSION,
    Identity,
    Kind,
    Metric,
    Provenance,
    Record,
    Role,
    State,
    Status,
    Timing,
    Verdict,
    canonical_json,
    record_key,
)

__all__ = [
    "PREDICTIONS_FILE",
    "RECORD_FILE",
    "SCHEMA_VERSION",
    "Identity",
    "Kind",
    "Metric",
    "Provenance",
    "Record",
    "RecordWarning",
    "Role",
    "State",
    "Status",
    "Timing",
    "Verdict",
    "canonical_json",
    "read_predictions",
    "read_records",
    "record_key",
    "scan_records",
    "write_record",
]

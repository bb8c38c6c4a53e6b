"""Study files: from YAML to checked models. No other folder reads YAML.

`load_study` reads and checks a study, `load_config` the list of studies. A `StudyError` reports every fault of a file
at once. `fingerprint` is the hash of the keys that the data of a scene depend on.
"""

from vibropipe.scenes.keys.problems import Problem, StudyError
from vibropipe.study.identity import canonical_text, fingerprint, shown_now, study_at_hand
from vibropipe.study.loading import (
    Config,
    config_of_files,
    load_config,
    load_study,
    parse_config,
    parse_study,
    study_of_text,
)
from vibropipe.study.models import Study
from vibropipe.study.schema import json_schema, table_of_keys

__all__ = [
    "Config",
    "Problem",
    "Study",
    "StudyError",
    "canonical_text",
    "config_of_files",
    "fingerprint",
    "json_schema",
    "load_config",
    "load_study",
    "parse_config",
    "parse_study",
    "shown_now",
    "study_at_hand",
    "study_of_text",
    "table_of_keys",
]

"""The study file: YAML -> checked models. The only place of the project that knows YAML.

`load_study` reads and checks a study, `load_config` the list of studies; every fault of a file is
told at once in a `StudyError`. `fingerprint` names what a scene's data depend on.
"""

from vibropipe.scenes.keys.problems import Problem, StudyError
from vibropipe.study.identity import canonical_text, fingerprint
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
    "study_of_text",
    "table_of_keys",
]

"""The study file: YAML -> checked models. The only place of the project that knows YAML.

`load_study` reads and checks a study, `load_config` the list of studies; every fault of a file is
told at once in a `StudyError`. `fingerprint` names what a scene's data depend on.
"""

from vibropipe.study.accuracy import AccuracyScene
from vibropipe.study.base import BaseScene
from vibropipe.study.effect_costs import EffectsScene
from vibropipe.study.effects import grounds, scene_effects
from vibropipe.study.identity import canonical_text, data_keys, fingerprint
from vibropipe.study.loading import (
    Config,
    config_of_files,
    load_config,
    load_study,
    parse_config,
    parse_study,
    study_of_text,
)
from vibropipe.study.models import (
    BackboneScene,
    HardCasesScene,
    MotionScene,
    Scene,
    Study,
    SweepScene,
)
from vibropipe.study.parts import Solver, Start
from vibropipe.study.problems import Problem, StudyError
from vibropipe.study.schema import json_schema, table_of_keys

__all__ = [
    "AccuracyScene",
    "BackboneScene",
    "BaseScene",
    "Config",
    "EffectsScene",
    "HardCasesScene",
    "MotionScene",
    "Problem",
    "Scene",
    "Solver",
    "Start",
    "Study",
    "StudyError",
    "SweepScene",
    "canonical_text",
    "config_of_files",
    "data_keys",
    "fingerprint",
    "grounds",
    "json_schema",
    "load_config",
    "load_study",
    "parse_config",
    "parse_study",
    "scene_effects",
    "study_of_text",
    "table_of_keys",
]

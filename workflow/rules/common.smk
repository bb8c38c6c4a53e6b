# What the rules know of the studies: read once, here, before any job. Each rule depends on its own
# part of a study through `params` and never on the YAML file: an edit of one scene is seen by the
# jobs of that scene alone, a touched file by none.
import hashlib
import os
import re
import sys
import tempfile
from pathlib import Path

from snakemake.exceptions import WorkflowError

from vibropipe.cutting import PlanError
from vibropipe.jit import kernel_hash
from vibropipe.listing import plan_text
from vibropipe.plan import drawing_hash, plan_scene
from vibropipe.store.atomic import remove_leftovers
from vibropipe.study import StudyError, canonical_text, load_config, load_study
from vibropipe.study import fingerprint as fingerprint_of
from vibropipe.warm import work_of

NAME = "[a-z][a-z0-9_]*"
HOW_TO_GO_ON = """\
Not everything was made; the reason stands above, the logs lie under logs/. Give the same command
again when it is gone: what is finished is kept. If snakemake itself was killed and the next one finds
the folder locked, `snakemake --unlock` frees it."""


def read_studies():
    """Return the configuration, its studies and their plans; mistakes in them are told readably."""
    if workflow.config_settings.config:
        raise WorkflowError(
            "--config is not taken: write into config/config.yaml, or name another file with"
            " --configfile"
        )
    files = workflow.overwrite_configfiles or ["config/config.yaml"]
    try:
        settings = load_config(files[-1])
        studies = {
            name: load_study(settings.study_file(name)) for name in settings.studies
        }
        plans = {
            name: {scene.name: plan_scene(scene) for scene in study.scenes.values()}
            for name, study in studies.items()
        }
        if set(settings.results) & set("{}*"):
            raise PlanError(
                f"{files[-1]}: results: {settings.results!r}: allowed is no {{, }} or *"
            )
        return settings, studies, plans
    except (StudyError, PlanError) as error:
        raise WorkflowError(str(error)) from None


SETTINGS, STUDIES, PLANS = read_studies()
RESULTS = SETTINGS.results
if Path(RESULTS).exists() and not Path(RESULTS).is_dir():
    raise WorkflowError(f"{RESULTS} is a file, where the folder of results should be")

# Jobs find `vibropipe` beside the python that runs snakemake, its environment activated or not.
os.environ.update(
    PATH=os.pathsep.join([str(Path(sys.executable).parent), *os.get_exec_path()])
)


def check_results():
    """See, before any job, that results can be written."""
    try:
        Path(RESULTS).mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=RESULTS):
            pass
    except OSError as error:
        raise WorkflowError(
            f"{RESULTS} cannot be written ({error.strerror}): change its permissions, make room, or name"
            " another folder under `results` in config/config.yaml"
        ) from None


def clear_leftovers():
    """Remove the hidden files that killed writers left where this run is to write: it has locked these files."""
    made = {}
    for job in workflow.dag.needrun_jobs():
        for path in map(Path, job.output):
            made.setdefault(path.parent, set()).add(path.name)
    for folder, names in made.items():
        # shards belong to one sweep, however it was cut before
        remove_leftovers(folder, None if folder.parent.name == "shards" else names)


def tell_of_failure():
    """Tell what to do after a failure; after Ctrl-C that has been said."""
    if not stopped:
        say(HOW_TO_GO_ON)


def costs():
    """Return what each study will do and cost, finished or not."""
    return "\n\n".join(plan_text(study) for study in STUDIES.values()) + "\n"


def where_results_are():
    """Return the places a user looks at first."""
    return "\n".join(f"{RESULTS}/{name}/report.pdf" for name in STUDIES)


def works():
    """Return what has to be compiled for the scenes of all studies."""
    return sorted(
        {
            work_of(scene)
            for study in STUDIES.values()
            for scene in study.scenes.values()
        }
    )


def study_files():
    """Return the files of all studies."""
    return [str(SETTINGS.study_file(name)) for name in STUDIES]


def study_file(wildcards):
    """Return the file of a study, as the command line takes it."""
    return str(SETTINGS.study_file(wildcards.study))


def fingerprint(wildcards):
    """Return the hash of all that the data of a scene depend on."""
    return fingerprint_of(STUDIES[wildcards.study], wildcards.scene)


def takes_times(plan):
    """Return whether a scene measures times."""
    return plan.kind in ("accuracy", "effects")


def worth(plan):
    """Return how many threads a scene is worth for its work: one per four seconds of a sweep."""
    return max(1, round(plan.seconds / 4)) if plan.kind == "sweep" else 1


def is_wide(plan):
    """Return whether a scene wants more than one core."""
    return takes_times(plan) or worth(plan) > 1


def is_early(study, plan):
    """Return whether a scene that is one core's work should not come last: it is long, or its study is the one
    with the most figures, which are drawn by one core when all its scenes are there."""
    most = max(PLANS, key=lambda name: len(PLANS[name]))
    return plan.seconds > 4 or study == most


def scenes_regex(chosen, folder=""):
    """Return the names of the scenes that are chosen by study and plan, each behind its study's folder."""
    found = [
        f"(?<=/{study}/{folder})(?:{'|'.join(names)})"
        for study, plans in PLANS.items()
        if (names := [name for name, plan in plans.items() if chosen(study, plan)])
    ]
    return "|".join(found) or "(?!)"


def shards_of(wildcards):
    """Return the files of all shards of a sweep."""
    count = PLANS[wildcards.study][wildcards.scene].shards
    folder = f"{RESULTS}/{wildcards.study}/shards/{wildcards.scene}"
    return [f"{folder}/{shard:04d}.nc" for shard in range(1, count + 1)]


def sidecars_of(wildcards):
    """Return what the shards of a sweep tell of their times."""
    return [path.removesuffix(".nc") + ".json" for path in shards_of(wildcards)]


def cut(wildcards):
    """Return which shard of how many, as the command line takes it."""
    count = PLANS[wildcards.study][wildcards.scene].shards
    return f"{int(wildcards.shard)}/{count}"


def threads_of(wildcards):
    """Return how many threads a scene gets: all where times are measured, which is done alone."""
    plan = PLANS[wildcards.study][wildcards.scene]
    return workflow.cores if takes_times(plan) else worth(plan)


def datasets(name):
    """Return the datasets of a study."""
    return [f"{RESULTS}/{name}/{scene}.nc" for scene in STUDIES[name].scenes]


def pictures(name, suffix):
    """Return the figures of a study."""
    return [
        f"{RESULTS}/{name}/figures/{scene}.{suffix}" for scene in STUDIES[name].scenes
    ]


def shown(name, scene):
    """Return how `snakemake --report` shows the figure of a scene."""
    return {
        "caption": caption_file(name, scene),
        "category": STUDIES[name].title,
        "labels": {"scene": scene.name, "title": scene.title or scene.name},
    }


def pictures_for_report(name):
    """Return the figures of a study, each with its caption for `snakemake --report`."""
    drawn = zip(pictures(name, "svg"), STUDIES[name].scenes.values())
    return [report(path, **shown(name, scene)) for path, scene in drawn]


def caption_file(name, scene):
    """Write the caption of a scene where snakemake's report finds it; text stays only text."""
    words = " ".join((scene.caption or scene.title or scene.name).split())
    path = Path(".snakemake", "captions", name, f"{scene.name}.rst").absolute()
    text = re.sub(r"([^\w\s])", r"\\\1", words) + "\n"
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return str(path)


def words_hash(name):
    """Return the hash of all that a study says, titles and captions too."""
    return hashlib.sha256(canonical_text(STUDIES[name]).encode()).hexdigest()


def study_targets(name):
    """Return what is made of a study."""
    return [*datasets(name), *pictures(name, "svg"), f"{RESULTS}/{name}/report.pdf"]

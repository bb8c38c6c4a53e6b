# What this call is about: the studies, read once before any job, and what is said before and after.
import os
import re
import sys
import tempfile
from pathlib import Path

from vibropipe.jobs.run import read_run
from vibropipe.jobs.summary import summarise
from vibropipe.jobs.terminal_tables import plan_text
from vibropipe.jobs.drawing import drawing_hash
from vibropipe.scenes.costs import PlanError
from vibropipe.store.atomic import remove_leftovers
from vibropipe.study import StudyError

NAME = "[a-z][a-z0-9_]*"
HOW_TO_GO_ON = """\
Not everything was made; the reason stands above, the logs lie under logs/. Give the same command
again when it is gone: what is finished is kept. If snakemake itself was killed and the next one finds
the folder locked, `snakemake --unlock` frees it."""


def refuse(error, code=2):
    """End with one message and no traceback: 2 for a mistake in what was asked, 1 for a failure of the machine."""
    say(f"vibropipe: {error}")
    raise SystemExit(code)


def studies_of_this_call():
    """Return the studies; a mistake in them reads as it does from `vibropipe plan`."""
    files = workflow.overwrite_configfiles or [None]
    given = workflow.config_settings.config or {}
    try:
        # snakemake tells a workflow what it is asked for only when all rules are read
        return read_run(files[-1], given, sys.argv[1:])
    except (StudyError, PlanError) as error:
        refuse(error)


RUN = studies_of_this_call()
RESULTS = RUN.results

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
        refuse(
            f"{RESULTS} cannot be written ({error.strerror}): change its permissions, make room, or name"
            " another folder under `results` in config/config.yaml",
            code=1,
        )


def clear_leftovers():
    """Remove the hidden files that killed writers left where this run is to write: it has locked these files."""
    made = {}
    for job in workflow.dag.needrun_jobs():
        for path in map(Path, job.output):
            made.setdefault(path.parent, set()).add(path.name)
    for folder, names in made.items():
        # shards belong to one sweep, however it was cut before
        remove_leftovers(folder, None if folder.parent.name == "shards" else names)


def kept_outputs(jobs):
    """Return the files that jobs make and that stay, each with the time it has now (0 where there is none)."""
    paths = [
        str(path) for job in jobs for path in job.output if not path.is_flagged("temp")
    ]
    return {
        path: os.stat(path).st_mtime_ns if os.path.exists(path) else 0 for path in paths
    }


def summary_at_end():
    """Say study by study what was made; a run that made less than it should have ends with an error."""
    summary = summarise(RUN, kept_outputs(workflow.dag.jobs), planned)
    say("\n".join(summary.lines))
    if summary.missing:
        listed = "\n  ".join(summary.missing[:20])
        say(
            f"less was made than was asked for: missing or made of something else:\n  {listed}\n{HOW_TO_GO_ON}"
        )
        raise SystemExit(1)


def tell_of_failure():
    """Tell what to do after a failure; after Ctrl-C that has been said."""
    if not stopped:
        say(HOW_TO_GO_ON)


def costs():
    """Return what each study will do and cost, finished or not."""
    return "\n\n".join(plan_text(study) for study in RUN.studies.values()) + "\n"


def shown(name, scene):
    """Return how `snakemake --report` shows the figure of a scene."""
    return {
        "caption": caption_file(name, scene),
        "category": RUN.studies[name].title,
        "labels": {"scene": scene.name, "title": scene.title or scene.name},
    }


def figures_for_report(name):
    """Return the figures of a study, each with its caption for `snakemake --report`."""
    return [report(path, **shown(name, scene)) for path, scene in RUN.drawn(name, "svg")]


def caption_file(name, scene):
    """Write the caption of a scene where snakemake's report finds it; text stays only text."""
    words = " ".join((scene.caption or scene.title or scene.name).split())
    path = Path(".snakemake", "captions", name, f"{scene.name}.rst").absolute()
    text = re.sub(r"([^\w\s])", r"\\\1", words) + "\n"
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return str(path)


# what had to be made when the run began
planned = {}

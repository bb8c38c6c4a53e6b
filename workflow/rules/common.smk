# What this call is about: the studies, read once before any job, and what is said before and after.
import os
import sys
from pathlib import Path

from vibropipe.cli import exit_code
from vibropipe.jobs.drawing import drawing_hash
from vibropipe.jobs.run import FIRST, check_writable, clear_leftovers, read_run, write_caption
from vibropipe.scenes.costs import PlanError
from vibropipe.jobs.summary import HOW_TO_RESUME, file_times, summarise
from vibropipe.jobs.terminal_tables import plan_text
from vibropipe.store import NotWrittenError
from vibropipe.study import StudyError
from vibropipe.scenes.keys.values import NAME


def say(text):
    """Print for people; on stderr, since stdout may be a graph or a summary."""
    print(text, file=sys.stderr, flush=True)


def checked(call, *arguments):
    """Return what a call does; a mistake ends the run with one message, as `vibropipe` would."""
    try:
        return call(*arguments)
    except (StudyError, PlanError, NotWrittenError) as error:
        say(f"vibropipe: {error}")
        raise SystemExit(exit_code(error))


RUN = checked(
    read_run,
    (workflow.overwrite_configfiles or [None])[-1],
    workflow.config_settings.config or {},
    # snakemake tells a workflow what it is asked for only when all rules are read
    sys.argv[1:],
)
RESULTS = RUN.results
# The files that had to be made when the run began, with their times then.
PLANNED = {}

# Jobs find `vibropipe` beside the python that runs snakemake, its environment activated or not.
os.environ.update(
    PATH=os.pathsep.join([str(Path(sys.executable).parent), *os.get_exec_path()])
)


def prepare(jobs):
    """See, before any job, that results can be written; this run has locked the files of its jobs."""
    checked(check_writable, RESULTS)
    clear_leftovers(path for job in jobs for path in job.output)
    PLANNED.update(kept_outputs(jobs))


def kept_outputs(jobs):
    """Return the files that jobs make and that stay, with their times."""
    return file_times(
        str(path) for job in jobs for path in job.output if not path.is_flagged("temp")
    )


def summarise_run(jobs):
    """Say study by study what was made; a run that made less than it should have ends with an error."""
    summary = summarise(RUN, kept_outputs(jobs), PLANNED)
    say("\n".join(summary.lines))
    if summary.missing:
        raise SystemExit(1)


def costs():
    """Return what each study will do and cost, finished or not."""
    return "\n\n".join(plan_text(study) for study in RUN.studies.values()) + "\n"


def figures_for_report(name):
    """Return the figures of a study, each as `snakemake --report` shows it."""
    study, marked = RUN.studies[name], []
    for path, scene in RUN.drawn(name, "svg"):
        labels = {"scene": scene.name, "title": scene.title or scene.name}
        caption = write_caption(name, scene)
        marked += [report(path, caption=caption, category=study.title, labels=labels)]
    return marked

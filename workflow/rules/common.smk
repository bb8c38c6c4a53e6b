# The studies of this call, read once before any job, and the messages before and after the jobs.
import atexit
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

from vibropipe.cli import exit_code
from vibropipe.cli.orphans import RUN as RUN_OF_COMMAND
from vibropipe.cli.workers import WORKERS
from vibropipe.jobs.html_report import captions, is_requested, write_opening
from vibropipe.jobs.locks import RunRecord, drop_dead_locks
from vibropipe.jobs.run import (
    check_whole,
    check_working_folder,
    check_writable,
    clear_leftovers,
    read_run,
)
from vibropipe.jobs.summary import (
    HOW_TO_RESUME,
    PRINTED,
    causes,
    file_times,
    summarise,
)
from vibropipe.jobs.terminal_tables import plan_text
from vibropipe.scenes.costs import PlanError
from vibropipe.scenes.keys.values import NAME
from vibropipe.store import NotWrittenError, StoreError
from vibropipe.study import StudyError


def print_message(text):
    """Print to stderr, since stdout may be a graph or a summary."""
    print(text, file=sys.stderr, flush=True)


def exit_on_error(function, *arguments):
    """Return the result of a function; an error ends the run with the message and exit code of `vibropipe`."""
    try:
        return function(*arguments)
    except (StudyError, PlanError, StoreError, NotWrittenError) as error:
        print_message(f"vibropipe: {error}")
        raise SystemExit(exit_code(error))


RUN = exit_on_error(
    read_run,
    (workflow.overwrite_configfiles or [None])[-1],
    workflow.config_settings.config or {},
    # snakemake gives a workflow its targets only after all rules are read
    sys.argv[1:],
)
exit_on_error(check_working_folder)
RESULTS = RUN.results
# Files that had to be made when the run began, with their modification times then.
PLANNED = {}
# Logs with their modification times then.
LOGS = {}

# Whether this process runs jobs, and not one job or none.
MAKES = workflow.is_main_process and not workflow.output_settings.dryrun
RECORD = RunRecord()
if MAKES:
    drop_dead_locks()
    RECORD.write()

# Jobs find `vibropipe` beside the python that runs snakemake, even if its environment is not activated.
os.environ.update(
    PATH=os.pathsep.join([str(Path(sys.executable).parent), *os.get_exec_path()])
)


def outdated(*paths):
    """Return the input function of a job that makes these files: an input newer than they are where one is stale."""

    def mark(wildcards):
        # a job in its own call of snakemake is not asked whether it is needed
        if not workflow.is_main_process:
            return []
        named = dict(wildcards.items())
        return RUN.mark(*(path.format(**named) for path in paths))

    return mark


def prepare(jobs):
    """Check, before any job, what is read and written, and remove leftovers; the files of the jobs are locked."""
    if MAKES:
        RECORD.write()
        if workflow.local_exec:
            os.environ[RUN_OF_COMMAND] = str(RECORD.path.absolute())
    exit_on_error(check_writable, RESULTS)
    made = {path for job in jobs for path in job.output}
    exit_on_error(check_whole, [p for job in jobs for p in job.input if p not in made])
    clear_leftovers(made)
    PLANNED.update(kept_outputs(jobs))
    LOGS.update(file_times(str(path) for job in jobs for path in job.log))
    if workflow.local_exec:
        # Its limit, 100 jobs a second, needs a timer for each look for jobs, which leads to a further look after a
        # second: ever more of them, and the last one delays the end.
        workflow.scheduler.job_rate_limiter = None
    # elsewhere, and in containers, commands run by themselves
    if workflow.local_exec and not workflow.deployment_settings.deployment_method:
        alike = Counter(job.rule.name for job in jobs)  # jobs of a rule may run at once
        # a second one loads what figures need while the first one solves
        WORKERS.complete(min(workflow.cores, max(2, *alike.values())))


def kept_outputs(jobs):
    """Return the permanent files that jobs make, with their modification times."""
    return file_times(
        str(path) for job in jobs for path in job.output if not path.is_flagged("temp")
    )


def summarise_run(jobs):
    """Print what was made of each study; exit with an error if requested files are missing."""
    summary = summarise(RUN, kept_outputs(jobs), PLANNED)
    print_message("\n".join(summary.lines))
    PRINTED.append(summary)
    if summary.missing:
        raise SystemExit(1)


def explain_failure(jobs):
    """Print how to go on and, when snakemake has said all it says, why jobs failed."""
    print_message(HOW_TO_RESUME)
    report_on_the_rest({path for job in jobs for path in job.output})
    failed = [j for j in jobs if not all(os.path.exists(path) for path in j.output)]
    now = file_times(str(path) for job in failed for path in job.log)
    errors = causes(path for path, time in now.items() if time != LOGS.get(path))
    if errors:
        atexit.register(print_message, "\n".join(errors))


def report_on_the_rest(wanted):
    """Make the reports that were wanted without the scenes that failed; the next call tries these again."""
    for name, file in RUN.files.items():
        path = RUN.report(name)
        if path in wanted & RUN.stale:
            command = ["vibropipe", "report", str(file), "--results", RESULTS]
            command += ["--output", path, "--partial"]
            done = subprocess.run(command, capture_output=True, text=True)
            print_message(f"{name}: {done.stdout or done.stderr}".rstrip())


def plans_text():
    """Return the plans of all studies, with approximate run times."""
    return "\n\n".join(plan_text(study) for study in RUN.studies.values()) + "\n"


def figure_labels(wildcards):
    """Return the labels of a figure for `snakemake --report`."""
    scene = RUN.figure_scene(wildcards)
    picture = wildcards.figure.removeprefix(scene.name).removeprefix("-")
    picture = picture or [*scene.figure.chosen(), scene.kind][0]
    labels = dict(scene=scene.name, title=scene.title or scene.name)
    return labels | dict(picture=picture.replace("_", " "))


if is_requested(sys.argv):
    # read by workflow/report/figure.rst
    config["captions"] = {name: captions(RUN, name) for name in RUN.studies}
else:
    # snakemake would import pandas, a quarter of the time of a run without jobs, to ask whether a param is a table
    sys.modules.setdefault("pandas", None)

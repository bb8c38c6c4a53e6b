# The studies of this call, read once before any job, and the messages before and after the jobs.
import atexit
import subprocess
import sys
import time
from pathlib import Path

from vibropipe.jobs.html_report import (
    caption_files,
    figure_labels,
    is_requested,
    write_opening,
)
from vibropipe.jobs.preparation import (
    check_whole,
    check_working_folder,
    check_writable,
    clear_leftovers,
    keep_earlier,
    lock_results,
)
from vibropipe.jobs.plan import estimate_study
from vibropipe.jobs.processes import PARENT, exit_code
from vibropipe.jobs.run import read_run
from vibropipe.jobs.summary import (
    HOW_TO_RESUME,
    PRINTED,
    causes,
    changed_since,
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
    (workflow.configfiles or [None])[-1],
    config,
    # snakemake gives a workflow its targets only after all rules are read
    sys.argv[1:],
)
exit_on_error(check_working_folder)
RESULTS = RUN.results
BEGIN = time.time()

# A job of a cluster has its own call of snakemake, with the cores of that job.
IS_JOB = "--target-jobs" in sys.argv
# Cores that jobs share; None on a cluster.
CORES = None if IS_JOB else workflow.resource_settings.cores

# Jobs find `vibropipe` beside the python that runs snakemake, even if its environment is not activated, and end when
# that process is killed.
shell.prefix(f'export PATH="{Path(sys.executable).parent}:$PATH" {PARENT}=$PPID; exec ')


def outdated(*paths):
    """Return the input function of a job that makes these files: an input newer than they are where one is stale."""

    def mark(wildcards):
        if IS_JOB:  # which is not asked whether it is needed
            return []
        named = dict(wildcards.items())
        return RUN.mark(*(path.format(**named) for path in paths))

    return mark


def kept(study, name):
    """Return an output of a study, flagged to be left in place if it is up to date."""
    path = f"{RESULTS}/{{study}}/{name}"
    return path if path.format(study=study) in RUN.stale else update(path)


def prepare():
    """Check, before any job, what is read and written, lock it, and remove leftovers."""
    studies = RUN.at_work()
    exit_on_error(check_writable, RESULTS, studies)
    exit_on_error(lock_results, RESULTS, studies)
    made = [path for name in studies for path in RUN.datasets(name)]
    exit_on_error(check_whole, [path for path in made if path not in RUN.stale])
    clear_leftovers(RUN.stale)
    for name in studies:
        keep_earlier(RESULTS, RUN.studies[name], RUN.stale)
    print_message(plans_text())


def summarise_run():
    """Print what was made of each study; exit with an error if requested files are missing."""
    summary = summarise(RUN)
    print_message("\n".join(summary.lines))
    PRINTED.append(summary)
    if summary.missing:
        raise SystemExit(1)


def explain_failure():
    """Print how to go on and, when snakemake has said all it says, why jobs failed."""
    print_message(HOW_TO_RESUME)
    report_on_the_rest()
    errors = causes(
        path
        for name in RUN.at_work()
        for path in changed_since(BEGIN, f"logs/{name}/**/*.log")
    )
    if errors:
        atexit.register(print_message, "\n".join(errors))


def report_on_the_rest():
    """Make the reports that were wanted without the scenes that failed; the next call tries these again."""
    for name in RUN.at_work():
        path = RUN.report(name)
        if path in RUN.wanted and path in RUN.stale:
            program = str(Path(sys.executable).with_name("vibropipe"))
            command = [program, "report", str(RUN.files[name]), "--results", RESULTS]
            command += ["--output", path, "--partial"]
            done = subprocess.run(command, capture_output=True, text=True)
            print_message(f"{name}: {done.stdout or done.stderr}".rstrip())


def plans_text():
    """Return the plans of the studies that are made, with the run times that `vibropipe plan` states."""
    studies = [RUN.studies[name] for name in RUN.at_work()]
    return (
        "\n\n".join(plan_text(study, estimate_study(study)) for study in studies) + "\n"
    )


if not {"-n", "--dry-run", "--dryrun"}.isdisjoint(sys.argv):
    print_message(plans_text())

# Captions of `snakemake --report`, written for that call alone.
CAPTIONS = caption_files(RUN) if is_requested(sys.argv) else {}

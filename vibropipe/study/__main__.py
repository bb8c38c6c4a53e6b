"""`python -m vibropipe.study [FOLDER]`: renew the schema and the table of keys in that folder (default: `config`).

Without a folder also the pages of Python calls and quantities in `docs`.
"""

import sys
from pathlib import Path

from vibropipe.study import reference
from vibropipe.study.schema import write

if __name__ == "__main__":
    write(Path(sys.argv[1] if len(sys.argv) > 1 else "config"))
    if len(sys.argv) == 1:
        reference.write(Path("docs"))

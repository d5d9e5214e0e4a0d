#!/usr/bin/env python3
"""Makes all shares of a study with HyperQueue, and puts them together.

    hq.py SHARES DIR COMMAND…
    hq.py 16 studies/many bodyschema study learners --trials 1000 --jobs 1
    hq.py --local 16 studies/many bodyschema study …

The shares go to the server that runs (`hq server start`, and workers that `hq worker start` or `hq alloc add` start), or
with --local to one of this machine's own that ends with the script. Needs `pip install hyperqueue` of the server's version.
Can be called again at any time: only shares that are missing or were interrupted are made. What each share says is in
DIR/logs/SHARE.txt.
"""

import contextlib
import pathlib
import subprocess
import sys

from hyperqueue import Client, Job, LocalCluster
from hyperqueue.cluster import WorkerConfig


@contextlib.contextmanager
def client(local):
    """A client of the server that runs, or of one of this machine's own."""
    if not local:
        yield Client()
        return
    with LocalCluster(worker_config=WorkerConfig()) as cluster:
        yield cluster.client()


def main(words):
    local = words[:1] == ["--local"]
    words = words[local:]
    if len(words) < 4 or not words[0].isdigit():
        print(__doc__, file=sys.stderr)
        return 2
    shares, folder, command = int(words[0]), pathlib.Path(words[1]), words[2:]
    (folder / "logs").mkdir(parents=True, exist_ok=True)
    merge = [command[0], "study", "merge", str(folder)]
    missing = range(1, shares + 1)
    if (folder / "shares").is_dir():
        told = subprocess.run([*merge, "--missing"], check=True, capture_output=True, text=True)
        missing = [int(number) for number in told.stdout.strip().split(",") if number]
    if missing:
        # One share that fails does not keep the others from being made.
        job = Job(default_workdir=".", max_fails=None, name="bodyschema")
        for number in missing:
            log = str((folder / "logs" / f"{number}.txt").resolve())
            share = ["--quiet", "--shard", f"{number}/{shares}", "--out", str(folder)]
            job.program([*command, *share], stdout=log, stderr=log, name=f"share {number}")
        with client(local) as to:
            if not to.wait_for_jobs([to.submit(job)], raise_on_error=False):
                print(f"some shares failed: see {folder}/logs", file=sys.stderr)
    return subprocess.run(merge).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

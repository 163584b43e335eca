"""Builds many garments on a Dask cluster, or on the cores of this machine.

    pip install "dask[distributed]"
    python dask_batch.py garments/*.usd -o out
    python dask_batch.py garments/*.usd -o out --scheduler tcp://scheduler:8786 -- --set render.level=2

Each task builds a chunk of garments by one run of usdtailor. A task whose worker is lost runs again on another, and leaves
what was built already; a run that is started again does so too. What follows -- goes to `usdtailor build`. Workers have to
see the files under the same paths. Exits with 1 if a garment failed.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from dask.distributed import Client, LocalCluster, as_completed

# Runs of a task whose worker was lost, or whose run of the program did not end as it should.
RETRIES = 3


def build(program, garments, out, options):
    """Builds a chunk of garments; a dictionary with "input", "status" and perhaps "error" for each."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        run = [program, "build", *garments, "-o", out, "--skip-fresh", "--force", "--quiet", "--report", str(report)]
        done = subprocess.run([*run, *options], capture_output=True, text=True)
        # A report is written however many garments fail. Without one the options are wrong, or the program was ended.
        if not report.exists():
            raise RuntimeError(f"usdtailor ended with {done.returncode}: {done.stderr.strip()}")
        whole = json.loads(report.read_text())
    results = whole.get("builds", [whole])
    return [{key: result[key] for key in ("input", "status", "error") if key in result} for result in results]


def chunks(garments, size):
    return [garments[start : start + size] for start in range(0, len(garments), size)]


def run_on(client, options):
    """Builds all garments; yields the results of each chunk as it ends."""
    garments = [str(Path(garment).resolve()) for garment in options.garments]
    out = str(Path(options.output).resolve())
    tasks = {}
    for chunk in chunks(garments, options.chunk):
        future = client.submit(build, options.program, chunk, out, options.options, retries=RETRIES, pure=False)
        tasks[future] = chunk
    for future in as_completed(tasks):
        if future.status == "finished":
            yield future.result()
        else:
            message = str(future.exception())
            yield [{"input": garment, "status": "failed", "error": {"message": message}} for garment in tasks[future]]


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("garments", nargs="+")
    parser.add_argument("-o", "--output", required=True, help="folder of the built garments")
    parser.add_argument("--scheduler", help="address of a Dask scheduler [default: workers on this machine]")
    parser.add_argument("--workers", type=int, help="workers on this machine [default: one for each core]")
    parser.add_argument("--chunk", type=int, default=20, help="garments a task [default: 20]")
    parser.add_argument("--program", default="usdtailor", help="the command [default: usdtailor]")
    parser.add_argument("--summary", help="JSON file with the result of each garment")
    own, options = (arguments, [])
    if "--" in arguments:
        at = arguments.index("--")
        own, options = arguments[:at], arguments[at + 1 :]
    parsed = parser.parse_args(own)
    parsed.options = options
    return parsed


def main(arguments):
    options = parsed(arguments)
    Path(options.output).mkdir(parents=True, exist_ok=True)
    local = None
    if options.scheduler is None:
        local = LocalCluster(n_workers=options.workers, threads_per_worker=1, dashboard_address=None)
    results = []
    try:
        with Client(options.scheduler or local) as client:
            for chunk in run_on(client, options):
                results += chunk
                print(f"{len(results)} of {len(options.garments)}", file=sys.stderr, flush=True)
    finally:
        if local is not None:
            local.close()
    results.sort(key=lambda result: result["input"])
    count = {status: sum(r["status"] == status for r in results) for status in ("built", "fresh", "failed")}
    for result in results:
        if result["status"] == "failed":
            print(f"{result['input']}: {result['error']['message']}", file=sys.stderr)
    print(", ".join(f"{number} {status}" for status, number in count.items()))
    if options.summary:
        Path(options.summary).write_text(json.dumps(results, indent=2) + "\n")
    return 1 if count["failed"] else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

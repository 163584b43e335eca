"""Garments on a farm: an Open Job Description template, and Dask on this machine with a worker that is lost."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import yaml
from conftest import EXAMPLES
from test_batch import garments

FARM = EXAMPLES / "batch"
TEMPLATE = FARM / "tailor.openjd.yaml"


def openjd(*arguments):
    command = [str(Path(sys.executable).with_name("openjd")), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=600)


def test_the_template_is_valid():
    checked = openjd("check", TEMPLATE)
    assert checked.returncode == 0, checked.stdout + checked.stderr


@pytest.mark.parametrize(("count", "tasks"), [(3, 7), (7, 3), (0, 2)])
def test_tasks_count_the_lines_and_share_them(tmp_path, count, tasks):
    """A program in place of usdtailor tells what it is given."""
    program = tmp_path / "told"
    program.write_text('#!/bin/sh\nwhile [ "$1" != -- ]; do shift; done; shift\nprintf "%s\\n" "$@" >> told.txt\n'.replace("told.txt", str(tmp_path / "told.txt")))
    program.chmod(0o755)
    names = [f"a garment {number}.usda" for number in range(count)]
    # The last line has no end.
    (tmp_path / "list.txt").write_text("\n".join(names))
    parameters = {"Garments": tmp_path / "list.txt", "Tasks": tasks, "Out": tmp_path, "Program": program}
    done = openjd("run", TEMPLATE, "--step", "Build", *(part for name, value in parameters.items() for part in ("-p", f"{name}={value}")))
    assert done.returncode == 0, done.stdout + done.stderr
    told = (tmp_path / "told.txt").read_text().splitlines() if count else []
    assert sorted(told) == names


def test_the_template_needs_a_worker_that_can_run_it():
    (step,) = yaml.safe_load(TEMPLATE.read_text())["steps"]
    needs = step["hostRequirements"]
    assert {amount["name"]: amount["min"] for amount in needs["amounts"]} == {"amount.worker.vcpu": 2, "amount.worker.memory": 4096}
    assert {"name": "attr.worker.os.family", "anyOf": ["linux"]} in needs["attributes"]


def test_the_template_builds_every_garment_and_tells_of_bad_ones(usdtailor, tmp_path):
    files = garments(tmp_path, 45, bad=(30,))
    (tmp_path / "garments.txt").write_text("".join(f"{file}\n" for file in files))
    out = tmp_path / "out"
    out.mkdir()
    parameters = {"Garments": tmp_path / "garments.txt", "Tasks": 4, "Out": out, "Program": usdtailor}
    given = [part for name, value in parameters.items() for part in ("-p", f"{name}={value}")]
    done = openjd("run", TEMPLATE, "--step", "Build", *given)
    assert done.returncode != 0, "a bad garment fails its task"
    first = builds(out)
    assert [name for name, status in first if status == "failed"] == [str(files[30])]
    files[30].write_text(files[29].read_text())
    again = openjd("run", TEMPLATE, "--step", "Build", *given)
    assert again.returncode == 0, again.stdout + again.stderr
    statuses = builds(out)
    assert sorted(name for name, _ in statuses) == sorted(map(str, files))
    assert (str(files[30]), "built") in statuses
    # What the first run had built stays.
    built = {name for name, status in first if status == "built"}
    assert {name for name, status in statuses if status == "fresh"} == built and len(built) >= 29


def test_paths_and_lines_of_the_list_are_no_code(usdtailor, tmp_path):
    folder = tmp_path / "it's $(touch ran) ;`touch ran`"
    folder.mkdir()
    files = garments(folder, 2)
    (folder / "garments.txt").write_text(f"{files[0]}\n--help\n{files[1]}\n")
    out = folder / "out"
    out.mkdir()
    options = "--set render.level=1 ; touch ran $(touch ran)"
    parameters = {"Garments": folder / "garments.txt", "Tasks": 1, "Out": out, "Program": usdtailor}

    def run(**more):
        given = [part for name, value in {**parameters, **more}.items() for part in ("-p", f"{name}={value}")]
        return openjd("run", TEMPLATE, "--step", "Build", *given)

    # A line that looks like an option is a file that is not there.
    assert run().returncode != 0
    assert builds(out) == [(str(files[0]), "built"), ("--help", "failed"), (str(files[1]), "built")]
    assert run(Options=options).returncode != 0
    assert not list(tmp_path.rglob("ran")) and not Path("ran").exists()


def builds(out):
    """Inputs and statuses in the reports of all chunks, each of which has 20 garments at most."""
    reports = [json.loads(report.read_text())["builds"] for report in out.glob("report-*.json")]
    assert all(len(report) <= 20 for report in reports)
    return [(build["input"], build["status"]) for report in reports for build in report]


@pytest.fixture
def slow(usdtailor, tmp_path):
    """The program, slowed down, so that a worker can be ended while it runs."""
    script = tmp_path / "slow"
    script.write_text(f'#!/bin/sh\nsleep 1\nexec "{usdtailor}" "$@"\n')
    script.chmod(0o755)
    return script


def test_dask_survives_a_lost_worker(slow, tmp_path):
    files = garments(tmp_path, 40, bad=(5,))
    out, summary = tmp_path / "out", tmp_path / "summary.json"
    command = [sys.executable, str(FARM / "dask_batch.py"), *map(str, files), "-o", str(out), "--workers", "2"]
    command += ["--chunk", "4", "--program", str(slow), "--summary", str(summary), "--", "--set", "render.level=0"]
    farm = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    lost = threading.Event()

    def end_a_worker():
        while farm.poll() is None and not lost.is_set():
            runs = [Path(f"/proc/{pid}") for pid in children(farm.pid)]
            workers = [run for run in runs if b"spawn_main" in cmdline(run) and children(int(run.name))]
            if len(list(out.glob("*.usdc"))) >= 8 and workers:
                os.kill(int(workers[0].name), signal.SIGKILL)
                lost.set()
            time.sleep(0.05)

    watcher = threading.Thread(target=end_a_worker)
    watcher.start()
    stdout, stderr = farm.communicate(timeout=300)
    watcher.join()
    assert lost.is_set(), "no worker was ended"
    assert farm.returncode == 1, stderr
    results = {result["input"]: result for result in json.loads(summary.read_text())}
    assert set(results) == set(map(str, files))
    assert [name for name, result in results.items() if result["status"] == "failed"] == [str(files[5])]
    assert "points" in results[str(files[5])]["error"]["message"]
    assert len(list(out.glob("*.usdc"))) == 39
    assert "1 failed" in stdout


def children(process):
    """Process numbers of the children of a process."""
    found = []
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            try:
                parent = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
            except (OSError, ValueError):
                continue
            if parent == process:
                found.append(int(folder.name))
    return found


def cmdline(folder):
    try:
        return (folder / "cmdline").read_bytes()
    except OSError:
        return b""

"""Many jobs: shards, killed workers, and the same bytes as one run; UM-Bridge; ArviZ."""

from __future__ import annotations

import multiprocessing
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import CANTILEVER

import retune
from retune import batch


def jobs_of(n: int) -> list[batch.Job]:
    """Synthetic tests of cantilevers, each with other noise."""
    model = retune.Model(CANTILEVER)
    jobs = []
    for seed in range(n):
        made = retune.twin(model, modes=3, noise_frequency="0.2 %", noise_shape="1 %", seed=seed)
        assert made.test is not None
        options: dict[str, Any] = {"effects": ["point-mass"], "faults": False, "seed": seed}
        jobs.append(batch.Job("diagnose", model, [made.test], options))
    return jobs


def test_shards_are_all_jobs_each_once() -> None:
    numbers: list[Any] = list(range(10))
    parts = [batch.shard(numbers, i, 4) for i in range(1, 5)]
    assert sorted(sum(parts, [])) == numbers
    with pytest.raises(ValueError, match="0/4"):
        batch.shard(numbers, 0, 4)


def test_four_shards_are_one_run_to_the_byte(tmp_path: Path) -> None:
    jobs = jobs_of(8)
    for job in jobs:
        batch.run(job, tmp_path / "one")
    for index in (3, 1, 4, 2):
        for job in batch.shard(jobs, index, 4):
            batch.run(job, tmp_path / "four")
    assert batch.merged(jobs, tmp_path / "four") == batch.merged(jobs, tmp_path / "one")
    assert len(batch.merge(jobs, tmp_path / "one")) == 8


def test_what_is_finished_is_not_done_again(tmp_path: Path) -> None:
    job = jobs_of(1)[0]
    key = batch.run(job, tmp_path)
    file = tmp_path / f"{key}.json"
    before = file.stat().st_mtime_ns
    assert batch.run(job, tmp_path) == key and file.stat().st_mtime_ns == before
    assert batch.pending([job], tmp_path) == []
    other = batch.Job(job.verb, job.model, job.tests, {**job.options, "seed": 99})
    assert other.key != key and batch.pending([job, other], tmp_path) == [other]
    with pytest.raises(retune.RetuneError, match="1 of 2 jobs"):
        batch.merged([job, other], tmp_path)


def test_a_call_without_a_result_is_a_result(tmp_path: Path) -> None:
    job = jobs_of(1)[0]
    wrong = batch.Job("diagnose", job.model, job.tests, {"effects": ["no-such-effect"]})
    batch.run(wrong, tmp_path)
    [found] = batch.merge([wrong], tmp_path)
    assert found["result"] is None and "no-such-effect" in found["error"]


def _all(jobs: list[batch.Job], folder: Path) -> None:
    for job in jobs:
        batch.run(job, folder)


def test_a_killed_process_leaves_nothing_behind_but_whole_results(tmp_path: Path) -> None:
    jobs = jobs_of(12)
    process = multiprocessing.get_context("spawn").Process(target=_all, args=(jobs, tmp_path / "killed"))
    process.start()
    deadline = time.monotonic() + 60
    while not list((tmp_path / "killed").glob("*.json")) and time.monotonic() < deadline:
        time.sleep(0.01)
    process.kill()
    process.join()
    left = batch.pending(jobs, tmp_path / "killed")
    assert 0 < len(left) < 12
    _all(left, tmp_path / "killed")
    _all(jobs, tmp_path / "one")
    assert batch.merged(jobs, tmp_path / "killed") == batch.merged(jobs, tmp_path / "one")


def test_the_shell_of_a_batch(tmp_path: Path) -> None:
    jobs = jobs_of(3)
    retune.Model(CANTILEVER).save(tmp_path / "model.yaml")
    tests = []
    for k, job in enumerate(jobs):
        job.tests[0].save(tmp_path / f"t{k}.yaml")
        tests.append(f"t{k}.yaml")

    def shell(*words: str) -> subprocess.CompletedProcess[bytes]:
        line = [sys.executable, "-m", "retune.batch", "update", "model.yaml", *tests, "--folder", "results", *words]
        return subprocess.run(line, cwd=tmp_path, capture_output=True, check=False)

    assert shell("--shard", "2/2").returncode == 0
    early = shell("--merge")
    assert early.returncode == 2 and b"2 of 3 jobs have no result" in early.stderr
    assert shell("--shard", "1/2").returncode == 0
    done = shell("--merge")
    assert done.returncode == 0 and done.stdout.count(b"\n") == 3
    assert shell("--shard", "3/2").returncode == 2


@pytest.mark.filterwarnings("ignore")
def test_dask_with_a_killed_worker(tmp_path: Path) -> None:
    """Two workers, one of them killed in the middle: its jobs are done again, and the bytes are those of one run."""
    distributed = pytest.importorskip("distributed", reason="skipped: `distributed` is not here")
    jobs = jobs_of(24)
    folder = tmp_path / "dask"
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        futures = client.map(batch.run, jobs, folder=str(folder), key=[job.key for job in jobs], retries=3)
        while not list(folder.glob("*.json")):
            time.sleep(0.01)
        victim = next(iter(client.run(os.getpid).values()))
        os.kill(victim, signal.SIGKILL)
        assert sorted(client.gather(futures)) == sorted(job.key for job in jobs)
    for job in jobs:
        batch.run(job, tmp_path / "one")
    assert batch.merged(jobs, folder) == batch.merged(jobs, tmp_path / "one")


SERVER = """
import sys
import retune, retune.server
retune.server.serve(retune.Model.from_file(sys.argv[1]), retune.Test.from_file(sys.argv[2]), int(sys.argv[3]), modes=3)
"""


@pytest.mark.filterwarnings("ignore")
def test_um_bridge(tmp_path: Path, cantilever: retune.Model, twin: retune.Test) -> None:
    umbridge = pytest.importorskip("umbridge", reason="skipped: `umbridge` is not here")
    cantilever.save(tmp_path / "model.yaml")
    twin.save(tmp_path / "test.yaml")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    files = [str(tmp_path / "model.yaml"), str(tmp_path / "test.yaml")]
    with subprocess.Popen([sys.executable, "-c", SERVER, *files, str(port)], stdout=subprocess.DEVNULL) as server:
        try:
            url = f"http://127.0.0.1:{port}"
            deadline = time.monotonic() + 60
            while True:
                try:
                    names = umbridge.supported_models(url)
                    break
                except Exception:
                    assert server.poll() is None and time.monotonic() < deadline, "the server does not answer"
                    time.sleep(0.1)
            assert names == ["posterior", "residuals", "frequencies"]
            objective = retune.Objective(cantilever, twin)
            x = [0.4]
            residuals = umbridge.HTTPModel(url, "residuals")
            assert residuals.get_input_sizes() == [1] and residuals.get_output_sizes() == [objective.n_residuals]
            r, jacobian = objective.linearize(x)
            assert residuals([x])[0] == pytest.approx(r, rel=1e-12)
            assert residuals.apply_jacobian(0, 0, [x], [2.0]) == pytest.approx(2.0 * jacobian[:, 0], rel=1e-12)
            posterior = umbridge.HTTPModel(url, "posterior")
            assert posterior([x])[0][0] == pytest.approx(-objective.cost(x), rel=1e-12)
            assert posterior.gradient(0, 0, [x], [1.0]) == pytest.approx(-objective.gradient(x), rel=1e-12)
            frequencies = umbridge.HTTPModel(url, "frequencies")
            assert frequencies([x])[0] == pytest.approx(cantilever.modes(objective.theta(x), n=3).frequencies, rel=1e-12)
            assert not frequencies.supports_gradient()
        finally:
            server.kill()


@pytest.mark.filterwarnings("ignore")
def test_chains_for_arviz(tmp_path: Path, cantilever: retune.Model, twin: retune.Test) -> None:
    arviz = pytest.importorskip("arviz", reason="skipped: `arviz` is not here")
    runs = [retune.sample(cantilever, twin, samples=200, seed=seed) for seed in range(3)]
    data = runs[0].to_arviz(*runs[1:])
    assert data.posterior["E"].shape == (3, 200)
    assert float(data.posterior["E"].mean()) == pytest.approx(np.mean([r["E"].mean() for r in runs]))
    # Chains that have found the same posterior.
    assert float(arviz.rhat(data)["E"]) < 1.1
    pytest.importorskip("netCDF4", reason="skipped: `netCDF4` is not here")
    data.to_netcdf(str(tmp_path / "posterior.nc"))
    assert np.array_equal(arviz.from_netcdf(str(tmp_path / "posterior.nc")).posterior["E"], data.posterior["E"])

"""Many jobs: shards, killed workers, and the same bytes as one run; UM-Bridge; ArviZ."""

from __future__ import annotations

import concurrent.futures
import json
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


# As many as the promise says where time does not matter.
MANY, FEW = (200, 200) if os.environ.get("RETUNE_SLOW") else (24, 8)


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
    jobs = jobs_of(FEW)
    for job in jobs:
        batch.run(job, tmp_path / "one")
    for index in (3, 1, 4, 2):
        for job in batch.shard(jobs, index, 4):
            batch.run(job, tmp_path / "four")
    assert batch.merged(jobs, tmp_path / "four") == batch.merged(jobs, tmp_path / "one")
    assert len(batch.merge(jobs, tmp_path / "one")) == FEW


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


def test_a_bootstrap_is_a_batch(tmp_path: Path, cantilever: retune.Model, twin: retune.Test) -> None:
    """Twins of the fitted model with the noise of the test, each fitted anew in one of three shards: they scatter as the fit says it is certain."""
    fitted = retune.update(cantilever, twin)
    noise = {"noise_frequency": "0.2 %", "noise_shape": "1 %"}
    many = [retune.twin(fitted.model, modes=4, sensors=twin, seed=100 + k, **noise).test for k in range(60)]
    jobs = [batch.Job("update", cantilever, [test]) for test in many if test is not None]
    for index in (2, 3, 1):
        for job in batch.shard(jobs, index, 3):
            batch.run(job, tmp_path)
    values = []
    for found in batch.merge(jobs, tmp_path):
        [young] = [p for p in found["result"]["parameters"] if p["name"] == "E"]
        values.append(young["after"])
    sd = fitted["E"].sd
    assert sd is not None
    # Of 60 draws a standard deviation is known to 1/√120: four times that.
    assert abs(np.std(values, ddof=1) / sd - 1) < 4 / np.sqrt(120)
    assert abs(np.mean(values) - fitted["E"].after) < 4 * sd / np.sqrt(60)


def command(folder: Path, *words: str) -> subprocess.CompletedProcess[bytes]:
    line = [sys.executable, "-m", "retune", *words]
    return subprocess.run(line, cwd=folder, capture_output=True, check=False, env={**os.environ, "NO_COLOR": "1"})


def batch_of(n: int, folder: Path) -> list[str]:
    """The words of a batch of the command: a model and its synthetic tests as files."""
    retune.Model(CANTILEVER).save(folder / "model.yaml")
    names = []
    for k, job in enumerate(jobs_of(n)):
        text = job.tests[0].to_yaml().replace("name: ", f"name: {k:03d} ", 1)
        (folder / f"t{k:03d}.yaml").write_text(text, encoding="utf-8")
        names.append(f"t{k:03d}.yaml")
    return ["batch", "diagnose", "model.yaml", *names]


OPTIONS = ["--", "--effects", "point-mass", "--no-faults", "--seed", "3"]


def test_four_shards_of_the_command_are_one_run_to_the_byte(tmp_path: Path) -> None:
    batch = batch_of(FEW, tmp_path)
    whole = command(tmp_path, *batch, "--folder", "one", *OPTIONS)
    assert whole.returncode == 0 and whole.stdout.count(b"\n") == FEW, whole.stderr
    for shard in ("3/4", "1/4", "4/4", "2/4"):
        done = command(tmp_path, *batch, "--folder", "four", "--shard", shard, *OPTIONS)
        assert (done.returncode, done.stdout) == (0, b""), done.stderr
    files = sorted(str(p) for p in (tmp_path / "four").glob("*.json"))
    assert command(tmp_path, "merge", *reversed(files)).stdout == whole.stdout
    assert sorted(p.name for p in (tmp_path / "one").iterdir()) == sorted(p.name for p in (tmp_path / "four").iterdir())
    # What the verb answers alone is what stands in the line.
    first = json.loads(whole.stdout.splitlines()[0])
    alone = command(tmp_path, "diagnose", "model.yaml", "t000.yaml", *OPTIONS[1:], "--json")
    assert first["result"] == json.loads(alone.stdout) and first["error"] is None


def test_a_batch_does_what_is_missing_alone(tmp_path: Path) -> None:
    batch = batch_of(3, tmp_path)
    assert command(tmp_path, *batch, "--folder", "r", "--shard", "2/3", *OPTIONS).returncode == 0
    [there] = (tmp_path / "r").glob("*.json")
    before = there.stat().st_mtime_ns
    whole = command(tmp_path, *batch, "--folder", "r", *OPTIONS)
    assert whole.returncode == 0 and whole.stdout.count(b"\n") == 3 and there.stat().st_mtime_ns == before
    # Another seed, another file that the model names, another test: other jobs.
    assert command(tmp_path, *batch, "--folder", "r", *OPTIONS[:-1], "4").returncode == 0
    assert len(list((tmp_path / "r").glob("*.json"))) == 6
    # One that was cut short is done again.
    text = there.read_bytes()
    there.write_bytes(text[: len(text) // 2])
    assert command(tmp_path, *batch, "--folder", "r", *OPTIONS).stdout == whole.stdout and there.read_bytes() == text


def test_a_job_without_a_result_says_why(tmp_path: Path) -> None:
    batch = batch_of(2, tmp_path)
    (tmp_path / "t001.yaml").write_text("retune_test: 1\nname: wrong\nmodes: [{frequenzy: 3 Hz}]\n")
    done = command(tmp_path, *batch, "--folder", "r", *OPTIONS)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == 1 and b"1 job without a result" in done.stderr
    wrong = [line for line in lines if line["error"] is not None]
    assert len(lines) == 2 and len(wrong) == 1 and "frequenzy" in wrong[0]["error"] and wrong[0]["result"] is None
    for words in (["--folder", "r", "--", "-o", "x.json"], ["--folder", "r", "--shard", "3/2"], ["--folder", "r", "--", "--json"]):
        assert command(tmp_path, *batch, *words).returncode == 2
    assert command(tmp_path, "merge", "model.yaml").returncode == 2


def test_hyperqueue(tmp_path: Path) -> None:
    """Four shards as tasks of a server and a worker of HyperQueue, which are those of its wheel."""
    hyperqueue = pytest.importorskip("hyperqueue", reason="skipped: `hyperqueue` is not here")
    from hyperqueue.cluster import WorkerConfig

    batch = batch_of(8, tmp_path)
    with hyperqueue.LocalCluster(server_dir=str(tmp_path / "server"), worker_config=WorkerConfig(cores=2)) as cluster:
        client = cluster.client()
        job = hyperqueue.Job()
        for k in range(1, 5):
            words = [sys.executable, "-m", "retune", *batch, "--folder", "queue", "--shard", f"{k}/4", *OPTIONS]
            job.program(words, cwd=str(tmp_path))
        assert client.wait_for_jobs([client.submit(job)])
    files = [str(p) for p in (tmp_path / "queue").glob("*.json")]
    assert command(tmp_path, "merge", *files).stdout == command(tmp_path, *batch, "--folder", "one", *OPTIONS).stdout


def _sampled(model: retune.Model, test: retune.Test, shard: str, folder: Path) -> Any:
    return retune.sample(model, test, samples=100, seed=2, shard=shard, folder=folder).to_dict()


def test_shards_of_a_sample_have_what_one_run_has(tmp_path: Path, cantilever: retune.Model, twin: retune.Test) -> None:
    """Three processes share every generation, and each ends with the samples of one run."""
    whole = retune.sample(cantilever, twin, samples=100, seed=2).to_dict()
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(3, mp_context=context) as pool:
        parts = [pool.submit(_sampled, cantilever, twin, f"{k}/3", tmp_path / "shared") for k in (2, 3, 1)]
        assert all(part.result(timeout=300) == whole for part in parts)
    # All of it is there: another process evaluates next to nothing.
    begun = time.perf_counter()
    assert _sampled(cantilever, twin, "1/3", tmp_path / "shared") == whole
    assert time.perf_counter() - begun < 30.0
    cantilever.save(tmp_path / "model.yaml")
    twin.save(tmp_path / "test.yaml")
    words = ["sample", "model.yaml", "test.yaml", "--samples", "100", "--seed", "2", "--json"]
    alone = command(tmp_path, *words)
    assert command(tmp_path, *words, "--shard", "1/1", "--folder", "shared").stdout == alone.stdout
    assert command(tmp_path, *words, "--shard", "1/3").returncode == 2
    with pytest.raises(ValueError, match="belong together"):
        retune.sample(cantilever, twin, shard="1/3")
    with pytest.raises(retune.RetuneError, match="shard 4/3"):
        retune.sample(cantilever, twin, shard="4/3", folder=tmp_path / "shared")


@pytest.mark.filterwarnings("ignore")
def test_dask_with_a_killed_worker(tmp_path: Path) -> None:
    """Two workers, one of them killed in the middle: its jobs are done again, and the bytes are those of one run."""
    distributed = pytest.importorskip("distributed", reason="skipped: `distributed` is not here")
    jobs = jobs_of(MANY)
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

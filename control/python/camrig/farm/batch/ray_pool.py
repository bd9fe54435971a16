"""Draws shards on the machines of a Ray cluster, a task a shard. Frames go from the machine that draws them to the set's folder, which all machines
see; through Ray go the job and what the manifest says."""

from __future__ import annotations

import os
from typing import Any

from ...errors import CamrigError
from .pools import Answer, run_drawer


class RayPool:
    """`address` as ray.init takes it ("auto", "HOST:PORT"); a shard takes `cpus` cores of a machine."""

    def __init__(self, address: str, cpus: float) -> None:
        try:
            import ray
        except ImportError:
            raise CamrigError("unavailable", "--ray needs Ray: pip install 'camrig[farm]'; without it: --workers N") from None
        self._ray, self._cpus = ray, cpus
        # Else it warns of what a later Ray does with tasks that ask for no GPU.
        os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
        try:
            ray.init(address=address, log_to_driver=False, logging_level="error")
        except (ConnectionError, RuntimeError, ValueError) as problem:
            raise CamrigError("unavailable", f"--ray {address}: {problem}") from None
        machines = [node["Resources"].get("CPU", 0) for node in ray.nodes() if node["Alive"]]
        if max(machines, default=0) < cpus:
            ray.shutdown()
            raise CamrigError("resource_exhausted", f"--cpus {cpus:g}: the largest of {len(machines)} machines at {address} has {max(machines, default=0):g}")
        # A task that died is given out again by us, who count how often; Ray would not say so.
        self._task = ray.remote(num_cpus=cpus, max_retries=0, scheduling_strategy="SPREAD")(run_drawer)
        self._jobs: dict[Any, str] = {}

    @property
    def slots(self) -> int:
        return max(1, int(self._ray.cluster_resources().get("CPU", 0) // self._cpus))

    def submit(self, name: str, job: dict[str, Any]) -> None:
        self._jobs[self._task.remote(job)] = name

    def finished(self, timeout_s: float) -> list[tuple[str, Answer]]:
        if not self._jobs:
            return []
        done, _ = self._ray.wait(list(self._jobs), num_returns=len(self._jobs), timeout=0)
        if not done:
            done, _ = self._ray.wait(list(self._jobs), num_returns=1, timeout=timeout_s)
        return [(self._jobs.pop(one), self._answer(one)) for one in done]

    def _answer(self, reference: Any) -> Answer:
        try:
            return self._ray.get(reference)
        except self._ray.exceptions.RayTaskError as problem:
            return {"error": {"kind": "shard", "text": str(problem).strip().splitlines()[-1]}}
        except self._ray.exceptions.RayError as problem:  # the worker, or its machine, is gone
            return {"error": {"kind": "lost", "text": f"{type(problem).__name__}: {str(problem).strip().splitlines()[0]}"}}

    def close(self) -> None:
        for reference in self._jobs:
            self._ray.cancel(reference, force=True)
        self._ray.shutdown()

"""Brings a plan to every worker of a Dask cluster."""

from distributed import Worker, WorkerPlugin

from it2hys.sweeps import worker as sweep_worker
from it2hys.sweeps.plan import Plan


class PlanPlugin(WorkerPlugin):
    """Installs a plan where a worker starts."""

    name = "it2hys-sweep"

    def __init__(self, plan: Plan) -> None:
        self._plan = plan

    def setup(self, worker: Worker) -> None:
        """Install the plan in the worker's process."""
        sweep_worker.install(self._plan)

"""A toy sampler: Metropolis-Hastings whose proposals do not depend on where the chain is."""

import numpy as np
from scipy import stats

from retrodict.inference.samplers import Draws, Task


def draw(task: Task) -> Draws:
    """Propose from a Student-t in the whitened coordinates; accept by the ratio of the weights."""
    rng, n = np.random.default_rng(task.seed), task.posterior.size
    law = stats.multivariate_t(np.zeros(n), 1.3 * np.eye(n), df=6)
    w = law.rvs((task.chains, task.draws), random_state=rng)
    log_weight = task.posterior.evaluate(w.reshape(-1, n))[0].reshape(w.shape[:2]) - law.logpdf(w)
    level = np.log(rng.uniform(size=w.shape[:2]))
    chains, at = np.arange(task.chains), np.zeros(task.chains, int)
    kept = np.empty_like(w)
    for i in range(task.draws):
        accepted = level[:, i] < log_weight[:, i] - log_weight[chains, at]
        at = np.where(accepted, i, at)
        kept[:, i] = w[chains, at]
    return Draws(kept, {})

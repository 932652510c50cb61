"""The cheapest way to give every row a column of its own.

As `scipy.optimize.linear_sum_assignment`, which is its oracle in the tests: that package alone is 50 MB in the memory
of a rig, for a matrix of ten rows.
"""

import numpy as np

from controller.arrays import Array, Words


def assigned(cost: Array) -> Words:
    """Column of each row (n,) so that the sum of `cost` (n,m), n <= m, finite, is least.

    Shortest augmenting paths (Jonker and Volgenant, 1987), row by row: O(n^2 m).
    """
    n, m = cost.shape
    nearest: Words = cost.argmin(axis=1)
    if len(set(nearest.tolist())) == n:
        return nearest  # as a rule: nothing is cheaper than each row's cheapest
    u, v = np.zeros(n), np.zeros(m)
    row_of, before = np.full(m, -1), np.zeros(m, np.int64)
    for row in range(n):
        column = _augment(cost, row, u, v, row_of, before)
        while True:  # turn the path round
            previous = before[column]
            row_of[column] = row if previous < 0 else row_of[previous]
            if previous < 0:
                break
            column = previous
    found = np.zeros(n, np.int64)
    taken = row_of >= 0
    found[row_of[taken]] = np.flatnonzero(taken)
    return found


def _augment(cost: Array, row: int, u: Array, v: Array, row_of: Words, before: Words) -> int:
    """A free column at the end of the shortest path from `row`. In place: potentials u, v; `before`, the path."""
    shortest, visited = np.full(len(v), np.inf), np.zeros(len(v), bool)
    column, at, gone = -1, row, [row]
    while True:
        reduced = cost[at] - u[at] - v
        better = ~visited & (reduced < shortest)
        shortest[better], before[better] = reduced[better], column
        column = int(np.argmin(np.where(visited, np.inf, shortest)))
        step = shortest[column]
        u[gone] += step
        v[visited] -= step
        shortest[~visited] -= step
        visited[column] = True
        if row_of[column] < 0:
            return column
        at = int(row_of[column])
        gone.append(at)

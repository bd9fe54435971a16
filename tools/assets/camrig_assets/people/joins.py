"""Rounds the joins of a body's parts: where an arm meets the trunk or a leg the pelvis, normals are bent and the
surface swells, so that the light passes over the join without an edge.
"""

import numpy as np


def blend_joins(parts, pairs, scale):
    """Rounds the joins: for each pair of names, normals lean and the surface swells where the other part is near."""
    by_name = {part.name: part for part in parts}
    for first, second, radius in pairs:
        if first not in by_name or second not in by_name:
            continue
        moves = []
        for part, other in ((by_name[first], by_name[second]), (by_name[second], by_name[first])):
            points, cloud, cloud_normals = (
                part.grid.reshape(-1, 3),
                other.grid.reshape(-1, 3),
                other.normals.reshape(-1, 3),
            )
            cloud, cloud_normals = _denser(other)
            nearest = np.concatenate(
                [((block[:, None] - cloud[None]) ** 2).sum(-1).argmin(1) for block in np.array_split(points, 8)]
            )
            away = ((points - cloud[nearest]) * cloud_normals[nearest]).sum(axis=1)  # > 0 outside the other part
            near = np.exp(-np.maximum(away, 0) / (radius * scale)) * (
                np.linalg.norm(points - cloud[nearest], axis=1) < 3.5 * radius * scale
            )
            moves.append((part, near[:, None], cloud_normals[nearest]))
        for part, near, other_normals in moves:
            normals = part.normals.reshape(-1, 3) + near * other_normals
            length = np.linalg.norm(normals, axis=1, keepdims=True)
            normals = np.where(length > 0.3, normals / np.maximum(length, 1e-9), part.normals.reshape(-1, 3))
            part.grid = (part.grid.reshape(-1, 3) + normals * near * 0.16 * radius * scale).reshape(part.grid.shape)
            part.normals = normals.reshape(part.normals.shape)


def _denser(part):
    """Points and normals of a part's surface at twice its grid's density."""

    def refine(values):
        values = np.stack([values[:-1], (values[:-1] + values[1:]) / 2], 1).reshape(-1, *values.shape[1:])
        values = np.swapaxes(values, 0, 1)
        values = np.stack([values[:-1], (values[:-1] + values[1:]) / 2], 1).reshape(-1, *values.shape[1:])
        return values.reshape(-1, 3)

    normals = refine(part.normals)
    return refine(part.grid), normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)

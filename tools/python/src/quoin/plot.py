"""Pictures on matplotlib axes of the caller; lengths in m."""
import numpy as np

from . import _quoin


def _solids(shown):
    """(corners, faces) of each solid of a Simulation, of a Body, a Shape or a list of these."""
    if isinstance(shown, _quoin.Simulation):
        return [(shown.vertices(b), shown.shape(b).faces) for b in range(len(shown.blocks))]
    if isinstance(shown, (_quoin.Body, _quoin.Shape)):
        shown = [shown]
    return [(one.vertices, (one.shape if isinstance(one, _quoin.Body) else one).faces) for one in shown]


def blocks(axes, shown, values=None, *, plane="xz", **style):
    """Blocks of a Simulation, or bodies; returns the collection.

    axes: with projection="3d", or plain: then blocks are seen along the normal of `plane`, nearer ones in front.
    values: a number each, for the colour map; style: as of matplotlib's collections.
    """
    solids = _solids(shown)
    numbers = np.repeat(np.arange(len(solids)), [len(faces) for _, faces in solids])
    polygons = [corners[face] for corners, faces in solids for face in faces]
    style = {"edgecolor": "black", "linewidth": 0.5, **style}
    if values is None:
        style = {"facecolor": "#c9b28f", **style}
    else:
        style["array"] = np.asarray(values, dtype=float)[numbers]
    if hasattr(axes, "add_collection3d"):
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection
        collection = Poly3DCollection(polygons, **style)
        axes.add_collection3d(collection)
        box = np.array([[corners.min(axis=0), corners.max(axis=0)] for corners, _ in solids])
        low, high = box[:, 0].min(axis=0), box[:, 1].max(axis=0)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
        axes.set_box_aspect(np.maximum(high - low, 1e-9 * (high - low).max()))
        return collection
    from matplotlib.collections import PolyCollection
    across = ["xyz".index(letter) for letter in plane]
    depth = 3 - sum(across)
    towards = 1.0 if (across[1] - across[0]) % 3 == 1 else -1.0
    order = np.argsort([towards * polygon[:, depth].mean() for polygon in polygons], kind="stable")
    if values is not None:
        style["array"] = style["array"][order]
    collection = PolyCollection([polygons[i][:, across] for i in order], **style)
    axes.add_collection(collection)
    axes.autoscale_view()
    axes.set(xlabel=f"{plane[0]}, m", ylabel=f"{plane[1]}, m", aspect="equal")
    return collection


def force_on_b(contacts):
    """(n, 3), N, of Simulation.contacts or Equilibrium.contacts."""
    if "force" in contacts.dtype.names:
        return contacts["force"]
    return contacts["normal_force"][:, None] * contacts["normal"] - contacts["shear_force"]


def forces(axes, contacts, *, plane="xz", scale=None, **style):
    """Contact forces on b of Simulation.contacts or Equilibrium.contacts, as arrows.

    scale: m per N; None: the longest is a tenth of the picture. Returns the quiver.
    """
    points, force = contacts["point"], force_on_b(contacts)
    across = ["xyz".index(letter) for letter in plane]
    if scale is None:
        longest = np.linalg.norm(force, axis=1).max(initial=0.0)
        scale = 0.1 * np.ptp(points, axis=0).max(initial=0.0) / longest if longest > 0 else 1.0
    style = {"color": "crimson", "width": 0.003, **style}
    shown = force[:, across] * scale
    return axes.quiver(*points[:, across].T, *shown.T, angles="xy", scale_units="xy", scale=1, zorder=3, **style)

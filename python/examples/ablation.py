# %% [markdown]
# # An ablation in a notebook
# Which part of burin makes the difference on this scene? Every setting refines the same mesh; cells
# (`# %%`) run in Jupyter, VS Code or Spyder, or all of them with
#
#     PYTHONPATH=build/release/python python3 python/examples/ablation.py demo/scene demo/scene/init.ply demo/scene/truth.ply

# %%
import sys

import numpy

import burin

scene_path, mesh_path, truth_path = sys.argv[1:4]
scene = burin.load_scene(scene_path)
vertices, faces = burin.read_mesh(mesh_path)
truth, _ = burin.read_mesh(truth_path)

# %% [markdown]
# The settings: one change each.

# %%
settings = {
    "defaults": {},
    "no occlusion masks": {"mask.mode": "none"},
    "no smoothness": {"smooth.type": "none"},
    "first order": {"solver.type": "gradient_descent"},
    "half resolution": {"level.finest": 1},
}


# %% [markdown]
# The score: distance from vertices of the truth to the nearest vertex of the mesh, in units of the
# scene; good for a comparison, `burin evaluate` measures to the surface.

# %%
def distance(points, to):
    nearest = [numpy.min(numpy.linalg.norm(to - point, axis=1)) for point in points]
    return float(numpy.mean(nearest))


sample = truth[:: max(1, len(truth) // 500)]

# %%
rows = []
for name, change in settings.items():
    result = burin.refine(scene, vertices, faces, burin.Options(change))
    rows.append((name, distance(sample, result.vertices), len(result.faces),
                 result.summary["iterations"], result.summary["seconds"]["refine"]))

# %%
print(f"{'before':20s} {distance(sample, vertices):.5f}")
for name, error, face_count, iterations, seconds in rows:
    print(f"{name:20s} {error:.5f}  {face_count} faces, {iterations} iterations, {seconds:.1f} s")

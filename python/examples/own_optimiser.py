"""Your own optimiser on burin's energy: SciPy's L-BFGS against burin's `lbfgs` and `lm_pcg`.

    build/release/apps/burin demo --output demo
    PYTHONPATH=build/release/python python3 python/examples/own_optimiser.py demo/scene demo/scene/init.ply

One round at one pyramid level, visibility frozen: the same function for everybody. Prints energies,
evaluations, and how far the meshes are apart.
"""

import sys

import numpy
import scipy.optimize

import burin


def main(scene_path, mesh_path, level=2, iterations=60):
    scene = burin.load_scene(scene_path)
    vertices, faces = burin.read_mesh(mesh_path)
    options = burin.Options({"solver.max_iterations": iterations, "solver.function_tolerance": 1e-7})
    energy = burin.Energy(scene, vertices, faces, options=options, level=level)
    start, _ = energy(energy.zero())
    print(f"{energy.unknowns} unknowns, {len(energy.pairs)} pairs, level {level}: energy {start:.2f}")

    # burin's lbfgs works in footprints of full-resolution pixels, as x is.
    scipy_result = scipy.optimize.minimize(
        energy,
        energy.zero(),
        jac=True,
        method="L-BFGS-B",
        options={"maxiter": iterations, "maxcor": 20, "ftol": 1e-7, "gtol": 0},
    )
    results = {"scipy L-BFGS-B": (scipy_result.x, scipy_result.fun, scipy_result.nfev)}
    for strategy in ("lbfgs", "lm_pcg"):
        own = energy.solve(strategy)
        results["burin " + strategy] = (own["x"], own["energy"], own["evaluations"])
    reference = results["burin lbfgs"][0]
    for name, (x, value, evaluations) in results.items():
        apart = numpy.sqrt(numpy.mean((x - reference) ** 2)) / 2**level
        print(f"{name:15s} energy {value:10.3f}  {evaluations:4d} evaluations, "
              f"{apart:.4f} px RMS from burin lbfgs")
    return start, results


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])

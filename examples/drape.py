#!/usr/bin/env python3
"""From a garment to a simulated, dressed shot: build, simulate with Newton on a CPU, drive, draw.

    drape.py [coat|tshirt|trousers|IN.usda] -o FOLDER [--frames 60] [--fps 24] [--length CM]
             [--level 2] [--focus x,y,z,radius] [--usdtailor PATH] [--quick]

A frame of the coat takes 5 to 10 seconds on two cores. Needs Python with `newton`, `warp-lang`, `newton-usd-schemas`, `usd-core`, `numpy` and `pillow`:

    python -m venv drape && drape/bin/pip install newton warp-lang newton-usd-schemas usd-core numpy pillow

The folder gets `built.usdc` (simulation mesh with physics, render mesh), `cache.usdc` (points of the simulation mesh),
`shot.usdc` (the driven render mesh) and `strip.png` (a picture of four frames). The garment hangs on a body of capsules, and falls under
gravity from the pose that it was modelled in.
"""
import argparse
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np

EXAMPLES = Path(__file__).resolve().parent
GARMENTS = {"coat": EXAMPLES / "sewn/coat.usda", "tshirt": EXAMPLES / "tshirt.usda",
            "trousers": EXAMPLES / "trousers.usda"}
FABRICS = {"coat": "wool", "tshirt": "jersey", "trousers": "denim"}
PINS = {"trousers": "waist_edge"}           # the trousers have no belt
CONTACT = 0.35                              # distance of cloth from the body [cm]

# A person of 178 cm: capsules from a to b with a radius, left ones are mirrored. [cm, Y up]
BODY = [((0, 148, -2), (0, 166, 1), 6.5), ((-3, 140, -2), (3, 140, -2), 8.0)]
BODY += [((-w, y, z), (w, y, z), r) for y, w, z, r in [
    (92, 7.5, -1, 9.5), (97, 7.5, -1, 9.5), (102, 6.5, -1, 9.0), (107, 5.5, -1, 8.8),
    (112, 5.8, -1, 9.0), (118, 6.5, -1, 9.5), (124, 7.0, -1, 10.0), (130, 7.5, -1.2, 9.5), (135, 8.0, -1.5, 8.0)]]
SIDES = [((4, 143, -2), (16, 140, -1.5), 4.6), ((17, 139, -1.5), (34, 117, -2), 4.4),
         ((34, 117, -2), (46, 94.5, 3), 3.6), ((46, 94.5, 3), (51, 85, 6), 3.2),
         ((8.5, 90, 0), (10.5, 52, 0.5), 8.0), ((10.5, 52, 0.5), (12.5, 12, -2), 5.2)]
BODY += [((s * a[0], *a[1:]), (s * b[0], *b[1:]), r) for a, b, r in SIDES for s in (1, -1)]


def run(*command):
    print("$", " ".join(map(str, command)), flush=True)
    subprocess.run([str(word) for word in command], check=True)


def capsules_below(points):
    """The body's capsules, thinned so that all cloth lies outside of them."""
    fitted = []
    for a, b, radius in BODY:
        a, b = np.array(a, float), np.array(b, float)
        t = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        nearest = np.linalg.norm(points - a - t[:, None] * (b - a), axis=1).min()
        radius = min(radius, nearest - CONTACT - 0.02)
        if radius > 0.5:
            fitted.append((a, b, radius))
    return fitted


def read_sim(stage):
    """The simulation mesh: its prim, points in the stage's space, triangles, and its transform."""
    from pxr import Usd, UsdGeom
    prim = next(p for p in stage.Traverse() if p.GetCustomDataByKey("tailor:product") == "sim")
    matrix = np.array(UsdGeom.XformCache(Usd.TimeCode.Default()).GetLocalToWorldTransform(prim))
    points = np.array(prim.GetAttribute("points").Get(), float)
    triangles = np.array(prim.GetAttribute("faceVertexIndices").Get()).reshape(-1, 3)
    return prim, points @ matrix[:3, :3] + matrix[3, :3], triangles, matrix


def build_model(file, stage):
    """A Newton model of the garment, its body and the springs of its loose pieces."""
    import newton
    import warp as wp
    prim, points, triangles, matrix = read_sim(stage)
    # Lengths of the stage are centimetres, and the PhysicsScene has gravity in them.
    builder = newton.ModelBuilder(up_axis=newton.Axis.Y)
    with warnings.catch_warnings():
        # Newton reads no attachments of cloth to itself (they are springs below), and reports the stage's unit.
        warnings.simplefilter("ignore")
        builder.add_usd(str(file))
    builder.default_shape_cfg.ke, builder.default_shape_cfg.kd = 1e4, 1e-2
    builder.default_shape_cfg.mu = 0.5
    for a, b, radius in capsules_below(points):
        axis = b - a
        turn = wp.quat_between_vectors(wp.vec3(0.0, 0.0, 1.0), wp.vec3(*(axis / np.linalg.norm(axis))))
        builder.add_shape_capsule(-1, xform=wp.transform(wp.vec3(*((a + b) / 2)), turn), radius=radius,
                                  half_height=float(np.linalg.norm(axis)) / 2)
    held, faces = (prim.GetAttribute(f"tailor:attach:{name}").Get() or [] for name in ("points", "faces"))
    for point, face in zip(held, faces):
        for corner in triangles[face]:
            builder.add_spring(int(point), int(corner), 2e3, 1e-1, 0.0)
    builder.particle_radius = [CONTACT] * builder.particle_count
    builder.color(include_bending=True)
    model = builder.finalize()
    model.soft_contact_ke, model.soft_contact_kd, model.soft_contact_mu = 1e4, 1e-2, 0.5
    return model, prim, matrix


def simulate(file, cache, frames, fps, substeps=10, iterations=12):
    """Simulates the garment with VBD and writes the points of the simulation mesh over time."""
    import newton
    from pxr import Usd, UsdGeom, Vt
    source = Usd.Stage.Open(str(file))
    model, prim, matrix = build_model(file, source)
    thickness = CONTACT / 2
    solver = newton.solvers.SolverVBD(
        model, iterations=iterations, particle_enable_self_contact=True,
        particle_self_contact_margin=thickness, particle_self_contact_gap=thickness,
        particle_topological_contact_filter_threshold=3, particle_rest_shape_contact_exclusion_radius=CONTACT)
    states, control = [model.state(), model.state()], model.control()
    pipeline = newton.CollisionPipeline(model)
    contacts = pipeline.contacts()
    stage = Usd.Stage.CreateNew(str(cache))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.GetStageUpAxis(source))
    UsdGeom.SetStageMetersPerUnit(stage, UsdGeom.GetStageMetersPerUnit(source))
    stage.SetTimeCodesPerSecond(fps), stage.SetFramesPerSecond(fps)
    stage.SetStartTimeCode(1), stage.SetEndTimeCode(frames)
    # A layer over the garment: its points are in the space of the simulation mesh.
    mesh = UsdGeom.Mesh(stage.OverridePrim(prim.GetPath()))
    mesh.CreateFaceVertexCountsAttr(prim.GetAttribute("faceVertexCounts").Get())
    mesh.CreateFaceVertexIndicesAttr(prim.GetAttribute("faceVertexIndices").Get())
    animated = mesh.CreatePointsAttr()
    inverse = np.linalg.inv(matrix)
    count = len(prim.GetAttribute("points").Get())
    start = time.time()
    for frame in range(1, frames + 1):
        points = states[0].particle_q.numpy()[:count]
        if not np.isfinite(points).all():
            sys.exit(f"frame {frame} is not finite")
        local = points @ inverse[:3, :3] + inverse[3, :3]
        animated.Set(Vt.Vec3fArray.FromNumpy(local.astype(np.float32)), frame)
        for _ in range(substeps if frame < frames else 0):
            states[0].clear_forces()
            pipeline.collide(states[0], contacts)
            solver.step(states[0], states[1], control, contacts, 1 / fps / substeps)
            states.reverse()
        print(f"\rframe {frame} of {frames}, {(time.time() - start) / frame:.1f} s each", end="", flush=True)
    print()
    stage.GetRootLayer().Save()


def picture(shot, frames, focus):
    """Four frames of the render mesh in a row."""
    import draw
    from pxr import Usd
    stage = Usd.Stage.Open(str(shot))
    path = next(p.GetPath() for p in stage.Traverse() if p.GetCustomDataByKey("tailor:product") == "render")
    tiles, camera = [], None
    for frame in np.unique(np.linspace(1, frames, 4).round().astype(int)):
        meshes = draw.load(stage, [path], time=float(frame))
        camera = camera or draw.Camera.fit(meshes, "20,8", (420, 450), focus, margin=1.25)
        tiles.append((draw.render(meshes, camera, color="displayColor"), f"frame {frame}"))
    return draw.sheet([tiles])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("garment", nargs="?", default="coat")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--fps", type=float, default=24)
    parser.add_argument("--length", type=float, help="edge length of the simulation mesh [cm]")
    parser.add_argument("--level", type=int, default=2, help="subdivision level of the render mesh")
    parser.add_argument("--focus", help="ball to draw: x,y,z,radius")
    parser.add_argument("--usdtailor", default="usdtailor")
    parser.add_argument("--quick", action="store_true", help="fewer steps, for a test")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    built, cache, shot = (args.output / f"{name}.usdc" for name in ("built", "cache", "shot"))
    options = [f"render.level={args.level}", "cloth.scene=true", f"cloth.fabric={FABRICS.get(args.garment, 'cotton')}"]
    if args.garment in PINS:
        options.append(f"cloth.pins={PINS[args.garment]}")
    if args.length:
        options += [f"sim.maxEdgeLength={args.length}", f"sim.minEdgeLength={args.length}"]
    settings = [word for option in options for word in ("--set", option)]
    run(args.usdtailor, "build", GARMENTS.get(args.garment, args.garment), "-o", built, "--force", *settings)
    steps = dict(substeps=4, iterations=6) if args.quick else {}
    simulate(built, cache, args.frames, args.fps, **steps)
    run(args.usdtailor, "drive", built, "--cache", cache, "-o", shot, "--force")
    focus = [float(x) for x in args.focus.split(",")] if args.focus else None
    picture(shot, args.frames, focus).save(args.output / "strip.png")


if __name__ == "__main__":
    main()

"""Runs the scenes of the paper page and draws its pictures: python docs/pictures/paper.py GELFMU FOLDER

Into FOLDER go the runs, which are kept; the pictures are written beside this file. Needs matplotlib, pyvista and cargo.
Prints the table of one step for each group of elements against one for all.
"""

import json
import subprocess
import sys
from pathlib import Path

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pyvista as pv
from matplotlib.collections import PolyCollection
from matplotlib.colors import LightSource, ListedColormap, Normalize
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from PIL import Image, ImageChops

HERE = Path(__file__).parent
GLOBAL = ["--set", "integrator.schedule=global"]
FOUR_MESHES = [
    "--set", "projectile.velocity=[0,0,-30]", "--set", "remesh.method=immersed", "--set", "remesh.adaptive=false",
    "--set", "remesh.quality=0.01", "--set", "remesh.min_volume_ratio=0",
    "--set", "remesh.times=[0.4e-3,0.8e-3,1.2e-3,1.6e-3]",
]
RUNS = {
    "l-beam": ["l-beam"],
    "l-beam-global": ["l-beam", *GLOBAL],
    "l-beam-queue": ["l-beam", "--set", "integrator.schedule=queue"],
    "sphere-graded-4": ["sphere-graded-4"],
    "sphere-graded-4-global": ["sphere-graded-4", *GLOBAL],
    "ball-square": ["ball-square"],
    "ball-square-global": ["ball-square", *GLOBAL],
    "ball-square-remeshed": ["ball-square", *FOUR_MESHES],
    "ball-square-remeshed-global": ["ball-square", *FOUR_MESHES, *GLOBAL],
}
BLUE, ORANGE, GREY = "#0072B2", "#D55E00", "#8a8f98"
AMBER = ListedColormap(["#f0b24a"])


class Run:
    """A finished run: its folder, its summary and its frames."""

    def __init__(self, folder):
        self.folder = folder
        self.summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        self.history = pd.read_csv(folder / "history.csv")
        self.frames = sorted((folder / "frames").glob("frame_*.vtu"))

    def gel(self, number):
        return pv.read(self.frames[number])

    def body(self, number):
        return pv.read(self.folder / "frames" / self.frames[number].name.replace("frame", "projectile"))

    def time(self, number):
        return float(self.gel(number).field_data["TimeValue"][0])


def compute(gelfmu, folder):
    """Run what is not there yet."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, words in RUNS.items():
        if not (folder / name / "summary.json").exists():
            subprocess.run([gelfmu, "--quiet", "run", *words, "--threads", "1", "--no-report", "--out", name],
                           cwd=folder)
    steps = folder / "remesh-steps.json"
    if not steps.exists():
        manifest = HERE.parents[1] / "studies" / "Cargo.toml"
        program = ["cargo", "run", "--quiet", "--release", "--manifest-path", manifest, "--bin", "remesh-steps"]
        printed = subprocess.run(program, check=True, stdout=subprocess.PIPE).stdout
        json.loads(printed)
        steps.write_bytes(printed)
    return {name: Run(folder / name) for name in RUNS}


def save(figure, name):
    """Write a picture without margins and of few colours, which keeps it small."""
    file = HERE / f"{name}.png"
    figure.savefig(file, dpi=115, bbox_inches="tight", pad_inches=0.05)
    plt.close(figure)
    picture = Image.open(file).convert("RGB")
    left, top, right, bottom = ImageChops.difference(picture, Image.new("RGB", picture.size, "white")).getbbox()
    right, bottom = min(right + 6, picture.width), min(bottom + 6, picture.height)
    picture = picture.crop((max(left - 6, 0), max(top - 6, 0), right, bottom))
    picture.quantize(160).save(file, optimize=True)


def surface(mesh, values, axes, norm, colours, view, edges=0.15):
    """Draw the surface of a spatial mesh with the values of its cells."""
    skin = mesh.extract_surface(algorithm="dataset_surface")
    triangles = skin.points[skin.faces.reshape(-1, 4)[:, 1:]]
    drawn = colours(norm(np.asarray(values)[skin["vtkOriginalCellIds"]]))
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None] + 1e-300
    light = 0.72 + 0.28 * np.abs(normals @ np.array([0.3, -0.6, 0.75]))
    drawn[:, :3] = np.clip(drawn[:, :3] * light[:, None], 0, 1)
    axes.add_collection3d(Poly3DCollection(triangles, facecolors=drawn, edgecolors=(0, 0, 0, 0.35), linewidths=edges))
    frame(axes, mesh.points, view)


def frame(axes, points, view):
    """Equal axes around points, none drawn."""
    low, high = points.min(axis=0), points.max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=1.0)
    axes.view_init(*view)
    axes.set_axis_off()


def flat(mesh, axes, values=None, colours="viridis", width=0.15, **limits):
    """Draw a plane mesh in x and z; values of cells, or of points by their mean."""
    corners = mesh.cells_dict[5]
    points = mesh.points[:, [0, 2]] * 1e3
    if values is not None and len(values) == len(points):
        values = values[corners].mean(axis=1)
    filled = {"facecolors": "#dfe8f3"} if values is None else {"array": values, "cmap": colours}
    drawn = PolyCollection(points[corners], edgecolors=(0.1, 0.1, 0.2, 0.6), linewidths=width, **filled)
    drawn.set_clim(limits.get("low"), limits.get("high"))
    axes.add_collection(drawn)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set(xlabel="x, mm", ylabel="z, mm")
    return drawn


def disc(run, number, axes):
    """Draw the projectile of a plane run."""
    body = run.body(number)
    points = body.points[:, [0, 2]] * 1e3
    middle, radius = points.mean(axis=0), np.ptp(points[:, 0]) / 2
    axes.add_patch(plt.Circle(middle, radius, color=GREY, zorder=3))


def energy(run):
    """The energy that the integrator keeps, over that at the start, by time: less what contact and integration took."""
    history = run.history
    lost = history.energy_contact_J + history.energy_integration_J + history.energy_contact_bias_J
    return history.time_s * 1e3, 1 + lost / history.energy_kinetic_J[0]


def figure_2(runs):
    """The L-beam: its steps after the impact, and its energy."""
    run = runs["l-beam-queue"]
    figure = plt.figure(figsize=(9.6, 3.8))
    left = figure.add_axes((-0.06, -0.12, 0.6, 1.1), projection="3d")
    number = 12
    gel = run.gel(number)
    norm = Normalize(np.log2(gel["step"].min()), np.log2(gel["step"].max()))
    surface(gel, np.log2(gel["step"]), left, norm, plt.get_cmap("RdYlBu_r"), (18, -65))
    title = (f"step of each element after {1e3 * run.time(number):.0f} ms: "
             f"{1e6 * gel['step'].min():.0f} (blue) to {1e6 * gel['step'].max():.0f} µs (red)")
    figure.text(0.24, 0.93, title, fontsize=9, ha="center")
    right = figure.add_axes((0.6, 0.13, 0.39, 0.8))
    inset = right.inset_axes([0.2, 0.33, 0.77, 0.45])
    for axes in (right, inset):
        axes.plot(*energy(runs["l-beam-queue"]), color=GREY, lw=1, label="AVI, queue (the paper)")
        axes.plot(*energy(runs["l-beam"]), color=BLUE, lw=1.2, label="AVI, bins")
        axes.plot(*energy(runs["l-beam-global"]), color=ORANGE, lw=1.5, ls="--", label="one global step")
    right.set(xlabel="time, ms", ylabel="energy over that at the start", ylim=(0, 1.1))
    right.legend(loc="lower left", frameon=False, fontsize=8)
    inset.set(ylim=(0.9975, 1.0015))
    inset.tick_params(labelsize=7)
    save(figure, "paper-2")


def figure_4(runs):
    """The ball on the block: the block with its steps, and a cut through its middle with the speed."""
    run = runs["sphere-graded-4"]
    number = int(np.argmin([abs(run.time(i) - run.summary["time_of_peak_depth"]) for i in range(len(run.frames))]))
    gel, body = run.gel(number), run.body(number)
    figure = plt.figure(figsize=(9.6, 3.7))
    left = figure.add_axes((-0.08, -0.15, 0.6, 1.15), projection="3d", computed_zorder=False)
    levels = np.log2(gel["step"] / gel["step"].max())
    surface(gel, levels, left, Normalize(levels.min(), 0), plt.get_cmap("RdYlBu_r"), (32, -60), 0.08)
    skin = body.extract_surface(algorithm="dataset_surface")
    ball = skin.points[skin.faces.reshape(-1, 4)[:, 1:]]
    normals = np.cross(ball[:, 1] - ball[:, 0], ball[:, 2] - ball[:, 0])
    shade = LightSource(200, 60).shade_normals(normals / np.linalg.norm(normals, axis=1)[:, None])
    grey = plt.get_cmap("gray")(np.clip(0.35 + 0.5 * shade, 0, 1))
    left.add_collection3d(Poly3DCollection(ball, facecolors=grey, zorder=5))
    figure.text(0.22, 0.93, f"step of each element: {1e6 * gel['step'].min():.1f} (blue) to "
                f"{1e6 * gel['step'].max():.0f} µs (red)", fontsize=9, ha="center")
    right = figure.add_axes((0.52, 0.13, 0.46, 0.8))
    cut = gel.slice(normal="y", origin=(0, 1e-9, 0)).triangulate()
    corners = cut.faces.reshape(-1, 4)[:, 1:]
    points = cut.points[:, [0, 2]] * 1e3
    speed = np.linalg.norm(cut["velocity"], axis=1)[corners].mean(axis=1)
    drawn = PolyCollection(points[corners], array=speed, cmap="RdYlBu_r", edgecolors=(0, 0, 0, 0.3), linewidths=0.1)
    right.add_collection(drawn)
    points = body.points[:, [0, 2]] * 1e3
    right.add_patch(plt.Circle(body.points.mean(axis=0)[[0, 2]] * 1e3, np.ptp(points[:, 0]) / 2, color=GREY, zorder=3))
    right.set_aspect("equal")
    right.autoscale_view()
    right.set(xlabel="x, mm", ylabel="z, mm", title=f"cut through the middle, {1e3 * run.time(number):.2f} ms")
    right.title.set_fontsize(9)
    figure.colorbar(drawn, ax=right, label="speed of the gel, m/s", shrink=0.6)
    save(figure, "paper-4")


def figure_5(runs):
    """The disc in the square on its first mesh, just before an element is inverted."""
    run = runs["ball-square"]
    number = len(run.frames) - 1
    figure, axes = plt.subplots(1, 2, figsize=(9.6, 4.2))
    for one, width in zip(axes, (0.12, 0.4), strict=True):
        flat(run.gel(number), one, width=width)
        disc(run, number, one)
    deep = run.gel(number)
    worst = deep.extract_cells([int(np.argmin(deep["jacobian"]))]).center
    axes[0].set(xlim=(-30, 30), ylim=(-40, 20))
    axes[0].set_title(f"{1e3 * run.time(number):.3f} ms", fontsize=9)
    axes[1].set(xlim=(1e3 * worst[0] - 5, 1e3 * worst[0] + 5), ylim=(1e3 * worst[2] - 4, 1e3 * worst[2] + 6))
    axes[1].set_title(f"around the worst element, J = {deep['jacobian'].min():.2f}", fontsize=9)
    save(figure, "paper-5")


def figure_6(folder):
    """The steps of one remeshing, around the worst element."""
    steps = json.loads((folder / "remesh-steps.json").read_text(encoding="utf-8"))
    old, background, new = steps["old"], steps["background"], steps["new"]
    points = np.array(old["points"])
    window = 0.07 * np.ptp(points, axis=0).max()
    middle = points[old["triangles"][int(np.argmin(old["quality"]))]].mean(axis=0)
    figure, axes = plt.subplots(2, 3, figsize=(9.6, 6.6))

    def triangles(ax, mesh, values=None, **options):
        x, y = np.array(mesh["points"]).T
        if values is None:
            values, options = np.zeros(len(mesh["triangles"])), {"cmap": AMBER}
        shading = "flat" if len(values) == len(mesh["triangles"]) else "gouraud"
        ax.tripcolor(x, y, mesh["triangles"], values, shading=shading, **options)

    def edges(ax, mesh):
        ax.triplot(*np.array(mesh["points"]).T, mesh["triangles"], color="black", linewidth=0.3)

    (indicator, quadtree, delaunay), (distance, carved, velocity) = axes
    triangles(indicator, old, np.degrees(old["curvature"]), cmap="plasma", vmin=0, vmax=90)
    triangles(quadtree, old)
    squares = [
        [(x - h, y - h), (x + h, y - h), (x + h, y + h), (x - h, y + h)]
        for x, y, h in ((x, y, 0.5 * edge) for x, y, edge in steps["quadtree"])
    ]
    quadtree.add_collection(PolyCollection(squares, facecolors="none", edgecolors="black", linewidths=0.3))
    triangles(delaunay, old)
    edges(delaunay, background)
    triangles(distance, background, background["distance"], cmap="RdBu_r", vmin=-2 * window, vmax=2 * window)
    edges(distance, background)
    x, y = np.array(background["points"]).T
    distance.tricontour(x, y, background["triangles"], background["distance"], levels=[0.0], colors="black")
    triangles(carved, new)
    edges(carved, new)
    most = np.abs(new["velocity"]).max()
    triangles(velocity, new, new["velocity"], cmap="RdBu_r", vmin=-most, vmax=most)
    edges(velocity, new)
    titles = [
        "curvature indicator", "quadtree", "Delaunay triangulation",
        "signed distance", "the new mesh", "velocity, transferred",
    ]
    for letter, ax, title in zip("abcdef", axes.flat, titles, strict=True):
        ax.set(xlim=middle[0] + window * np.array([-1, 1]), ylim=middle[1] + window * np.array([-1, 1]), aspect="equal")
        ax.set_title(f"({letter}) {title}", fontsize=9)
        ax.set(xticks=[], yticks=[])
    figure.subplots_adjust(wspace=0.02, hspace=0.12)
    save(figure, "paper-6")


def figure_7(runs):
    """The disc in the square on five meshes in turn, the velocity along z."""
    run = runs["ball-square-remeshed"]
    moments = [0.35e-3, 0.75e-3, 1.15e-3, 1.95e-3]
    numbers = [int(np.argmin([abs(run.time(i) - t) for i in range(len(run.frames))])) for t in moments]
    figure, axes = plt.subplots(1, 4, figsize=(11, 3.6), sharey=True, layout="constrained")
    for one, number in zip(axes, numbers, strict=True):
        gel = run.gel(number)
        drawn = flat(gel, one, gel["velocity"][:, 2], "RdBu_r", 0.03, low=-30, high=30)
        disc(run, number, one)
        one.set_title(f"{1e3 * run.time(number):.2f} ms", fontsize=9)
        one.set(xlim=(-60, 60), ylim=(-102, 25))
    for one in axes[1:]:
        one.set_ylabel("")
    figure.colorbar(drawn, ax=axes, label="velocity along z, m/s", shrink=0.8)
    save(figure, "paper-7")


def comparison(runs):
    """Print the table of the two kinds of steps."""
    print("| scene | step | updates | wall time, s | depth, mm | energy defect |")
    print("|---|---|---|---|---|---|")
    for name, run in runs.items():
        if name.endswith("-queue"):
            continue
        one = run.summary
        kind = "one for all" if name.endswith("-global") else "each group its own"
        depth = f"{1e3 * one['peak_depth']:.3f}" if one["peak_depth"] else "–"
        print(f"| `{name.removesuffix('-global')}` | {kind} | {one['element_updates']:.2e} | "
              f"{one['wall_seconds']:.1f} | {depth} | {one['energy_defect']:.1e} |")


def main(gelfmu, folder):
    """Run, draw and tell."""
    runs = compute(str(Path(gelfmu).resolve()), folder)
    figure_2(runs)
    figure_4(runs)
    figure_5(runs)
    figure_6(folder)
    figure_7(runs)
    comparison(runs)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))

"""Draws the pictures of the gallery and the tutorials: python docs/pictures/gallery.py GELFMU FOLDER

Into FOLDER go the runs, which are kept; the pictures are written beside this file. Needs the Python package, with the
extra `frames`, and pillow.
"""

import subprocess
import sys
from pathlib import Path

import matplotlib

matplotlib.use("agg")
import ballistic_gel as bg
import matplotlib.pyplot as plt
from PIL import Image, ImageChops

HERE = Path(__file__).parent
# Name, words of the command, and the moment of the picture as a part of the run.
SHOTS = {
    "gallery-sphere-720": (["sphere-720", "--fidelity", "coarse"], 0.35),
    "gallery-backface": (["backface-dent"], 0.4),
    "gallery-recovered": (["xtp.toml", "--fidelity", "coarse"], 0.3),
    "gallery-ball-square": (["ball-square", "--set", "remesh.quality=0.3"], 0.8),
    "gallery-sphere-block": (["sphere-block"], 0.45),
    "gallery-l-beam": (["l-beam"], 0.12),
}


# Run of an expanding bullet, and the moments of its picture.
EXPANSION = ["expansion.toml", "--fidelity", "coarse", "--set", "scene.end_time=2e-4", "--set", "output.frames=21"]
MOMENTS = (0.0, 0.3, 0.5, 1.0)


def film(gelfmu, run, parts, file):
    """Write the pictures of a run's film at parts of its length side by side, without margins and small."""
    movie = run.with_suffix(".gif")
    if not movie.exists():
        subprocess.run([gelfmu, "--quiet", "movie", str(run), "--out", str(movie)], check=True)
    film = Image.open(movie)
    pictures = []
    for part in parts:
        film.seek(round(part * (film.n_frames - 1)))
        picture = film.convert("RGB")
        left, top, right, bottom = ImageChops.difference(picture, Image.new("RGB", picture.size, "white")).getbbox()
        right, bottom = min(right + 8, picture.width), min(bottom + 8, picture.height)
        pictures.append(picture.crop((max(left - 8, 0), max(top - 8, 0), right, bottom)))
    picture = Image.new("RGB", (sum(one.width for one in pictures), max(one.height for one in pictures)), "white")
    for i, one in enumerate(pictures):
        picture.paste(one, (sum(before.width for before in pictures[:i]), picture.height - one.height))
    picture.thumbnail((520 + 160 * (len(parts) - 1), 420))
    picture.quantize(256, method=Image.Quantize.MAXCOVERAGE).save(file, optimize=True)


def main(gelfmu, folder):
    """Run and draw."""
    folder.mkdir(parents=True, exist_ok=True)
    scene = folder / "xtp.toml"
    if not scene.exists():
        shot = ["--projectile", "45acp-230-xtp-recovered", "--block", "15x15x60cm", "--out", "xtp.toml"]
        subprocess.run([gelfmu, "new", *shot], cwd=folder, check=True)
    for name, (words, part) in SHOTS.items():
        if not (folder / name / "report.html").exists():
            subprocess.run([gelfmu, "--quiet", "run", *words, "--out", name], cwd=folder, check=True)
        film(gelfmu, folder / name, [part], HERE / f"{name}.png")
    expansion = folder / "expansion.toml"
    if not expansion.exists():
        shot = ["--projectile", "45acp-230-xtp", "--block", "9x9x12cm", "--out", expansion.name]
        subprocess.run([gelfmu, "new", *shot], cwd=folder, check=True)
    if not (folder / "gallery-expansion" / "report.html").exists():
        subprocess.run([gelfmu, "--quiet", "run", *EXPANSION, "--out", "gallery-expansion"], cwd=folder, check=True)
    film(gelfmu, folder / "gallery-expansion", MOMENTS, HERE / "gallery-expansion.png")
    shot = bg.run("fbi-bb", fidelity="draft", out=folder / "analyst", force=True, report=False)
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.2), layout="constrained")
    shot.plot.velocity_by_depth(ax=axes[0])
    shot.plot.wound_profile(ax=axes[1])
    shot.plot.energy(ax=axes[2])
    figure.savefig(HERE / "analyst-shot.png", dpi=90)
    picture = Image.open(HERE / "analyst-shot.png").convert("RGB")
    picture.quantize(128).save(HERE / "analyst-shot.png", optimize=True)


if __name__ == "__main__":
    main(str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]))

"""Runs the scenes of the gallery and of the tutorials, and draws their pictures: python docs/pictures/gallery.py GELFMU FOLDER

Into FOLDER go the runs, which are kept; the pictures are written beside this file. Needs the Python package, with the
extra `frames`, and pillow.
"""

import base64
import io
import re
import subprocess
import sys
from pathlib import Path

import matplotlib

matplotlib.use("agg")
import ballistic_gel as bg
import matplotlib.pyplot as plt
from PIL import Image

HERE = Path(__file__).parent
# Name, words of the command, and which picture of the film in its report.
SHOTS = {
    "gallery-sphere-720": (["sphere-720", "--fidelity", "coarse"], 12),
    "gallery-backface": (["backface-dent"], 20),
    "gallery-recovered": (["xtp.toml", "--fidelity", "coarse"], 12),
    "gallery-ball-square": (["ball-square", "--set", "remesh.quality=0.3"], 30),
    "gallery-sphere-block": (["sphere-block"], 19),
    "gallery-l-beam": (["l-beam"], 8),
}


def film(report, number, file):
    """Write one picture of the film of a report, small."""
    pictures = re.findall(r"data:image/png;base64,([A-Za-z0-9+/=]+)", report.read_text(encoding="utf-8"))
    picture = Image.open(io.BytesIO(base64.b64decode(pictures[min(number, len(pictures) - 1)]))).convert("RGB")
    picture.thumbnail((560, 560))
    picture.quantize(128).save(file, optimize=True)


def main(gelfmu, folder):
    """Run and draw."""
    folder.mkdir(parents=True, exist_ok=True)
    scene = folder / "xtp.toml"
    if not scene.exists():
        shot = ["--projectile", "45acp-230-xtp-recovered", "--block", "15x15x60cm", "--out", "xtp.toml"]
        subprocess.run([gelfmu, "new", *shot], cwd=folder, check=True)
    for name, (words, number) in SHOTS.items():
        if not (folder / name / "report.html").exists():
            subprocess.run([gelfmu, "--quiet", "run", *words, "--out", name], cwd=folder, check=True)
        film(folder / name / "report.html", number, HERE / f"{name}.png")
    shot = bg.run("fbi-bb", fidelity="draft", out=folder / "analyst", force=True)
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.2), layout="constrained")
    shot.plot.velocity_by_depth(ax=axes[0])
    shot.plot.wound_profile(ax=axes[1])
    shot.plot.energy(ax=axes[2])
    figure.savefig(HERE / "analyst-shot.png", dpi=90)
    picture = Image.open(HERE / "analyst-shot.png").convert("RGB")
    picture.quantize(128).save(HERE / "analyst-shot.png", optimize=True)


if __name__ == "__main__":
    main(str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]))

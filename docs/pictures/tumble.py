"""Makes the pictures of a tumbling bullet: python docs/pictures/tumble.py GELFMU FOLDER

Runs an M80 ball of 840 m/s at `draft` into FOLDER, some three minutes on one core, and writes the moving picture of the
landing page and the three pictures of the README beside this file. Needs Pillow.
"""

import subprocess
import sys
from pathlib import Path

from PIL import Image

HERE = Path(__file__).parent
SHOT = ["--projectile", "762-m80", "--speed", "840", "--yaw", "4", "--block", "0.15x0.15x0.3"]
RUN = ["--fidelity", "draft", "--threads", "1", "--set", "scene.end_time=8e-4", "--set", "output.frames=40"]
# Part of each picture that shows the block.
BOX = (280, 60, 700, 770)
# Frames, 20 µs apart: of the moving picture, and of the README.
MOVING, STILL = range(29), (6, 9, 18)


def main(gelfmu, folder):
    """Run the shot if it is not there yet, and write the pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    scene, run, film = folder / "m80.toml", folder / "m80", folder / "m80.gif"
    if not scene.exists():
        subprocess.run([gelfmu, "--quiet", "new", *SHOT, "--out", scene], check=True)
    if not (run / "summary.json").exists():
        subprocess.run([gelfmu, "--quiet", "run", scene, *RUN, "--no-report", "--out", run], check=True)
    subprocess.run([gelfmu, "--quiet", "movie", run, "--force", "--out", film], check=True)
    frames = []
    with Image.open(film) as pictures:
        for number in MOVING:
            pictures.seek(number)
            frames.append(pictures.convert("RGB").crop(BOX).resize((320, 541)))
    first, *others = frames
    timing = {"duration": 125, "loop": 0}
    first.save(HERE / "m80.webp", save_all=True, append_images=others, quality=70, method=6, **timing)
    for number, frame in enumerate(STILL, 1):
        frames[frame].resize((280, 473)).quantize(160).save(HERE / f"m80-{number}.png", optimize=True)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))

"""Writes pictures of the film of a report as PNG files: python docs/pictures/film.py REPORT.html NAME NUMBER...

Those of the README: `gelfmu run fbi-bb`, then `python docs/pictures/film.py gelfmu-out/fbi-bb/report.html fbi-bb 3 5 21`.
"""

import base64
import re
import sys
from pathlib import Path

report, name, *numbers = sys.argv[1:]
pictures = re.findall(r"data:image/png;base64,([A-Za-z0-9+/=]+)", Path(report).read_text(encoding="utf-8"))
for i, number in enumerate(numbers, 1):
    Path(__file__).with_name(f"{name}-{i}.png").write_bytes(base64.b64decode(pictures[int(number)]))
